"""Modes of flight near a steady state: exponents, shapes, and names by what takes part in them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

#: Which coordinates (see `body_coordinates`) make which motion.
_MOTIONS: dict[str, tuple[int, ...]] = {
    "pitch and fore-aft": (0, 4, 7),
    "vertical": (2,),
    "roll and sideways": (1, 3, 6),
    "yaw": (5,),
}


@dataclass(frozen=True, slots=True, kw_only=True)
class FlightMode:
    """x(t) = Re(shape exp(exponent t)); of a conjugate pair the one that turns forward."""

    name: str  #: what moves most, and how
    exponent: complex  #: [1/s]
    shape: ComplexArray  #: (8,) u, v, w, p, q, r, phi, theta in natural units (R f, f, rad), length 1
    participation: FloatArray  #: (8,) share of each coordinate, sum 1: |left eigenvector * right eigenvector|

    @property
    def doubling_time(self) -> float:
        """ln 2 / Re: time to double, < 0: to halve [s]."""
        return float(np.log(2) / self.exponent.real)

    @property
    def stable(self) -> bool:
        """Whether it decays."""
        return self.exponent.real < 0


def flight_modes(exponents: ComplexArray, vectors: ComplexArray) -> tuple[FlightMode, ...]:
    """Name eigenvalues (8,) with right eigenvectors (8, 8) in natural units; fastest growth first, pairs once."""
    shares = np.abs(np.linalg.inv(vectors).T * vectors)
    shares /= shares.sum(axis=0)
    modes = [
        FlightMode(
            name=_name(complex(exponents[k]), shares[:, k]),
            exponent=complex(exponents[k]),
            shape=vectors[:, k] / np.linalg.norm(vectors[:, k]),
            participation=shares[:, k],
        )
        for k in np.argsort(-exponents.real)
        if exponents[k].imag >= 0
    ]
    return tuple(modes)


def modes_of_generator(matrix: FloatArray, scales: FloatArray) -> tuple[FlightMode, ...]:
    """Modes of x' = A x, A (8, 8) in SI units, `scales` (8,) the natural ones."""
    exponents, vectors = np.linalg.eig(matrix * scales / scales[:, None])
    return flight_modes(exponents.astype(np.complex128), vectors.astype(np.complex128))


def _name(exponent: complex, share: FloatArray) -> str:
    motion = max(_MOTIONS, key=lambda name: float(share[list(_MOTIONS[name])].sum()))
    if exponent.imag != 0:
        return f"{motion} {'growing' if exponent.real > 0 else 'decaying'} oscillation"
    return f"{motion} {'divergence' if exponent.real > 0 else 'subsidence'}"
