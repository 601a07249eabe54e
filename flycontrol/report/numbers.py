"""Numbers as a reader sees them: minus signs, units, and a word where a number does not exist."""

from __future__ import annotations

import math
import re

from flycontrol.units import deg, ms

ABSENT = "—"
_LONG = 1e9
_GREEK = {"beta": "β", "gamma": "γ", "omega": "ω", "eta": "η", "psi": "ψ", "d_alpha": "Δα"}
_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def fixed(value: float | None, digits: int = 1, unit: str = "") -> str:
    """Write with so many digits after the point; a dash for what does not exist, a word for infinity.

    What would fill a table with digits, from 10⁹ on, has four significant ones and a power of ten.
    """
    if value is None or math.isnan(value):
        return ABSENT
    if math.isinf(value):
        return "unlimited"
    if abs(value) >= _LONG:
        return significant(value, 4, unit)
    text = f"{round(value, digits) + 0.0:.{digits}f}"  # adding zero turns -0.0 into 0.0
    return text.replace("-", "−") + (f"\N{NO-BREAK SPACE}{unit}" if unit else "")


def counted(count: int, noun: str, plural: str = "") -> str:
    """Write how many: 1 recording, 4 recordings, 2 flies."""
    return f"{count} {noun if count == 1 else plural or noun + 's'}"


def significant(value: float | None, digits: int = 3, unit: str = "") -> str:
    """Write with so many significant digits, powers of ten as 3.06×10⁻¹³."""
    if value is None or not math.isfinite(value):
        return fixed(value)
    text = f"{value:.{digits}g}"
    if "e" in text:
        mantissa, _, power = text.partition("e")
        text = f"{mantissa}×10{_raised(power)}"
    return text.replace("-", "−") + (f"\N{NO-BREAK SPACE}{unit}" if unit else "")


def sentence(text: str) -> str:
    """Set a sentence of another layer, written in ASCII, with Greek letters, minus signs and arrows."""
    for word, letter in _GREEK.items():
        text = re.sub(rf"\b{word}\b", letter, text)
    text = text.replace("->", "→").replace(" - ", " − ")
    text = re.sub(r"(?<=\d)-(?=\d)", "–", text)
    text = re.sub(r"(?<![\w–])-(?=\d)", "−", text)
    return typeset(text)


def typeset(text: str) -> str:
    """Write 3.06e-13 kg m^2 as 3.06×10⁻¹³ kg m², and leave everything else as it is."""
    text = re.sub(r"(?<=\d)e([+-]?\d+)\b", lambda power: f"×10{_raised(power[1])}", text)
    return re.sub(r"(?<=[A-Za-z])\^(-?\d+)\b", lambda power: _raised(power[1]), text)


def _raised(power: str) -> str:
    return str(int(power)).translate(_RAISED)


def milliseconds(seconds: float | None, digits: int = 1) -> str:
    """Write a time given in seconds."""
    return fixed(None if seconds is None else seconds / ms, digits, "ms")


def brief(seconds: float) -> str:
    """Write a time given in seconds in ms with three significant digits: 60 ms, 69.8 ms."""
    return significant(seconds / ms, 3, "ms")


def degrees(radians: float | None, digits: int = 1) -> str:
    """Write an angle given in radians."""
    return fixed(None if radians is None else radians / deg, digits) + ("" if radians is None else "°")


def root(value: complex, digits: int = 1) -> str:
    """Write a root [1/s], or a pair of them, by the one in the upper half plane."""
    if value.imag == 0:
        return fixed(value.real, digits)
    return f"{fixed(value.real, digits)} ± {abs(value.imag):.{digits}f}\N{NO-BREAK SPACE}j"
