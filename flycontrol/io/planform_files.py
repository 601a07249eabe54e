"""Planforms from files: an outline's points, an outline as a Fourier series, a table of chords."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from flycontrol.errors import FlycontrolError, InvalidInputError
from flycontrol.io.series_conventions import Constant
from flycontrol.io.series_files import coefficients, read_json
from flycontrol.io.tables import split_lines, text_table
from flycontrol.io.text_files import TextFile, read_text_file
from flycontrol.model.planform import ChordTable
from flycontrol.model.wing_outline import WingShape, outline_shape, polygon_shape

FloatArray = NDArray[np.float64]
PlanformFormat = Literal["outline", "Fourier outline", "chord table"]

_POINTS = 512  # of a Fourier outline: its area is exact to about (2 pi / N)^2 / 6 = 2.5e-5
_TIP = (0.9, 1.1)  #: where the tip of an outline in wing lengths may plausibly be
_STATES_HALF = "R(th)=a0/2+"


def read_planform(
    path: Path | str,
    layout: PlanformFormat,
    *,
    length: float = 1.0,
    constant: Constant | None = None,
) -> WingShape:
    """Read the shape of a wing.

    Parameters
    ----------
    path
        The file.
    layout
        "outline": two columns, x along the chord and y along the span from the hinge. "Fourier outline": a JSON object
        with a0, ai, bi, xc, yc, x = xc - R cos th, y = yc - R sin th, R = mean + sum of ai cos i th + bi sin i th.
        "chord table": mean chord and wing length in one unit, each on a line, then rows of span position as a fraction
        of the wing length, and chord in any unit.
    length
        Of the wing, in the unit of an outline's points.
    constant
        What a0 of a Fourier outline is, where its file does not state R(th)=a0/2+...

    Raises
    ------
    InvalidInputError
        If the file is none of these, or describes no wing.
    """
    file = read_text_file(Path(path))
    try:
        if layout == "chord table":
            return _chord_table(file)
        if layout == "Fourier outline":
            return polygon_shape(_refuse_other_length(_fourier_points(file, constant), 1.0))
        return outline_shape(_refuse_other_length(_points(file), length))
    except FlycontrolError as error:
        told = str(error)
        raise InvalidInputError(told if told.startswith(file.name) else f"{file.name}: {told}") from error


def _points(file: TextFile) -> FloatArray:
    lines = split_lines(file, None)
    separated = split_lines(file, ",") if "," in " ".join(lines[-1].fields) else lines
    table = text_table(file, separated, "columns")
    return _numbers(file, table.numbers.T, "x along the chord, y along the span from the hinge")


def _numbers(file: TextFile, rows: FloatArray, what: str) -> FloatArray:
    if rows.shape[1] != 2:
        raise InvalidInputError(f"{file.name} has {rows.shape[1]} columns; two are needed: {what}.")
    bad = np.flatnonzero(~np.all(np.abs(rows) < 1e9, axis=1))
    if bad.size:
        raise InvalidInputError(f"{file.name}: row {int(bad[0]) + 1} of numbers holds what is no ordinary number.")
    return rows


def _fourier_points(file: TextFile, constant: Constant | None) -> FloatArray:
    data = read_json(file)
    if constant is None and _STATES_HALF not in str(data.get("convention", "")).replace(" ", ""):
        raise InvalidInputError(
            f"{file.name} does not state whether a0 is the mean radius or twice that; say "
            'constant = "twice the mean" or constant = "the mean".'
        )
    a0, xc, yc = (coefficients(file, data, key)[:1] for key in ("a0", "xc", "yc"))
    cosine, sine = coefficients(file, data, "ai"), coefficients(file, data, "bi")
    if not a0.size * xc.size * yc.size:
        raise InvalidInputError(f"{file.name}: a0, xc and yc must be numbers.")
    turn = 2 * np.pi * np.arange(_POINTS) / _POINTS
    radius = np.full(_POINTS, a0[0] if constant == "the mean" else a0[0] / 2)
    radius += np.cos(np.outer(turn, np.arange(1, cosine.size + 1))) @ cosine
    radius += np.sin(np.outer(turn, np.arange(1, sine.size + 1))) @ sine
    if not radius.min() > 0:
        raise InvalidInputError(
            f"{file.name}: the radius of the outline falls to {radius.min():.3g}; it must stay > 0 all around."
        )
    return np.stack([xc[0] - radius * np.cos(turn), yc[0] - radius * np.sin(turn)], axis=1)


def _refuse_other_length(points: FloatArray, length: float) -> FloatArray:
    scaled = points / length
    tip = float(scaled[:, 1].max())
    if not _TIP[0] <= tip <= _TIP[1]:
        raise InvalidInputError(
            f"the tip of the outline lies {tip:.4g} wing lengths from the hinge, outside {_TIP[0]:g} to {_TIP[1]:g}; "
            "check the unit of its points, and that the span is in the second column."
        )
    return scaled


def _chord_table(file: TextFile) -> WingShape:
    lines = split_lines(file, None)
    if len(lines) < 4 or [len(line.fields) for line in lines[:2]] != [1, 1]:
        raise InvalidInputError(
            f"{file.name}: a chord table begins with the mean chord and the wing length, each alone on a line, and "
            "has two rows of span position and chord or more."
        )
    mean, length = text_table(file, lines[:2], "columns").numbers[0]
    rows = _numbers(file, text_table(file, lines[2:], "columns").numbers.T, "span position, chord")
    if not (0 < mean < length < 1e9):
        raise InvalidInputError(
            f"{file.name}: mean chord and wing length must be > 0, the first smaller, got {mean:g} and {length:g}."
        )
    table = ChordTable(span=tuple(rows[:, 0].tolist()), chord=tuple((rows[:, 1] + 0.0).tolist()))
    return WingShape(table=table, mean_chord=float(mean / length))
