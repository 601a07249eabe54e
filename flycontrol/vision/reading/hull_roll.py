"""The roll of a fly by the lines along its wings, since a body of revolution has none of its own."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from flycontrol.units import deg
from flycontrol.vision.fly_shape import FlyShape

FloatArray = NDArray[np.float64]

#: Span lines miss the bases by so much, in wing lengths; roll changes by so much from frame to frame, lag included (C)
_OFF_LINE, _ROLL_BETWEEN = 0.03, 5 * deg
_ANGLES = np.arange(-60, 61) * deg / 2
_COS, _SIN = np.cos(_ANGLES), np.sin(_ANGLES)


def roll_by_spans(spans_B: FloatArray, bases_B: FloatArray, shape: FlyShape, found: tuple[bool, bool]) -> FloatArray:
    """(3, 3) the turn about the long axis that brings the bases of the shape nearest to the lines along the spans.

    min over r of sum log(1 + |(1 - s s^T) (Rx(r) b - b')|^2 / d^2) + r^2 / e^2 over the wings found: how far along its
    span a wing begins the hull cannot tell, and a span read wrongly shall not turn the fly.

    Parameters
    ----------
    spans_B : (2, 3) s of the left and the right wing, unit vectors
    bases_B : (2, 3) b', any points on the lines [m]
    shape : its wings grow at b
    found : whether each wing is known
    """
    bx, by, bz = shape.right_base_B
    cost = (_ANGLES / _ROLL_BETWEEN) ** 2
    for k in (0, 1):
        if not found[k]:
            continue
        side, away = by * (2 * k - 1), bases_B[k]
        x, y, z = bx - away[0], side * _COS - bz * _SIN - away[1], side * _SIN + bz * _COS - away[2]
        along = spans_B[k, 0] * x + spans_B[k, 1] * y + spans_B[k, 2] * z
        cost += np.log1p((x * x + y * y + z * z - along**2) / (_OFF_LINE * float(shape.wing[-1, 0])) ** 2)
    best = float(_ANGLES[np.argmin(cost)])
    return np.array([[1.0, 0.0, 0.0], [0.0, np.cos(best), -np.sin(best)], [0.0, np.sin(best), np.cos(best)]])
