"""The H2 norm: the energy of the impulse response, by an exact integral over frequency and a tail in closed form."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import scipy.special

from flycontrol.delay.expansion import DelaySum, Expansion, expansion
from flycontrol.delay.frequency_domain import FrequencyDomain, frequency_domain
from flycontrol.delay.panels import Panels
from flycontrol.delay.peak_gain import require_stable
from flycontrol.delay.real import real_number
from flycontrol.delay.system import FloatArray
from flycontrol.errors import InvalidParameterError

if TYPE_CHECKING:
    from flycontrol.delay.convert import Operand


@dataclass(frozen=True, slots=True, kw_only=True)
class H2Norm:
    """The square root of the sum of the energies of all impulse responses."""

    value: float  #: inf with any feedthrough
    error: float  #: bound on the error of the value
    status: str  #: "certified" when the bound keeps to the tolerance, or a sentence


def h2_norm(system: Operand, tol: float = 1e-8) -> H2Norm:
    """||G||_2^2 = 1 / (2 pi) * integral of tr G(j w)^H G(j w) dw over all w, for a stable system.

    On panels of the frequency axis G is a polynomial with a proven error, integrated exactly. Beyond the last panel
    G = H1 / s + H2 / s^2 + R: the first two terms are sums of delays over powers of s, integrated in closed form, and R
    is bounded. The panels reach so far that the bound keeps the relative error of the norm below `tol`.

    Raises
    ------
    InvalidParameterError
        If the tolerance is not in [1e-11, 1).
    UnstableSystemError
        If the system is not stable.
    NeutralSystemError
        If a delay feeds back into itself without passing a state.
    """
    tol = real_number(tol, "The tolerance of a norm")
    if not 1e-11 <= tol < 1:
        raise InvalidParameterError(f"The tolerance of a norm must lie in [1e-11, 1), got {tol!r}.")
    it = frequency_domain(system)
    require_stable(it)
    at_infinity = expansion(it.system)
    if not at_infinity.feedthrough.is_zero:
        return H2Norm(
            value=np.inf, error=0.0,
            status="infinite: the input reaches the output directly, delayed or not, so that an impulse passes whole",
        )  # fmt: skip
    low, top = 0.0, 8.0 * max([it.far.slowest, *(1.0 / it.system.tau), 1e-12])
    energy, error = 0.0, 0.0
    while True:
        part, slack = _energy(it.panels(low, top))
        energy, error = energy + part, error + slack
        tail, doubt = _tail(at_infinity, top), _tail_error(it, top)
        total = energy + tail
        if doubt <= tol * total or not it.affordable(4.0 * top):
            break
        low, top = top, 4.0 * top
    value = float(np.sqrt(max(total, 0.0)))
    bound = (error + doubt) / max(2.0 * value, 1e-300) if value > 0 else float(np.sqrt(error + doubt))
    status = "certified" if bound <= tol * value or value == 0.0 else f"bounded only: the error is at most {bound:.2g}"
    return H2Norm(value=value, error=bound, status=status)


def _energy(pieces: Panels) -> tuple[float, float]:
    """Integral of ||G||_F^2 / pi over the panels, and a bound on its error."""
    order = pieces.series.shape[1]
    k = np.arange(order)
    even = (k[:, None] + k) % 2 == 0
    moments = np.where(even, 2.0 / (k[:, None] + k + 1), 0.0)  # integrals of u^(k + l) over [-1, 1]
    flat = pieces.series.reshape(len(pieces), order, -1)
    half = np.abs(pieces.half)
    parts = half * np.einsum("Pke,kl,Ple->P", flat, moments, flat.conj()).real
    sizes = np.sqrt((np.abs(flat).sum(axis=1) ** 2).sum(axis=1))
    slack = 2.0 * half * (2.0 * sizes + pieces.error) * pieces.error
    return float(parts.sum() / np.pi), float(slack.sum() / np.pi)


def _tail(at_infinity: Expansion, top: float) -> float:
    """Integral from `top` on of (||H1||^2 / w^2 + 2 Im tr(H1^H H2) / w^3) / pi, both almost periodic in w."""
    squares = _integral(at_infinity.first, at_infinity.first, top, 2).real
    mixed = _integral(at_infinity.first, at_infinity.second, top, 3).imag
    return float((squares + 2.0 * mixed) / np.pi)


def _integral(left: DelaySum, right: DelaySum, top: float, power: int) -> complex:
    """Integral of tr(left^H right) / w^power from `top` to infinity: exponential integrals of every pair of delays."""
    weights = np.einsum("kab,lab->kl", left.matrices, right.matrices)
    delta = left.theta[:, None] - right.theta
    return complex((weights * _oscillating(delta, top, power)).sum())


def _oscillating(delta: FloatArray, top: float, power: int) -> np.ndarray:
    """Integral of exp(j w delta) / w^power from `top` to infinity: top^(1 - power) E_power(-j top delta)."""
    z = -1j * top * np.where(delta == 0, 1.0, delta)
    found = scipy.special.exp1(z)
    for m in range(1, power):
        found = (np.exp(-z) - z * found) / m
    return np.where(delta == 0, 1.0 / (power - 1), found) * top ** (1.0 - power)


def _tail_error(it: FrequencyDomain, top: float) -> float:
    """Bound on what `_tail` leaves out: |R| <= C A^2 (w I - A)^-1 B / w^2 with the bounds of the asymptote."""
    far = it.far
    if len(far.A) == 0 or top <= far.slowest:
        return 0.0 if len(far.A) == 0 else np.inf
    first = float(np.linalg.norm(far.C @ far.B))
    second = float(np.linalg.norm(far.C @ far.A @ far.B))
    inverse = np.linalg.solve(top * np.eye(len(far.A)) - far.A, far.B)
    third = top * float(np.linalg.norm(far.C @ far.A @ far.A @ inverse))
    fourth = (second**2 + 2.0 * first * third) / (3.0 * top**3)
    return (fourth + 2.0 * second * third / (4.0 * top**4) + third**2 / (5.0 * top**5)) / np.pi
