"""When the samples were taken: frame numbers or times, which must count up evenly."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flycontrol.errors import InvalidInputError
from flycontrol.io.channels import Clock
from flycontrol.io.places import Scalar
from flycontrol.io.samples import Samples, read_samples
from flycontrol.io.scalars import read_scalar
from flycontrol.io.table_files import Table

FloatArray = NDArray[np.float64]

SLOWEST, FASTEST = 100.0, 1e6  #: frames a second that can resolve a wingbeat, and that a camera takes [1/s]
UNEVEN = 0.01  #: largest deviation of a time step from the median step, as a share of it


@dataclass(frozen=True, slots=True)
class SampleTimes:
    """Times of the samples and their rate."""

    time: FloatArray  #: (N,) [s]
    rate: float  #: [1/s]


def read_clock(table: Table, clock: Clock) -> SampleTimes:
    """t = start + frame / rate, or the file's own times.

    Raises
    ------
    InvalidInputError
        If frames or times repeat, go back, leave gaps, or come at a rate that no camera has.
    """
    count = _sample_count(table)
    if clock.time is not None:
        times = read_samples(table, clock.time)
        _refuse_backward(times)
        rate = _even_rate(times)
        _refuse_implausible(table, rate)
        return SampleTimes(times.values, rate)
    rate = _given_rate(table, clock)
    frames = np.arange(count, dtype=np.float64) if clock.frame is None else _frames(read_samples(table, clock.frame))
    return SampleTimes(clock.start + frames / rate, rate)


def read_clock_with_gaps(table: Table, clock: Clock) -> SampleTimes:
    """t = start + frame / rate, or the file's own times, whose median step tells the rate.

    Raises
    ------
    InvalidInputError
        If frames or times repeat, go back, or come at a rate that no camera has.
    """
    count = _sample_count(table)
    if clock.time is not None:
        times = read_samples(table, clock.time)
        _refuse_backward(times)
        rate = 1 / float(np.median(np.diff(times.values)))
        _refuse_implausible(table, rate)
        return SampleTimes(times.values, rate)
    rate = _given_rate(table, clock)
    if clock.frame is None:
        return SampleTimes(clock.start + np.arange(count) / rate, rate)
    frames = read_samples(table, clock.frame)
    broken = np.flatnonzero(frames.values != np.rint(frames.values))
    if broken.size:
        raise frames.refusal(int(broken[0]), f"is {frames.values[broken[0]]:.10g}; frames are whole numbers")
    _refuse_backward(frames)
    return SampleTimes(clock.start + frames.values / rate, rate)


def _sample_count(table: Table) -> int:
    count = len(table.numbers[0]) if len(table.numbers) else 0
    if count < 2:
        raise InvalidInputError(f"{table.file.name} holds {count} sample of each channel; a recording needs more.")
    return count


def _given_rate(table: Table, clock: Clock) -> float:
    if clock.rate is None:
        raise InvalidInputError(f"{table.file.name}: the mapping gives neither a rate nor times.")
    rate = read_scalar(table, clock.rate) if isinstance(clock.rate, Scalar) else clock.rate
    _refuse_implausible(table, rate)
    return rate


def _frames(frames: Samples) -> FloatArray:
    steps = np.diff(frames.values)
    bad = np.flatnonzero(steps != 1)
    if bad.size:
        before, after = frames.values[bad[0]], frames.values[bad[0] + 1]
        what = f"jumps from {before:.10g} to {after:.10g}"
        if after == before:
            what = f"holds frame {before:.10g} twice"
        raise frames.refusal(int(bad[0]) + 1, f"{what}; frames must count up by one: cut or fill the recording there")
    return frames.values


def _refuse_backward(times: Samples) -> None:
    steps = np.diff(times.values)
    backward = np.flatnonzero(steps <= 0)
    if backward.size:
        sample = int(backward[0]) + 1
        what = "repeats" if steps[sample - 1] == 0 else "goes back"
        text = f"{times.table.text(times.index, sample - 1)} to {times.table.text(times.index, sample)}"
        raise times.refusal(
            sample, f"{what} ({text}); {'times' if 'time' in times.channel.key else 'frames'} must increase"
        )


def _even_rate(times: Samples) -> float:
    steps = np.diff(times.values)
    median = float(np.median(steps))
    uneven = np.flatnonzero(np.abs(steps - median) > UNEVEN * median)
    if uneven.size:
        sample = int(uneven[0]) + 1
        raise times.refusal(
            sample,
            f"is uneven: a step of {steps[sample - 1]:.6g} s where {median:.6g} s is usual; cut or resample the "
            "recording, or map frame numbers and their rate if the times are only rounded",
        )
    return float((len(times.values) - 1) / (times.values[-1] - times.values[0]))


def _refuse_implausible(table: Table, rate: float) -> None:
    if not SLOWEST <= rate <= FASTEST:
        raise InvalidInputError(
            f"{table.file.name}: {rate:.6g} samples a second, outside the plausible {SLOWEST:g} to {FASTEST:g}; "
            "check the unit of the clock in the mapping."
        )
