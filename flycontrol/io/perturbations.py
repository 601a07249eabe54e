"""What perturbed the fly in a trial: a pulse or a recorded trace, as the mapping says."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from flycontrol.errors import InvalidInputError
from flycontrol.io.experiment import PulseMapping, TraceMapping
from flycontrol.io.places import Scalar
from flycontrol.io.samples import read_samples
from flycontrol.io.scalars import read_scalar
from flycontrol.io.table_files import Table
from flycontrol.model.trial import Pulse, TorqueTrace
from flycontrol.units import ms

FloatArray = NDArray[np.float64]


def read_perturbation(
    table: Table, mapping: PulseMapping | TraceMapping | None, time: FloatArray
) -> Pulse | TorqueTrace | None:
    """Read the pulse or the trace of a trial; None if it is unknown.

    Raises
    ------
    InvalidInputError
        If a number is missing, if the pulse lies outside the recording, or if the trace never changes.
    """
    if mapping is None:
        return None
    return _pulse(table, mapping, time) if isinstance(mapping, PulseMapping) else _trace(table, mapping, time)


def _pulse(table: Table, mapping: PulseMapping, time: FloatArray) -> Pulse:
    onset, duration = _number(table, mapping.onset), _number(table, mapping.duration)
    name = table.file.name
    if not duration > 0:
        raise InvalidInputError(f"{name}: perturbation.duration is {duration:g} s; a pulse lasts longer than 0 s.")
    if onset >= time[-1] or onset + duration <= time[0]:
        raise InvalidInputError(
            f"{name}: the pulse from {onset / ms:.6g} to {(onset + duration) / ms:.6g} ms lies outside the recording "
            f"from {time[0] / ms:.6g} to {time[-1] / ms:.6g} ms; check the units and the start of the clock."
        )
    if duration > time[-1] - time[0]:
        raise InvalidInputError(
            f"{name}: the pulse lasts {duration / ms:.6g} ms, longer than the recording; is its unit another?"
        )
    impulse = None if mapping.angular_impulse is None else _number(table, mapping.angular_impulse)
    return Pulse(onset=onset, duration=duration, angular_impulse=impulse)


def _number(table: Table, given: float | Scalar) -> float:
    return read_scalar(table, given) if isinstance(given, Scalar) else given


def _trace(table: Table, mapping: TraceMapping, time: FloatArray) -> TorqueTrace:
    """Read the samples of the drive; those that are missing are left out, since it is interpolated anyway."""
    drive = read_samples(table, mapping.drive, missing=True)
    at = time if mapping.time is None else read_samples(table, mapping.time).values
    if len(at) != len(drive.values):
        raise InvalidInputError(
            f"{table.file.name}: perturbation.time has {len(at)} samples where perturbation.trace has "
            f"{len(drive.values)}; as many are needed."
        )
    known = np.isfinite(drive.values)
    if np.count_nonzero(known) < 2 or np.ptp(drive.values[known]) == 0:
        raise InvalidInputError(
            f"{table.file.name}: perturbation.trace never changes, so it perturbs nothing; is another channel meant "
            f"({mapping.drive.where})?"
        )
    if np.any(np.diff(at) <= 0):
        sample = int(np.flatnonzero(np.diff(at) <= 0)[0]) + 1
        raise drive.refusal(sample, "has a time that does not increase")
    if at[-1] <= time[0] or at[0] >= time[-1]:
        raise InvalidInputError(
            f"{table.file.name}: perturbation.trace and yaw share no time; check the units and clocks in the mapping."
        )
    return TorqueTrace(
        time=at[known],
        drive=drive.values[known],
        unit=mapping.unit,
        angular_acceleration_per_unit=mapping.angular_acceleration_per_unit,
    )
