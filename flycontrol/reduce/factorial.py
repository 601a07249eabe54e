"""Effects of three asymmetries on a quantity v that is known for all eight versions of a motion.

    v(S) = v(none) + sum of m(A) over all non-empty A within S        main effects and interactions: S, A sets of angles
    alone_k = m({k}) = v({k}) - v(none)
    all but one_k = v(all) - v(all without k) = sum of m(A) over A with k
    shapley_k = sum of m(A) / |A| over A with k                       the mean of k's effect over all orders

Shapley's effects add up to v(all) - v(none); effects alone miss the interactions, all but one count them repeatedly.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flycontrol.errors import InvalidParameterError
from flycontrol.model.stroke import ANGLES
from flycontrol.model.symmetrised import VERSIONS

FloatArray = NDArray[np.float64]

_SIZE = np.array([len(kept) for kept in VERSIONS])
_WITHIN = np.array([[set(a) <= set(s) for a in VERSIONS] for s in VERSIONS])  # [S, A]: whether A is part of S
_INTERACTIONS = np.where(_WITHIN, (-1.0) ** np.subtract.outer(_SIZE, _SIZE), 0.0)  # [A, S]: Moebius's inversion
_HOLDS = np.array([[angle in kept for kept in VERSIONS] for angle in ANGLES])  # [k, A]: whether angle k is in A


@dataclass(frozen=True, slots=True, kw_only=True)
class Factorial:
    """The eight values and what they say; arrays may have leading axes, such as wingbeats or draws."""

    values: FloatArray  #: (..., 8) in the order of `VERSIONS`, any unit

    def __post_init__(self) -> None:
        if self.values.ndim < 1 or self.values.shape[-1] != len(VERSIONS):
            raise InvalidParameterError(
                f"A factorial of three angles needs eight values along its last axis, got shape {self.values.shape}."
            )

    @property
    def symmetric(self) -> FloatArray:
        """v(none), (...)."""
        return self.values[..., 0]

    @property
    def total(self) -> FloatArray:
        """v(all) - v(none), (...): what there is to attribute."""
        return self.values[..., -1] - self.values[..., 0]

    @property
    def effects(self) -> FloatArray:
        """m(A) of every set of angles, (..., 8) in the order of `VERSIONS`; the first is v(none)."""
        return self.values @ _INTERACTIONS.T

    @property
    def alone(self) -> FloatArray:
        """Stroke, deviation, pitch: what each does alone, (..., 3)."""
        return self.effects[..., _SIZE == 1]

    @property
    def all_but_one(self) -> FloatArray:
        """Stroke, deviation, pitch: what is lost when it alone is symmetrised, (..., 3)."""
        return self.effects @ _HOLDS.T.astype(float)

    @property
    def shapley(self) -> FloatArray:
        """Stroke, deviation, pitch: mean over the six orders of keeping one angle after another, (..., 3)."""
        return self.effects @ (_HOLDS / np.maximum(_SIZE, 1)).T

    @property
    def interaction(self) -> FloatArray:
        """Total less the effects alone, (...)."""
        return self.effects[..., _SIZE > 1].sum(axis=-1)
