"""Disk margins: how much gain and phase may change together, without and with regard to their signs."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from flycontrol.delay.frequency import require_siso
from flycontrol.delay.frequency_domain import frequency_domain
from flycontrol.delay.peak_gain import hinf_norm
from flycontrol.delay.real import real_number
from flycontrol.delay.sensitivity import sensitivity
from flycontrol.errors import InvalidParameterError, UnstableSystemError

if TYPE_CHECKING:
    from flycontrol.delay.convert import Operand


@dataclass(frozen=True, slots=True, kw_only=True)
class DiskMargins:
    """The loop f L stays stable for every f = (1 + (1 - skew)/2 d) / (1 - (1 + skew)/2 d) with |d| < disk_margin.

    Seiler, Packard and Gahinet, An introduction to disk margins, IEEE Control Systems Magazine 40(5), 2020.
    """

    disk_margin: float  #: alpha, a lower bound within the tolerance
    lowest_gain: float  #: real factors on L above this one and below `highest_gain` leave the loop stable
    highest_gain: float  #: inf if all do
    phase_margin: float  #: phase lags and leads below this one do [rad]; pi if all do
    frequency: float  #: where alpha is reached [rad/s]; inf if only approached
    skew: float  #: 0: gain may rise as much as fall; > 0: rise more, < 0: fall more


def disk_margins(loop: Operand, skew: float = 0.0, tol: float = 1e-6) -> DiskMargins:
    """alpha = 1 / ||S + (skew - 1) / 2||_inf and what it guarantees, for a stable loop under negative unit feedback.

    skew = 0 weighs S and T alike, 1 is the modulus margin 1 / ||S||, -1 is 1 / ||T||.

    Raises
    ------
    InvalidParameterError
        If the loop has more than one input or output, or the skew is not finite.
    UnstableSystemError
        If the closed loop is unstable.
    """
    skew = real_number(skew, "The skew of a disk")
    if not np.isfinite(skew):
        raise InvalidParameterError(f"The skew of a disk must be a finite number, got {skew!r}.")
    S = sensitivity(loop)
    require_siso(S)
    poles = frequency_domain(S).poles
    if poles.unstable or poles.on_axis:
        raise UnstableSystemError(
            f"The closed loop is not stable ({poles.unstable} pole(s) with Re s > 0, {len(poles.on_axis)} on the "
            "imaginary axis), so no change of gain and phase leaves it stable: it has no disk margin. Stabilise it "
            "first."
        )
    peak = hinf_norm(replace(S, D11=S.D11 + 0.5 * (skew - 1.0)), tol)
    alpha = 1.0 / peak.upper if peak.upper > 0 else np.inf
    down, up = 0.5 * alpha * (1.0 - skew), 0.5 * alpha * (1.0 + skew)
    return DiskMargins(
        disk_margin=alpha,
        lowest_gain=(1.0 - down) / (1.0 + up),
        highest_gain=(1.0 + down) / (1.0 - up) if up < 1 else np.inf,
        phase_margin=_phase(alpha, skew),
        frequency=peak.frequency,
        skew=skew,
    )


def _phase(alpha: float, skew: float) -> float:
    """The angle at which the disk's edge meets the unit circle: |f - 1| = alpha |(1 + skew)/2 f + (1 - skew)/2|."""
    cosine = (2.0 - 0.5 * alpha**2 * (1.0 + skew**2)) / (2.0 + 0.5 * alpha**2 * (1.0 - skew**2))
    return float(np.arccos(np.clip(cosine, -1.0, 1.0)))
