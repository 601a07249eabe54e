"""Worlds whose vertical axis is another one than z, turned so that z points up."""

from __future__ import annotations

from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
Axis = Literal["z", "-z", "y", "-y", "x", "-x"]
AXES: tuple[Axis, ...] = get_args(Axis)

_TURNS: dict[Axis, tuple[tuple[int, int, int], ...]] = {
    "z": ((1, 0, 0), (0, 1, 0), (0, 0, 1)),
    "-z": ((1, 0, 0), (0, -1, 0), (0, 0, -1)),
    "y": ((1, 0, 0), (0, 0, -1), (0, 1, 0)),
    "-y": ((1, 0, 0), (0, 0, 1), (0, -1, 0)),
    "x": ((0, 0, -1), (0, 1, 0), (1, 0, 0)),
    "-x": ((0, 0, 1), (0, 1, 0), (-1, 0, 0)),
}


def upright(up: Axis) -> FloatArray:
    """R, (3, 3), proper: x -> R x turns the axis that points up into z; another axis stays where it is."""
    return np.array(_TURNS[up], dtype=np.float64)


def upright_words(up: Axis) -> str:
    """How the turned world lies in the one before."""
    if up == "z":
        return "as calibrated, z up"
    rows = [_word(row) for row in _TURNS[up]]
    return f"z up; its x, y, z are {rows[0]}, {rows[1]}, {rows[2]} of the calibration, whose {up} points up"


def _word(row: tuple[int, int, int]) -> str:
    axis = next(k for k, weight in enumerate(row) if weight)
    return ("-" if row[axis] < 0 else "") + "xyz"[axis]
