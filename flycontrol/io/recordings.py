"""Recordings of flies from files, through a mapping."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from flycontrol.io import frames, plausibility
from flycontrol.io.binary.reader import shared_reader
from flycontrol.io.channels import RecordingMapping, VectorChannels, WingChannels
from flycontrol.io.clock import SampleTimes, read_clock
from flycontrol.io.mapping import read_mapping
from flycontrol.io.places import Channel
from flycontrol.io.samples import Samples, read_samples
from flycontrol.io.table_files import Table, read_tables, recording_contents
from flycontrol.model.recording import Recording, WingAngles

FloatArray = NDArray[np.float64]


def read_recording(path: Path | str, mapping: RecordingMapping | Path | str) -> Recording:
    """Read a recording of a fly, in SI units and the package's frames.

    Parameters
    ----------
    path
        A text table, or a MATLAB, HDF5, netCDF or Parquet file.
    mapping
        What its rows, columns or variables mean: a mapping, a mapping file, or the name of a shipped one.

    Returns
    -------
    Recording
        The channels that the mapping names; the others are None.

    Raises
    ------
    InvalidInputError
        If file and mapping do not fit, a mapped number is missing, the clock is uneven, or the motion is none of a fly.
    """
    known = mapping if isinstance(mapping, RecordingMapping) else read_mapping(mapping)
    table = read_tables(Path(path), known, recording_contents(known), shared_reader())[0]
    clock = read_clock(table, known.clock)
    recording = _assembled(table, known, clock)
    plausibility.refuse_short(recording, known.clock)
    plausibility.refuse_inconsistent_units(recording)
    return recording


def _assembled(table: Table, mapping: RecordingMapping, clock: SampleTimes) -> Recording:
    q_WB = _attitude(table, mapping)
    return Recording(
        name=Path(table.file.name).stem,
        rate=clock.rate,
        time=clock.time,
        source_sha256=table.file.sha256,
        yaw=_yaw(table, mapping.yaw, clock.rate),
        position_W=_position(table, mapping, clock.rate),
        velocity_S=_in_stroke_plane(table, mapping, mapping.velocity, q_WB),
        angular_velocity_S=_in_stroke_plane(table, mapping, mapping.angular_velocity, q_WB),
        q_WB=q_WB,
        stroke_plane_angle=mapping.stroke_plane_angle,
        left=_wing(table, mapping.left),
        right=_wing(table, mapping.right),
        notes=mapping.notes | {"mapping_sha256": mapping.sha256},
    )


def _yaw(table: Table, channel: Channel | None, rate: float) -> FloatArray | None:
    """Heading without jumps of a full turn."""
    if channel is None:
        return None
    samples = read_samples(table, channel)
    plausibility.refuse_implausible_heading(samples, rate)
    return np.unwrap(samples.values)


def _position(table: Table, mapping: RecordingMapping, rate: float) -> FloatArray | None:
    if mapping.position is None:
        return None
    components = [read_samples(table, channel) for channel in mapping.position]
    for samples in components:
        plausibility.refuse_fast_position(samples, rate)
    return frames.world_z_up(_stacked(components), mapping.world_z or "up")


def _attitude(table: Table, mapping: RecordingMapping) -> FloatArray | None:
    if mapping.quaternion is None:
        return None
    components = [read_samples(table, channel) for channel in mapping.quaternion.channels]
    plausibility.refuse_other_than_unit_norm(components)
    return frames.attitude(
        _stacked(components),
        to_world=mapping.quaternion.rotation == "body to world",
        world_z=mapping.world_z or "up",
        left_up=mapping.body_axes == "forward left up",
    )


def _in_stroke_plane(
    table: Table, mapping: RecordingMapping, vector: VectorChannels | None, q_WB: FloatArray | None
) -> FloatArray | None:
    if vector is None:
        return None
    components = [read_samples(table, channel) for channel in vector.channels]
    check = plausibility.refuse_fast_turning if vector is mapping.angular_velocity else plausibility.refuse_fast_flight
    for samples in components:
        check(samples)
    values = _stacked(components)
    left_up = mapping.body_axes == "forward left up"
    if vector.frame == "world" and q_WB is not None:
        values = frames.world_to_body(frames.world_z_up(values, mapping.world_z or "up"), q_WB)
    else:
        values = frames.forward_right_down(values, left_up=left_up)
    if vector.frame == "stroke plane" or mapping.stroke_plane_angle is None:
        return values
    return frames.body_to_stroke_plane(values, mapping.stroke_plane_angle)


def _wing(table: Table, wing: WingChannels | None) -> WingAngles | None:
    if wing is None:
        return None
    stroke, deviation, pitch = (read_samples(table, channel) for channel in (wing.stroke, wing.deviation, wing.pitch))
    for samples in (stroke, deviation, pitch):
        plausibility.refuse_large_wing_angle(samples)
    plausibility.refuse_still_stroke(stroke)
    return WingAngles(stroke=stroke.values, deviation=deviation.values, pitch=pitch.values)


def _stacked(components: list[Samples]) -> FloatArray:
    return np.stack([samples.values for samples in components], axis=1)
