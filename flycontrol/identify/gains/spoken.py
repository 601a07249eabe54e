"""Quantities in sentences, in the units that people measure in."""

from __future__ import annotations

from flycontrol.units import deg, ms

_EVERYDAY = {"s": ("ms", ms), "rad": ("deg", deg)}


def spoken(value: float, unit: str, digits: int = 4) -> str:
    """Write 0.01 s as 10 ms and 0.5 rad as 28.65 deg; other units stay."""
    word, size = _EVERYDAY.get(unit, (unit, 1.0))
    return f"{value / size:.{digits}g} {word}" if abs(value) < float("inf") else "unlimited"


def spoken_range(low: float, high: float, unit: str) -> str:
    """Write an interval, an infinite end as open: "from 10 to 12 ms", "up to 20 ms", "of any size"."""
    below, above = low == -float("inf"), high == float("inf")
    if below and above:
        return "of any size"
    if below or above:
        return f"up to {spoken(high, unit)}" if below else f"from {spoken(low, unit)} upwards"
    return f"from {spoken(low, unit).partition(' ')[0]} to {spoken(high, unit)}"
