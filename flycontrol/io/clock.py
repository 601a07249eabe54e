"""When the samples were taken: frame numbers or times, which must count up evenly."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flycontrol.errors import InvalidInputError
from flycontrol.io.channels import Clock
from flycontrol.io.samples import Samples, read_samples
from flycontrol.io.tables import TextTable

FloatArray = NDArray[np.float64]

SLOWEST, FASTEST = 100.0, 1e6  #: frames a second that can resolve a wingbeat, and that a camera takes [1/s]
UNEVEN = 0.01  #: largest deviation of a time step from the median step, as a share of it


@dataclass(frozen=True, slots=True)
class SampleTimes:
    """Times of the samples and their rate."""

    time: FloatArray  #: (N,) [s]
    rate: float  #: [1/s]


def read_clock(table: TextTable, clock: Clock) -> SampleTimes:
    """t = frame / rate, or the file's own times.

    Raises
    ------
    InvalidInputError
        If frames or times repeat, go back, leave gaps, or come at a rate that no camera has.
    """
    count = table.numbers.shape[1]
    if count < 2:
        raise InvalidInputError(f"{table.file.name} holds {count} sample of each channel; a recording needs more.")
    if clock.time is not None:
        times = read_samples(table, clock.time)
        rate = _even_rate(times)
        _refuse_implausible(table, rate)
        return SampleTimes(times.values, rate)
    if clock.rate is None:
        raise InvalidInputError(f"{table.file.name}: the mapping gives neither a rate nor times.")
    _refuse_implausible(table, clock.rate)
    frames = np.arange(count, dtype=np.float64) if clock.frame is None else _frames(read_samples(table, clock.frame))
    return SampleTimes(frames / clock.rate, clock.rate)


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


def _even_rate(times: Samples) -> float:
    steps = np.diff(times.values)
    backward = np.flatnonzero(steps <= 0)
    if backward.size:
        sample = int(backward[0]) + 1
        what = "repeats" if steps[sample - 1] == 0 else "goes back"
        text = f"{times.table.text(times.index, sample - 1)} to {times.table.text(times.index, sample)}"
        raise times.refusal(sample, f"{what} ({text}); times must increase")
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


def _refuse_implausible(table: TextTable, rate: float) -> None:
    if not SLOWEST <= rate <= FASTEST:
        raise InvalidInputError(
            f"{table.file.name}: {rate:.6g} samples a second, outside the plausible {SLOWEST:g} to {FASTEST:g}; "
            "check the unit of the clock in the mapping."
        )
