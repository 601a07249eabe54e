"""Stroke kinematics as TOML text; what is written reads back equal, to the last bit."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import fields

import numpy as np

from flycontrol.errors import InvalidInputError
from flycontrol.io.quantities import ANGLE, FREQUENCY
from flycontrol.io.quantity_text import quantity_text
from flycontrol.model.stroke_kinematics import StrokeKinematics
from flycontrol.model.wing_stroke import BermanWangStroke, FourierStroke, WingStroke

_NUMBERS = ("stroke_shape", "pitch_shape", "deviation_order")  #: without unit


def stroke_text(kinematics: StrokeKinematics) -> str:
    """Text that `flycontrol.io.stroke_files.read_stroke` reads back, of strokes by a family's parameters or by series.

    Raises
    ------
    InvalidInputError
        If a stroke is of samples or modulated.
    """
    lines = [f'frequency = "{quantity_text(kinematics.frequency, FREQUENCY, "Hz")}"']
    if kinematics.left is kinematics.right:
        return "\n".join([*lines, *_table("both", kinematics.left)]) + "\n"
    return "\n".join([*lines, *_table("left", kinematics.left), *_table("right", kinematics.right)]) + "\n"


def _table(name: str, stroke: WingStroke) -> list[str]:
    if isinstance(stroke, BermanWangStroke):
        return ["", f"[{name}]", 'kind = "Berman and Wang"', *_parameters(stroke)]
    if isinstance(stroke, FourierStroke):
        return ["", f"[{name}]", 'kind = "Fourier"', *_series(stroke)]
    raise InvalidInputError(
        f"A {type(stroke).__name__} is not written as TOML; BermanWangStroke and FourierStroke are: fit one to it."
    )


def _parameters(stroke: BermanWangStroke) -> Iterator[str]:
    for field in fields(stroke):
        value = getattr(stroke, field.name)
        yield f"{field.name} = {value!r}" if field.name in _NUMBERS else f"{field.name} = {_angle(value)}"


def _series(stroke: FourierStroke) -> Iterator[str]:
    for name, cosine, sine in zip(("stroke", "deviation", "pitch"), stroke.cosine, stroke.sine, strict=True):
        a, b = (", ".join(map(_angle, row[1:])) for row in (cosine, sine))
        yield f"{name} = {{ mean = {_angle(cosine[0])}, cosine = [{a}], sine = [{b}] }}"


def _angle(value: np.float64 | float) -> str:
    return f'"{quantity_text(float(value), ANGLE, "deg")}"'
