"""The wing's angles as they were measured, from a text table: one wingbeat that repeats, or many as they were."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from flycontrol.errors import FlycontrolError, InvalidInputError
from flycontrol.io.mapping_file import ChannelTable, PlaceTable
from flycontrol.io.places import Channel, Place
from flycontrol.io.plausibility import refuse_large_wing_angle
from flycontrol.io.quantities import ANGLE, NUMBER, TIME, Kind, read_quantity, unit_factor
from flycontrol.io.quantity_reader import QuantityReader
from flycontrol.io.samples import read_samples
from flycontrol.io.stroke_tables import SamplesTable
from flycontrol.io.tables import SEPARATORS, TextTable, read_text_table
from flycontrol.model.wing_stroke import FourierStroke, SampledStroke, fourier_stroke

FloatArray = NDArray[np.float64]

_CLOSED = 1e-6  #: [wingbeats] by which a wingbeat may miss one
_UNEVEN = 0.5  #: by which the step that closes a wingbeat may differ from the others, relative


def read_stroke_samples(
    table: SamplesTable, frequency: float, folder: Path, read: QuantityReader
) -> SampledStroke | FourierStroke:
    """Read measured angles.

    Parameters
    ----------
    table
        Which columns of which file.
    frequency
        Of the wingbeat, which turns times into phases [1/s].
    folder
        Where the file lies.
    read
        Knows file and line of the table.

    Raises
    ------
    InvalidInputError
        If the file is not as the table says, or is periodic in the table alone.
    """
    separator = table.separator or SEPARATORS[table.format]
    file = read_text_table(folder / table.file, separator, "columns", decimal_comma=table.decimal == ",")
    phase = _phase(file, table, frequency, read)
    angles = np.stack(
        [
            _angle(file, entry, read, key)
            for key, entry in (("stroke", table.stroke), ("deviation", table.deviation), ("pitch", table.pitch))
        ],
        axis=-1,
    )
    try:
        return _stroke(phase, angles, table)
    except FlycontrolError as error:
        raise InvalidInputError(f"{file.file.name}: {error}") from error


def _stroke(phase: FloatArray, angles: FloatArray, table: SamplesTable) -> SampledStroke | FourierStroke:
    if not np.all(np.diff(phase) > 0):
        raise InvalidInputError("phases or times must rise from sample to sample; sort the rows.")
    if table.harmonics is not None:
        return fourier_stroke(phase, angles, table.harmonics)
    if table.periodic:
        phase, angles = _closed(phase, angles)
    return SampledStroke(phase=phase, samples=angles, periodic=table.periodic)


def _phase(file: TextTable, table: SamplesTable, frequency: float, read: QuantityReader) -> FloatArray:
    if (table.phase is None) == (table.time is None):
        raise read.refusal("phase", "or time is needed, and not both")
    if table.phase is not None:
        if table.start is not None:
            raise read.refusal("start", "is the time that counts as phase 0; it belongs to time, not to phase")
        return read_samples(file, _channel(table.phase, NUMBER, "phase", read)).values
    assert table.time is not None
    start = (
        0.0
        if table.start is None
        else read_quantity(table.start, TIME, key=read.full("start"), where=read.where("start")).value
    )
    return frequency * (read_samples(file, _channel(table.time, TIME, "time", read)).values - start)


def _angle(file: TextTable, entry: ChannelTable | None, read: QuantityReader, key: str) -> FloatArray:
    if entry is None:
        return np.zeros(file.numbers.shape[1])
    samples = read_samples(file, _channel(entry, ANGLE, key, read))
    refuse_large_wing_angle(samples)
    return samples.values


def _channel(entry: PlaceTable, kind: Kind, key: str, read: QuantityReader) -> Channel:
    where = read.where(key)
    if entry.column is None or entry.row is not None or entry.variable is not None:
        raise read.refusal(key, "needs one column, by its name or its number counted from 0")
    place: Place = entry.column
    if not isinstance(entry, ChannelTable):
        return Channel(key=key, place=place, where=where, kind=kind)
    factor = unit_factor(entry.unit, kind, key=read.full(f"{key}.unit"), where=where)
    offset = (
        0.0
        if entry.offset is None
        else read_quantity(entry.offset, kind, key=read.full(f"{key}.offset"), where=where).value
    )
    return Channel(
        key=key, place=place, where=where, kind=kind, unit=entry.unit, factor=factor, sign=entry.sign, offset=offset
    )


def _closed(phase: FloatArray, angles: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Close a wingbeat: its last sample is the first one again, or comes one step before it."""
    span = float(phase[-1] - phase[0])
    step = float(np.median(np.diff(phase))) if len(phase) > 1 else 1.0
    if abs(span - 1.0) <= _CLOSED:
        jump = float(np.max(np.abs(angles[-1] - angles[0])))
        if jump > 1e-9:
            raise InvalidInputError(
                f"periodic samples must end where they began, and these end {np.degrees(jump):.3g} deg away; "
                "leave the last row out, give harmonics for the nearest periodic series, or say periodic = false."
            )
        return np.append(phase[:-1], phase[0] + 1.0), angles[[*range(len(angles) - 1), 0]]
    if abs(1.0 - span - step) > _UNEVEN * step:
        raise InvalidInputError(
            f"periodic samples must span one wingbeat, and these span {span:.6g}; check the unit of the times "
            "and the frequency, cut one wingbeat out, give harmonics, or say periodic = false."
        )
    return np.append(phase, phase[0] + 1.0), np.vstack([angles, angles[:1]])
