"""How far the yaw torque is a straight line: N = slope x + cubic x^3, over the yaw rate and over the paddling angle.

Yaw: where the rate exceeds the wing's own, near reversals, drag is no longer the difference of two squares. For a plate
that reverses with phi'' that adds the cubic share 2 f psi'^2 / (3 |phi''| <|phi'|>). Paddling: C_D is a cosine of the
attack angle.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from flycontrol.errors import InvalidParameterError
from flycontrol.reduce.yaw_torque import YawExperiment, yaw_slopes
from flycontrol.units import deg

FloatArray = NDArray[np.float64]

DEPARTURE = 0.05  #: from the straight line, where the linear range ends
_RATES = np.arange(20.0, 1001.0, 20.0)  # [rad/s], up to about the speed of the wings; a fast saccade has 30
_ANGLES = np.arange(1.0, 31.0) * deg


@dataclass(frozen=True, slots=True, kw_only=True)
class TorqueCurve:
    """The odd part of the mean yaw torque over an input: yaw rate [rad/s] or paddling angle [rad]."""

    inputs: FloatArray  #: (n,) rising, > 0
    torque: FloatArray  #: (n,) (N(x) - N(-x)) / 2 [N m]
    slope: float  #: at zero [N m per unit of the input]
    cubic: float  #: of N = slope x + cubic x^3 over the lowest third of the inputs, least squares
    linear_range: float  #: where the torque first leaves its line by 5 %; the last input if it never does
    leaves: bool  #: whether it does

    def share_of_cubic(self, x: float) -> float:
        """cubic x^2 / slope: what the cubic part adds to the straight line at an input [1]."""
        return self.cubic * x**2 / self.slope


def damping_curve(experiment: YawExperiment, rates: ArrayLike = _RATES) -> TorqueCurve:
    """Torque over the yaw rate; its slope is -beta.

    Parameters
    ----------
    rates : (n,) rising yaw rates > 0 [rad/s]
    """
    return _curve(lambda rate: experiment.torque(yaw_rate=rate), rates, -yaw_slopes(experiment).damping)


def paddling_curve(experiment: YawExperiment, angles: ArrayLike = _ANGLES) -> TorqueCurve:
    """Torque over the paddling angle; its slope is gamma.

    Parameters
    ----------
    angles : (n,) rising d_alpha > 0 [rad]
    """
    return _curve(lambda angle: experiment.torque(d_alpha=angle), angles, yaw_slopes(experiment).paddling)


def _curve(torque: Callable[[float], float], inputs: ArrayLike, slope: float) -> TorqueCurve:
    x = np.asarray(inputs, dtype=np.float64)
    if not (x.ndim == 1 and len(x) >= 3 and x[0] > 0 and np.all(np.diff(x) > 0)):
        raise InvalidParameterError("A torque curve needs at least three rising inputs > 0.")
    odd = np.array([(torque(float(v)) - torque(-float(v))) / 2 for v in x])
    off = odd / (slope * x) - 1.0
    low = slice(0, max(3, len(x) // 3))
    cubic = slope * float(np.sum(off[low] * x[low] ** 2) / np.sum(x[low] ** 4))
    beyond = np.flatnonzero(np.abs(off) > DEPARTURE)
    return TorqueCurve(
        inputs=x,
        torque=odd,
        slope=slope,
        cubic=cubic,
        linear_range=_crossing(x, np.abs(off), int(beyond[0])) if beyond.size else float(x[-1]),
        leaves=bool(beyond.size),
    )


def _crossing(x: FloatArray, off: FloatArray, first: int) -> float:
    """Between the last input within and the first one beyond; below the first input the departure is zero at zero."""
    before = (x[first - 1], off[first - 1]) if first else (0.0, 0.0)
    return float(np.interp(DEPARTURE, [before[1], off[first]], [before[0], x[first]]))
