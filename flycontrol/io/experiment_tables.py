"""The sections [trial], [perturbation] and [paddling] of a mapping file, and what contradicts itself in them."""

from __future__ import annotations

from typing import Any, cast

from flycontrol.io.channel_reader import ChannelReader
from flycontrol.io.experiment import Experiment, PaddlingMapping, PulseMapping, TraceMapping
from flycontrol.io.mapping_file import ChannelTable, MappingFile, PaddlingTable, PerturbationTable, TrialTable
from flycontrol.io.places import Channel, Place
from flycontrol.io.quantities import (
    ANGLE,
    ANGULAR_ACCELERATION,
    ANGULAR_VELOCITY,
    CURRENT,
    INERTIA,
    NUMBER,
    TIME,
    TORQUE,
    VOLTAGE,
    Kind,
    known_unit,
)

_DRIVES = (CURRENT, VOLTAGE, TORQUE, NUMBER)
_OF_A_PULSE = ("onset", "duration", "angular_impulse")
_OF_A_TRACE = ("trace", "time", "angular_acceleration_per_unit", "torque_per_unit", "inertia")
_ONE_CHANNEL = ("d_alpha", "right minus left, forward stroke")


def read_experiment(tables: MappingFile, read: ChannelReader) -> Experiment:
    """Turn the three sections into places, channels and numbers in SI units."""
    trial = tables.trial or TrialTable()
    return Experiment(
        trial=_trial_place(trial, read),
        groups=_groups(trial, read),
        name=read.label(trial.name, "trial.name"),
        fly=read.label(trial.fly, "trial.fly"),
        cut_at_gaps=trial.gaps == "cut",
        perturbation=None if tables.perturbation is None else _perturbation(tables.perturbation, read),
        paddling=None if tables.paddling is None else _paddling(_with_pitches(tables), read),
    )


def _trial_place(trial: TrialTable, read: ChannelReader) -> Place | None:
    if trial.row is None and trial.column is None and trial.variable is None:
        return None
    if trial.groups is not None:
        raise read.refusal(
            "trial.groups", "contradicts trial's column: a file's trials are groups, or rows of one table"
        )
    return read.place(trial, "trial")


def _groups(trial: TrialTable, read: ChannelReader) -> tuple[str, ...]:
    if trial.groups is None:
        return ()
    given = [trial.groups] if isinstance(trial.groups, str) else trial.groups
    if not isinstance(given, list) or not given or not all(isinstance(name, str) and name for name in given):
        raise read.refusal("trial.groups", f"is {trial.groups!r}; a name, a pattern with * or a list of them is needed")
    if read.orientation != "variables":
        raise read.refusal("trial.groups", "needs a file with groups: mat, hdf5 or netcdf")
    return tuple(cast("list[str]", given))


def _perturbation(table: PerturbationTable, read: ChannelReader) -> PulseMapping | TraceMapping | None:
    pulse = [name for name in _OF_A_PULSE if getattr(table, name) is not None]
    trace = [name for name in _OF_A_TRACE if getattr(table, name) is not None]
    kind = table.kind or ("trace" if trace and not pulse else "pulse")
    wrong = {"pulse": trace, "trace": pulse, "unknown": pulse + trace}[kind]
    if wrong:
        raise read.refusal(f"perturbation.{wrong[0]}", f"contradicts a perturbation of the kind '{kind}'")
    if kind == "unknown":
        return None
    return _trace(table, read) if kind == "trace" else _pulse(table, read)


def _pulse(table: PerturbationTable, read: ChannelReader) -> PulseMapping:
    onset = read.scalar(table.onset, TIME, "perturbation.onset")
    duration = read.scalar(table.duration, TIME, "perturbation.duration")
    if onset is None or duration is None:
        missing = "onset" if onset is None else "duration"
        raise read.refusal(
            "perturbation",
            f"has no {missing}; give onset and duration, or a trace, or say kind = 'unknown' to have them estimated",
        )
    if isinstance(duration, float) and not duration > 0:
        raise read.refusal("perturbation.duration", f"is '{table.duration}'; a pulse lasts longer than 0 s")
    impulse = read.scalar(table.angular_impulse, ANGULAR_VELOCITY, "perturbation.angular_impulse")
    return PulseMapping(onset=onset, duration=duration, angular_impulse=impulse)


