"""The parameters of a fly and of its nominal experiment, from a fly file."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, replace
from pathlib import Path

from flycontrol.errors import FlycontrolError, InvalidInputError
from flycontrol.io.fly_files import DEFAULT, LayeredFile, read_fly_file, shipped_file
from flycontrol.io.quantities import (
    ANGLE,
    DAMPING,
    FREQUENCY,
    INERTIA,
    RATE_SQUARED,
    STIFFNESS,
    TIME,
    TORQUE_PER_RATE,
    Kind,
    read_quantity,
)
from flycontrol.model.parameters import Parameters, Sourced

_SLOWEST_DAMPING, _FASTEST_DAMPING = 0.1, 1e4  #: plausible beta/I [1/s]


@dataclass(frozen=True, slots=True)
class _Rule:
    """The field that a key fills, what it measures (a gain may be a torque too), and what is plausible of the first."""

    field: str
    kinds: tuple[Kind, ...]
    low: str
    high: str


_RULES = {
    "fly.inertia": _Rule("inertia", (INERTIA,), "1e-15 kg m^2", "1e-5 kg m^2"),
    "fly.damping": _Rule("damping", (DAMPING,), "1e-15 N m s", "1e-3 N m s"),
    "fly.wingbeat_frequency": _Rule("wingbeat_frequency", (FREQUENCY,), "20 Hz", "2000 Hz"),
    "controller.proportional_gain": _Rule("proportional_gain", (RATE_SQUARED, STIFFNESS), "-1e7 1/s^2", "1e7 1/s^2"),
    "controller.derivative_gain": _Rule("derivative_gain", (FREQUENCY, TORQUE_PER_RATE), "-1e5 1/s", "1e5 1/s"),
    "controller.delay": _Rule("delay", (TIME,), "0.1 ms", "1000 ms"),
    "pulse.duration": _Rule("pulse_duration", (TIME,), "0.01 ms", "1000 ms"),
    "pulse.peak": _Rule("pulse_peak", (ANGLE,), "0.01 deg", "180 deg"),
    "pulse.tolerance": _Rule("tolerance", (ANGLE,), "0.001 deg", "90 deg"),
    "pulse.deadline": _Rule("deadline", (TIME,), "0.1 ms", "100 s"),
    "damping_range.low": _Rule("damping_low", (FREQUENCY,), "0.1 1/s", "1e4 1/s"),
    "damping_range.high": _Rule("damping_high", (FREQUENCY,), "0.1 1/s", "1e4 1/s"),
}


def read_parameters(path: Path | str | None = None) -> Parameters:
    """Read the parameters of a fly and of its nominal experiment.

    Parameters
    ----------
    path
        A TOML file, which may hold any part of the default file, or the name of a shipped one; None is the default.

    Returns
    -------
    flycontrol.model.parameters.Parameters
        In SI units; `defaulted` names the keys that were taken from the default file.

    Raises
    ------
    InvalidInputError
        For anything that cannot be meant: an unknown key, a number without a unit, a wrong or implausible unit.
    """
    fly = read_fly_file(path)
    values = {rule.field: _sourced(fly, key, rule) for key, rule in _RULES.items()}
    _refuse_mixed_gains(fly, values)
    for key in ("controller.proportional_gain", "controller.derivative_gain"):
        values[_RULES[key].field] = _per_inertia(values[_RULES[key].field], values["inertia"], _RULES[key].kinds[0])
    for key, rule in _RULES.items():
        _refuse_implausible(fly, key, rule, values[rule.field].value)
    _refuse_contradictions(fly, values)
    return Parameters(
        name=fly.tables.fly.name, defaulted=fly.defaulted, file=fly.user.file.name, sha256=_hash(fly), **values
    )


def _sourced(fly: LayeredFile, key: str, rule: _Rule) -> Sourced:
    entry, where = fly.entry(key), fly.where(key)
    quantity = read_quantity(entry.value, *rule.kinds, key=key, where=where)
    try:
        return Sourced(
            value=quantity.value,
            unit=quantity.kind.unit,
            source=entry.source,
            certainty=entry.certainty,
            note=entry.note,
            text=entry.value,
        )
    except FlycontrolError as error:
        raise InvalidInputError(f"{where}: {key}: {error}") from error


def _per_inertia(gain: Sourced, inertia: Sourced, ratio: Kind) -> Sourced:
    """K/I: a gain given as a torque is divided by the inertia."""
    if gain.unit == ratio.unit:
        return gain
    note = "; ".join(part for part in (gain.note, f"given as a torque, divided by I = {inertia.text}") if part)
    return replace(gain, value=gain.value / inertia.value, unit=ratio.unit, note=note)


def _refuse_mixed_gains(fly: LayeredFile, values: dict[str, Sourced]) -> None:
    keys = ("controller.proportional_gain", "controller.derivative_gain")
    as_ratio = [values[_RULES[key].field].unit == _RULES[key].kinds[0].unit for key in keys]
    if as_ratio[0] != as_ratio[1] and not set(keys) & set(fly.defaulted):
        raise InvalidInputError(
            f"{fly.where(keys[1])}: one gain is a torque and the other is divided by the inertia; give both in "
            "1/s^2 and 1/s, or both in N m/rad and N m s/rad."
        )


def _refuse_implausible(fly: LayeredFile, key: str, rule: _Rule, value: float) -> None:
    low, high = (read_quantity(bound, rule.kinds[0], key=key).value for bound in (rule.low, rule.high))
    if not low <= value <= high:
        raise InvalidInputError(
            f"{fly.where(key)}: {key} is '{fly.entry(key).value}', outside the plausible {rule.low} to {rule.high}; "
            "check the number and its unit."
        )


def _refuse_contradictions(fly: LayeredFile, values: dict[str, Sourced]) -> None:
    rate = values["damping"].value / values["inertia"].value
    if not _SLOWEST_DAMPING <= rate <= _FASTEST_DAMPING:
        raise InvalidInputError(
            f"{fly.where('fly.damping')}: damping over inertia is {rate:.3g} 1/s, outside the plausible "
            f"{_SLOWEST_DAMPING:g} to {_FASTEST_DAMPING:g} 1/s; check both units."
        )
    for smaller, larger in (("damping_range.low", "damping_range.high"), ("pulse.tolerance", "pulse.peak")):
        if not values[_RULES[smaller].field].value < values[_RULES[larger].field].value:
            place = fly.where(larger if smaller in fly.defaulted else smaller)
            raise InvalidInputError(
                f"{place}: {smaller} ({fly.entry(smaller).value}) must be smaller than {larger} "
                f"({fly.entry(larger).value})."
            )


def _hash(fly: LayeredFile) -> str:
    """Hash of the file read or, where the default file filled keys in, of both files' hashes."""
    if not fly.defaulted:
        return fly.user.file.sha256
    return hashlib.sha256((fly.user.file.sha256 + shipped_file(DEFAULT).file.sha256).encode()).hexdigest()
