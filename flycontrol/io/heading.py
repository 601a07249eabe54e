"""Heading over time without jumps of a full turn, where that is certain."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flycontrol.errors import InvalidInputError
from flycontrol.io import frames
from flycontrol.io.channels import RecordingMapping
from flycontrol.io.plausibility import (
    A_WINGBEAT,
    FASTEST_TURN,
    LARGEST_HEADING,
    refuse_other_than_unit_norm,
)
from flycontrol.io.samples import Samples, read_samples
from flycontrol.io.table_files import Table
from flycontrol.units import deg, ms

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

LARGEST_STEP = 2.1 * np.pi  #: a turn and the motion between two samples [rad]
FASTEST_YAW = 100.0  #: mean yaw rate that no fly keeps up for 30 ms; saccades peak below 40 [rad/s]


@dataclass(frozen=True, slots=True)
class Heading:
    """Yaw over time; after a gap named in `ambiguous` it may be off by whole turns."""

    yaw: FloatArray  #: (n,) positive to the right, NaN where missing [rad]
    ambiguous: IntArray  #: samples that follow a gap in which the fly may have turned either way
    where: Callable[[int], str]  #: says where a sample stands in the file


def read_heading(table: Table, mapping: RecordingMapping, time: FloatArray) -> Heading:
    """Yaw as it is mapped, or the direction of the nose, psi = -atan2(y_W, x_W) with world z up.

    Raises
    ------
    InvalidInputError
        If yaw is constant, turns as no fly does, or if neither yaw nor the attitude is mapped.
    """
    if mapping.yaw is not None:
        samples = read_samples(table, mapping.yaw, missing=True)
        raw, where = samples.values, _places(samples)
    elif mapping.quaternion is not None:
        components = [read_samples(table, channel, missing=True) for channel in mapping.quaternion.channels]
        raw, where = _nose_direction(components, mapping), _places(components[0])
    else:
        raise InvalidInputError(f"The mapping {mapping.name} maps neither yaw nor the quaternion; a trial needs one.")
    _refuse_few(raw, table.file.name)
    _refuse_markers(raw, where)
    heading = _as_written(raw, where) if mapping.yaw_is_unwrapped else _unwrapped(raw, time, where)
    _refuse_constant(heading.yaw, table.file.name, mapping)
    _refuse_implausible(heading, time)
    return heading


def _places(samples: Samples) -> Callable[[int], str]:
    return lambda sample: samples.table.place(samples.index, sample)


def _nose_direction(components: list[Samples], mapping: RecordingMapping) -> FloatArray:
    parts = np.stack([part.values for part in components], axis=1)
    known = np.all(np.isfinite(parts), axis=1)
    yaw = np.full(len(parts), np.nan)
    if np.any(known):
        refuse_other_than_unit_norm(components)
        q_WB = frames.attitude(
            parts[known],
            to_world=mapping.quaternion is not None and mapping.quaternion.rotation == "body to world",
            world_z=mapping.world_z or "up",
            left_up=mapping.body_axes == "forward left up",
        )
        nose_W = frames.body_to_world(np.tile([1.0, 0.0, 0.0], (len(q_WB), 1)), q_WB)
        yaw[known] = -np.arctan2(nose_W[:, 1], nose_W[:, 0])
    return yaw


def _as_written(yaw: FloatArray, where: Callable[[int], str]) -> Heading:
    jumps = np.flatnonzero(np.abs(np.diff(yaw)) > np.pi)
    if jumps.size:
        sample = int(jumps[0]) + 1
        turn = (yaw[sample] - yaw[sample - 1]) / deg
        raise InvalidInputError(
            f"{where(sample)}: yaw jumps by {turn:.0f} deg, but the mapping says yaw.unwrapped = true; leave that out."
        )
    return Heading(yaw, np.empty(0, dtype=np.int64), where)


def _unwrapped(yaw: FloatArray, time: FloatArray, where: Callable[[int], str]) -> Heading:
    """Take the shorter way round at every step; uncertain where the longer way is slower than the fastest yaw."""
    known = np.flatnonzero(np.isfinite(yaw))
    continuous = np.full_like(yaw, np.nan)
    continuous[known] = np.unwrap(yaw[known])
    step = np.abs(np.diff(continuous[known]))
    ambiguous = 2 * np.pi - step <= FASTEST_YAW * np.diff(time[known])
    return Heading(continuous, known[1:][ambiguous], where)


def refuse_ambiguous(heading: Heading, time: FloatArray) -> None:
    """Refuse a heading that may be off by whole turns after a gap."""
    if not heading.ambiguous.size:
        return
    sample = int(heading.ambiguous[0])
    before = int(np.flatnonzero(np.isfinite(heading.yaw[:sample]))[-1])
    turn = (heading.yaw[sample] - heading.yaw[before]) / deg
    other = turn - 360 * (1 if turn > 0 else -1)
    raise InvalidInputError(
        f"{heading.where(sample)}: yaw may have turned by {turn:.3g} or by {other:.3g} deg in the gap of "
        f"{(time[sample] - time[before]) / ms:.3g} ms before; say trial.gaps = 'cut' to use one side of it, or "
        "yaw.unwrapped = true if the file's angle has no jumps of a full turn."
    )


def _refuse_few(yaw: FloatArray, name: str) -> None:
    if np.count_nonzero(np.isfinite(yaw)) < 2:
        raise InvalidInputError(f"{name}: yaw has fewer than two samples that are numbers; a trial needs more.")


def _refuse_markers(yaw: FloatArray, where: Callable[[int], str]) -> None:
    """Refuse angles and steps that no wrapping explains, such as -9999 for a missing sample."""
    known = np.flatnonzero(np.isfinite(yaw))
    largest = int(known[np.argmax(np.abs(yaw[known]))])
    if abs(yaw[largest]) > LARGEST_HEADING:
        raise InvalidInputError(
            f"{where(largest)}: yaw reaches {yaw[largest]:.4g} rad; that is more than four turns; "
            "are the numbers degrees?"
        )
    steps = np.abs(np.diff(yaw[known]))
    jumps = np.flatnonzero((steps > LARGEST_STEP) & (np.diff(known) == 1))
    if jumps.size:
        sample = int(known[jumps[0] + 1])
        turn = (yaw[sample] - yaw[sample - 1]) / deg
        raise InvalidInputError(
            f"{where(sample)}: yaw jumps by {turn:.4g} deg, more than a turn; mark what is missing with an empty field "
            "or nan."
        )


def _refuse_constant(yaw: FloatArray, name: str, mapping: RecordingMapping) -> None:
    known = yaw[np.isfinite(yaw)]
    if np.ptp(known) == 0:
        place = "" if mapping.yaw is None else f" ({mapping.yaw.where})"
        raise InvalidInputError(
            f"{name}: yaw is {known[0] / deg:.6g} deg throughout; a fly in flight is never still: is another channel "
            f"meant{place}?"
        )


def _refuse_implausible(heading: Heading, time: FloatArray) -> None:
    known = np.flatnonzero(np.isfinite(heading.yaw))
    yaw, at = heading.yaw[known], time[known]
    later = np.searchsorted(at, at + A_WINGBEAT * (1 - 1e-9))  # noise of the tracking averages out over a wingbeat
    inside = np.flatnonzero(later < len(at))
    speed = np.abs(yaw[later[inside]] - yaw[inside]) / (at[later[inside]] - at[inside])
    fastest = int(np.argmax(speed)) if speed.size else -1
    if speed.size and speed[fastest] > FASTEST_TURN:
        sample = int(known[inside[fastest]])
        raise InvalidInputError(
            f"{heading.where(sample)}: yaw changes by {speed[fastest]:.4g} rad/s; are the numbers degrees?"
        )
