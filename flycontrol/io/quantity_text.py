"""Quantities as a file writes them, "1.1 mg", such that they read back to the last bit."""

from __future__ import annotations

from flycontrol.io.quantities import Kind, unit_factor


def quantity_text(value: float, kind: Kind, unit: str) -> str:
    """Shortest text in a unit that reads back as `value`; in the SI unit where none of 17 digits does.

    Parameters
    ----------
    value : in the SI unit of `kind`
    kind : what it measures
    unit : in which a reader expects it, "mg"
    """
    factor = unit_factor(unit, kind, key="unit")
    for digits in range(1, 18):
        text = f"{value / factor:.{digits}g}"
        if float(text) * factor == value:
            return f"{text} {unit}"
    return f"{value!r} {kind.unit}"
