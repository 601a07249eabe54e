"""Packed numbers as netCDF's conventions have them."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


def unpacked(raw: FloatArray, attributes: Mapping[str, object]) -> FloatArray:
    """value = add_offset + scale_factor * number, NaN where the number is _FillValue or missing_value."""
    missing = np.zeros(raw.shape, dtype=bool)
    for name in ("_FillValue", "missing_value"):
        marker = _real(attributes.get(name))
        if marker is not None:
            missing |= raw == marker
    scale = _real(attributes.get("scale_factor"))
    offset = _real(attributes.get("add_offset"))
    with np.errstate(over="ignore", invalid="ignore"):
        value = raw * (1.0 if scale is None else scale) + (0.0 if offset is None else offset)
    return np.where(missing, np.nan, value)


def _real(value: object) -> float | None:
    return float(value) if isinstance(value, int | float) and not isinstance(value, bool) else None
