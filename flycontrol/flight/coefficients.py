"""Lift and drag coefficients of a wing in a steady sweep, over the attack angle, by name."""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from flycontrol.units import deg

FloatArray = NDArray[np.float64]
CoefficientName = Literal["dickinson1999", "wang2004", "whitney2010"]


class LiftDrag(NamedTuple):
    """C_L and C_D [1], of the shape of the attack angle."""

    lift: FloatArray
    drag: FloatArray


def dickinson1999(attack: FloatArray) -> LiftDrag:
    """C_L = 0.225 + 1.58 sin(2.13 a - 7.2), C_D = 1.92 - 1.55 cos(2.04 a - 9.82), a in deg from 0 to 90.

    Dickinson, Lehmann & Sane 1999, robotic fruit-fly wing.
    """
    a = attack / deg
    return LiftDrag(
        lift=0.225 + 1.58 * np.sin((2.13 * a - 7.2) * deg),
        drag=1.92 - 1.55 * np.cos((2.04 * a - 9.82) * deg),
    )


def wang2004(attack: FloatArray) -> LiftDrag:
    """C_L = 1.2 sin 2a, C_D = 1.4 - cos 2a.  Wang, Birch & Dickinson 2004; a from 0 to 90 deg [rad]."""
    return LiftDrag(lift=1.2 * np.sin(2 * attack), drag=1.4 - np.cos(2 * attack))


def whitney2010(attack: FloatArray) -> LiftDrag:
    """C_L = 1.8 sin 2a, C_D = 1.9 - 1.5 cos 2a.  Whitney & Wood 2010, second hand; a from 0 to 90 deg [rad].

    Dickinson's measurements in the form of a flat plate: no lift at 0 and 90 deg, drag from 0.4 to 3.4.
    """
    return LiftDrag(lift=1.8 * np.sin(2 * attack), drag=1.9 - 1.5 * np.cos(2 * attack))


COEFFICIENTS: dict[CoefficientName, Callable[[FloatArray], LiftDrag]] = {
    "dickinson1999": dickinson1999,
    "wang2004": wang2004,
    "whitney2010": whitney2010,
}
