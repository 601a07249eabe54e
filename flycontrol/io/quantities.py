"""Quantities as a user writes them, a number with a unit in a string ("13.6 ms"), and what they are in SI units."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING

from flycontrol.errors import InvalidInputError

if TYPE_CHECKING:
    import pint

_NUMBER_THEN_UNIT = re.compile(r"([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(.*)", re.DOTALL)
_UNIT = re.compile(r"(?!.*\d\d)[A-Za-zµμ°·²³⁻¹%0-9 ()*/^.-]{1,40}")  # no two digits in a row: no power above 9

# Angle is a dimension of its own here, unlike in pint's own registry: only so rpm is no frequency and N m no N m/rad.
_UNIT_DEFINITIONS = """\
giga- = 1e9 = G-
mega- = 1e6 = M-
kilo- = 1e3 = k-
centi- = 1e-2 = c-
milli- = 1e-3 = m-
micro- = 1e-6 = µ- = μ- = u-
nano- = 1e-9 = n-
pico- = 1e-12 = p-
femto- = 1e-15 = f-
meter = [length] = m = metre
gram = [mass] = g
second = [time] = s
minute = 60 second = min
radian = [angle] = rad
degree = 0.017453292519943295 radian = deg = °
turn = 6.283185307179586 radian = revolution
rpm = turn / minute
hertz = 1 / second = Hz
newton = kilogram meter / second ** 2 = N
joule = newton meter = J
watt = joule / second = W
wingbeat = [wingbeats]
ampere = [current] = A
volt = watt / ampere = V
pascal = newton / meter ** 2 = Pa
percent = 0.01 = %
"""


@dataclass(frozen=True, slots=True)
class Kind:
    """What a quantity measures: a noun with its article, the SI unit, and an example in everyday units."""

    noun: str
    unit: str
    example: str


TIME = Kind("a time", "s", "13.6 ms")
FREQUENCY = Kind("a frequency", "1/s", "220 Hz")
LENGTH = Kind("a length", "m", "2.4 mm")
AREA = Kind("an area", "m^2", "1.75 mm^2")
MASS = Kind("a mass", "kg", "1.1 mg")
DENSITY = Kind("a density", "kg/m^3", "1.19 kg/m^3")
ANGLE = Kind("an angle", "rad", "20 deg")
VELOCITY = Kind("a velocity", "m/s", "250 mm/s")
ANGULAR_VELOCITY = Kind("an angular velocity", "rad/s", "30 rad/s")
RATE_SQUARED = Kind("a squared rate", "1/s^2", "3050 1/s^2")
INERTIA = Kind("a moment of inertia", "kg m^2", "3.06e-13 kg m^2")
DAMPING = Kind("a rotational damping", "N m s", "21e-12 N m s")
TORQUE = Kind("a torque", "N m", "2e-10 N m")
STIFFNESS = Kind("a torque per angle", "N m/rad", "9.3e-10 N m/rad")
TORQUE_PER_RATE = Kind("a torque per angular velocity", "N m s/rad", "1.4e-11 N m s/rad")
ANGULAR_ACCELERATION = Kind("an angular acceleration", "rad/s^2", "200 rad/s^2")
CURRENT = Kind("a current", "A", "50 mA")
VOLTAGE = Kind("a voltage", "V", "2 V")
WINGBEATS = Kind("a time in wingbeats", "wingbeat", "2 wingbeats")
NUMBER = Kind("a number without unit", "1", "0.58")

KINDS = (
    *(TIME, FREQUENCY, LENGTH, AREA, MASS, DENSITY, ANGLE, VELOCITY, ANGULAR_VELOCITY, RATE_SQUARED, INERTIA, DAMPING),
    *(TORQUE, STIFFNESS, TORQUE_PER_RATE, ANGULAR_ACCELERATION, CURRENT, VOLTAGE, WINGBEATS, NUMBER),
)


@dataclass(frozen=True, slots=True)
class Quantity:
    """A number in the SI unit of its kind."""

    value: float
    kind: Kind


def read_quantity(entry: object, *kinds: Kind, key: str, where: str = "") -> Quantity:
    """Convert a quantity like "13.6 ms" to SI units.

    Parameters
    ----------
    entry
        What the file holds: a string with a number and a unit is needed; a bare number is refused.
    *kinds
        What may be measured; the first gives the example in a refusal.
    key
        The name of the quantity, for the refusal.
    where
        File and line, for the refusal.

    Returns
    -------
    Quantity
        The value in the SI unit of the kind that fits.

    Raises
    ------
    InvalidInputError
        If the entry has no unit, a wrong one, or is no finite number.
    """
    place = f"{where}: " if where else ""
    if not isinstance(entry, str):
        raise InvalidInputError(f"{place}{key} is {entry!r}, without a unit; {_wanted(key, entry, kinds)}.")
    parts = _NUMBER_THEN_UNIT.fullmatch(entry.strip())
    if parts is None or not math.isfinite(float(parts[1])):
        raise InvalidInputError(f"{place}{key} is '{entry}', not a finite number with a unit; {_needed(kinds)}.")
    if not parts[2]:
        raise InvalidInputError(f"{place}{key} is '{entry}', without a unit; {_wanted(key, parts[1], kinds)}.")
    unit = "1" + parts[2] if parts[2].startswith("/") else parts[2]
    kind, factor = _kind_and_factor(unit, kinds, f"{place}{key} is '{entry}'")
    return Quantity(float(parts[1]) * factor, kind)


def unit_factor(unit: str, *kinds: Kind, key: str, where: str = "") -> float:
    """Size of a unit in the SI unit of its kind: 1e-3 for "mm" as a length; refused like `read_quantity`."""
    return known_unit(unit, *kinds, key=key, where=where).value


def known_unit(unit: str, *kinds: Kind, key: str, where: str = "") -> Quantity:
    """Return one of a unit as a quantity, 1e-3 A for "mA"; refused like `read_quantity`."""
    place = f"{where}: " if where else ""
    kind, factor = _kind_and_factor(unit, kinds, f"{place}{key} is '{unit}'")
    return Quantity(factor, kind)


def _kind_and_factor(text: str, kinds: tuple[Kind, ...], sentence: str) -> tuple[Kind, float]:
    unit = _parsed_unit(text, sentence, kinds)
    registry = _registry()
    for kind in kinds:
        if unit.dimensionality == registry.parse_units(kind.unit).dimensionality:
            return kind, float(registry.Quantity(1.0, unit).to(kind.unit).magnitude)
    nouns = [kind.noun for kind in KINDS if unit.dimensionality == registry.parse_units(kind.unit).dimensionality]
    what = nouns[0] if nouns else f"of dimension {unit.dimensionality}"
    raise InvalidInputError(f"{sentence}, {what}; {_needed(kinds)}.")


def _parsed_unit(text: str, sentence: str, kinds: tuple[Kind, ...]) -> pint.Unit:
    unknown = InvalidInputError(f"{sentence}, but '{text}' is not a unit known here; {_needed(kinds)}.")
    if _UNIT.fullmatch(text) is None:
        raise unknown
    try:
        return _registry().parse_units(text)
    except Exception as error:  # pint's parser lets tokenizer and assertion errors through
        raise unknown from error


def _wanted(key: str, number: object, kinds: tuple[Kind, ...]) -> str:
    unit = kinds[0].example.partition(" ")[2]
    value = f"{number} {unit}" if unit and _is_number(number) else kinds[0].example
    return f'write a string with a unit, for example {key.rpartition(".")[2]} = "{value}"'


def _is_number(value: object) -> bool:
    return isinstance(value, str) or (isinstance(value, int | float) and not isinstance(value, bool))


def _needed(kinds: tuple[Kind, ...]) -> str:
    return " or ".join(f"{kind.noun} such as '{kind.example}'" for kind in kinds) + " is needed"


@cache
def _registry() -> pint.UnitRegistry:
    """Build pint's registry on first use: its import takes 0.3 s."""
    import pint

    registry: pint.UnitRegistry = pint.UnitRegistry(None)  # pyright: ignore[reportArgumentType]  # documented: no defaults
    for definition in _UNIT_DEFINITIONS.splitlines():
        registry.define(definition)
    return registry
