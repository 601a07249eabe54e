"""Fourier series of the wing's angles from JSON files, by an explicit convention."""

from __future__ import annotations

import json
from difflib import get_close_matches
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flycontrol.errors import InvalidInputError
from flycontrol.io.series_conventions import AngleSeries, SeriesConvention
from flycontrol.io.text_files import TextFile, read_text_file
from flycontrol.model.wing_stroke import FourierStroke

FloatArray = NDArray[np.float64]

MOST_HARMONICS = 500


def read_series_file(path: Path, convention: SeriesConvention) -> FourierStroke:
    """Read a JSON file of Fourier coefficients.

    Parameters
    ----------
    path
        The file; its lists are a_1, a_2, ... and b_1, b_2, ....
    convention
        What its numbers mean.

    Raises
    ------
    InvalidInputError
        If it is no JSON, lacks a list, holds anything but numbers, or states another convention.
    """
    file = read_text_file(path)
    data = read_json(file)
    stated = data.get("convention", "")
    if convention.states and convention.states not in str(stated):
        raise InvalidInputError(
            f"{file.name} states the convention {str(stated)[:200]!r}, not {convention.states!r}; name the convention "
            "that it is written in, or spell one out in a table."
        )
    angles = (convention.stroke, convention.deviation, convention.pitch)
    series = [_series(file, data, angle, convention) for angle in angles]
    count = max(cosine.size for cosine, _ in series)
    cosine, sine = (np.array([np.pad(one[k], (0, count - one[k].size)) for one in series]) for k in (0, 1))
    return FourierStroke(cosine=cosine, sine=sine)


def read_json(file: TextFile) -> dict[str, Any]:
    """Parse a JSON object; InvalidInputError if it is none."""
    try:
        data = json.loads(file.text)
    except (ValueError, RecursionError) as error:
        raise InvalidInputError(f"{file.name} is not valid JSON: {error}.") from error
    if not isinstance(data, dict):
        raise InvalidInputError(f"{file.name} holds no JSON object with named coefficients.")
    return data


def coefficients(file: TextFile, data: dict[str, Any], name: str) -> FloatArray:
    """List of numbers under a dotted name; an empty name is an empty list."""
    found = _found(file, data, name) if name else []
    numbers = found if isinstance(found, list) else [found]
    if not all(isinstance(x, int | float) and not isinstance(x, bool) and abs(x) < 1e9 for x in numbers):
        raise InvalidInputError(f"{file.name}: {name} holds something that is no ordinary number; numbers are needed.")
    if len(numbers) > MOST_HARMONICS:
        raise InvalidInputError(
            f"{file.name}: {name} has {len(numbers)} coefficients; at most {MOST_HARMONICS} are read."
        )
    return np.array(numbers, dtype=np.float64)


def _found(file: TextFile, data: dict[str, Any], name: str) -> object:
    found: Any = data
    for key in name.split("."):
        if not isinstance(found, dict) or key not in found:
            known = list(found) if isinstance(found, dict) else []
            near = get_close_matches(key, known, n=1)
            hint = f"the nearest is {near[0]!r}" if near else f"there are {', '.join(map(repr, known[:12])) or 'none'}"
            raise InvalidInputError(f"{file.name} holds no {name!r}; {hint}.")
        found = found[key]
    return found


def _series(
    file: TextFile, data: dict[str, Any], angle: AngleSeries | None, convention: SeriesConvention
) -> tuple[FloatArray, FloatArray]:
    """a_k, b_k, (K + 1,) each, of one of this package's angles [rad]."""
    if angle is None:
        return np.zeros(1), np.zeros(1)
    cosine, sine = coefficients(file, data, angle.cosine), coefficients(file, data, angle.sine)
    constant = float(coefficients(file, data, angle.constant)[0]) if angle.constant else 0.0
    mean = constant / 2 if convention.constant == "twice the mean" else constant
    count = max(cosine.size, sine.size)
    a, b = (np.pad(one, (0, count - one.size)) for one in (cosine, sine))
    turn = 2 * np.pi * angle.advance * np.arange(1, count + 1)
    factor = angle.sign * angle.scale * convention.unit
    ahead_a, ahead_b = a * np.cos(turn) + b * np.sin(turn), b * np.cos(turn) - a * np.sin(turn)
    return (
        np.concatenate([[angle.offset + factor * mean], factor * ahead_a]),
        np.concatenate([[0.0], factor * ahead_b]),
    )