def _trace(table: PerturbationTable, read: ChannelReader) -> TraceMapping:
    if table.trace is None:
        raise read.refusal("perturbation", "has no trace; name its channel, as in trace = { column = 5, unit = 'A' }")
    key = "perturbation.trace"
    unit = known_unit(table.trace.unit, *_DRIVES, key=f"{key}.unit", where=read.where(key))
    drive = cast(Channel, read.channel(table.trace, unit.kind, key))
    if table.time is not None and read.orientation != "variables":
        raise read.refusal("perturbation.time", "is for files of variables; in a table the trace has the trial's clock")
    return TraceMapping(
        drive=drive,
        unit=unit.kind.unit,
        time=read.channel(table.time, TIME, "perturbation.time"),
        angular_acceleration_per_unit=_calibration(table, unit.kind, unit.value, read),
    )


def _calibration(table: PerturbationTable, kind: Kind, unit: float, read: ChannelReader) -> float | None:
    """N_ext / I per SI unit of the drive: as it is given, or torque_per_unit / inertia; 1 / inertia for a torque."""
    inertia = read.optional_quantity(table.inertia, INERTIA, "perturbation.inertia")
    if inertia is not None and not inertia > 0:
        raise read.refusal("perturbation.inertia", f"is '{table.inertia}'; more than 0 is needed")
    given = read.optional_quantity(
        table.angular_acceleration_per_unit, ANGULAR_ACCELERATION, "perturbation.angular_acceleration_per_unit"
    )
    torque = read.optional_quantity(table.torque_per_unit, TORQUE, "perturbation.torque_per_unit")
    if given is not None:
        if torque is not None or inertia is not None:
            raise read.refusal("perturbation.angular_acceleration_per_unit", "contradicts torque_per_unit and inertia")
        return given / unit
    if kind is TORQUE and torque is not None:
        raise read.refusal("perturbation.torque_per_unit", "contradicts a trace that is a torque already")
    if kind is TORQUE:
        return None if inertia is None else 1 / inertia
    if (torque is None) != (inertia is None):
        raise read.refusal(
            "perturbation", "needs torque_per_unit and inertia together, since a fit knows torques only divided by I"
        )
    return None if torque is None or inertia is None else torque / unit / inertia


def _paddling(table: PaddlingTable, read: ChannelReader) -> PaddlingMapping:
    has_place = any(place is not None for place in (table.row, table.column, table.variable))
    one = table.convention in _ONE_CHANNEL
    wings = [name for name in ("left", "right", "stroke") if getattr(table, name) is not None]
    needed = {"attack angle": ["left", "right", "stroke"]}.get(table.convention, ["left", "right"])
    if one and (not has_place or table.unit is None or wings):
        raise read.refusal(
            "paddling", f"needs one channel and its unit, and no wings, for the convention '{table.convention}'"
        )
    if not one and (has_place or table.unit is not None or wings != needed):
        raise read.refusal("paddling", f"needs {', '.join(needed)} alone for the convention '{table.convention}'")
    return PaddlingMapping(
        convention=table.convention,
        difference=read.channel(_own_channel(table), ANGLE, "paddling") if one else None,
        left=read.channel(table.left, ANGLE, "paddling.left"),
        right=read.channel(table.right, ANGLE, "paddling.right"),
        stroke=read.channel(table.stroke, ANGLE, "paddling.stroke"),
    )


def _with_pitches(tables: MappingFile) -> PaddlingTable:
    """Return the table of paddling, with the pitches of [left] and [right] where it names no wings of its own."""
    paddling = tables.paddling or PaddlingTable(convention="wing pitch")
    own = paddling.convention != "wing pitch" or paddling.left is not None or paddling.right is not None
    if own or tables.left is None or tables.right is None:
        return paddling
    return paddling.model_copy(update={"left": tables.left.pitch, "right": tables.right.pitch})


def _own_channel(table: PaddlingTable) -> ChannelTable:
    places: dict[str, Any] = {"variable": table.variable, "row": table.row, "column": table.column}
    return ChannelTable(**places, unit=table.unit or "", sign=table.sign)
