"""Wingbeats: where each begins, how fast they follow one another, and averages over them.

A wingbeat runs from one dorsal (backmost) reversal of the stroke to the next: forward stroke first.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.signal import butter, find_peaks, sosfiltfilt

from flycontrol.errors import InvalidInputError
from flycontrol.model.recording import Recording
from flycontrol.model.stroke import both_wings
from flycontrol.units import deg

FloatArray = NDArray[np.float64]

FEWEST_WINGBEATS = 3
SLOWEST, FASTEST = 20.0, 1000.0  #: wingbeats a second that any flying insect could have [1/s]
SMALLEST_STROKE = 20 * deg  #: peak to peak; less is not flapping [rad]


@dataclass(frozen=True, slots=True, kw_only=True)
class Wingbeats:
    """n wingbeats, given by their n + 1 dorsal reversals."""

    reversals: FloatArray  #: (n + 1,) dorsal reversals, sub-sample precision [s]

    @property
    def count(self) -> int:
        """Number of whole wingbeats."""
        return len(self.reversals) - 1

    @property
    def durations(self) -> FloatArray:
        """(n,) duration of each wingbeat [s]."""
        return np.diff(self.reversals)

    @property
    def frequencies(self) -> FloatArray:
        """(n,) frequency of each wingbeat [1/s]."""
        return 1.0 / self.durations

    @property
    def middles(self) -> FloatArray:
        """(n,) middle of each wingbeat [s]."""
        return 0.5 * (self.reversals[1:] + self.reversals[:-1])

    @property
    def mean_frequency(self) -> float:
        """Wingbeats counted over the time they took [1/s]."""
        return self.count / float(self.reversals[-1] - self.reversals[0])


@dataclass(frozen=True, slots=True, kw_only=True)
class PhaseAverage:
    """A channel over the phase of the wingbeat: phase 0 is the dorsal reversal, 1 (not included) the next."""

    phase: FloatArray  #: (m,) [wingbeats]
    beats: FloatArray  #: (n, m) every wingbeat, resampled on phase, unit of the channel
    mean: FloatArray  #: (m,)
    spread: FloatArray  #: (m,) standard deviation over the wingbeats


def dominant_frequency(signal: FloatArray, rate: float) -> float:
    """Largest peak of the periodogram between 20 and 1000 Hz [1/s], after the mean is taken out."""
    padded = max(4096, 4 * len(signal))
    power = np.abs(np.fft.rfft((signal - signal.mean()) * np.hanning(len(signal)), padded)) ** 2
    frequency = np.fft.rfftfreq(padded, 1.0 / rate)
    inside = (frequency >= SLOWEST) & (frequency <= FASTEST)
    return float(frequency[inside][np.argmax(power[inside])])


def low_passed(signal: FloatArray, rate: float, cutoff: float) -> FloatArray:
    """Zero-phase fourth-order Butterworth, forward and backward; left as it is when the cutoff is beyond 0.45 rate."""
    if cutoff >= 0.45 * rate:
        return signal
    sections = butter(4, cutoff, fs=rate, output="sos")
    padding = min(len(signal) - 1, int(3 * rate / cutoff))
    return sosfiltfilt(sections, signal, padlen=padding)


def segment_wingbeats(recording: Recording) -> Wingbeats:
    """Dorsal reversals of the mean stroke angle of both wings, the minima of phi, between the samples.

    The stroke low-passed at three times the wingbeat frequency tells which minima are reversals; a quartic fitted to
    the unfiltered samples around each tells when: with 2 deg of noise at 40 samples a wingbeat, to 0.1 of a sample.

    Raises
    ------
    InvalidInputError
        Fewer than three wingbeats, no flapping, or beats so uneven that one of them must have been missed.
    """
    left, right = both_wings(recording)
    stroke = 0.5 * (left.stroke + right.stroke)
    _refuse_still_wings(stroke, recording.name)
    frequency = dominant_frequency(stroke, recording.rate)
    smooth = low_passed(stroke, recording.rate, 3.0 * frequency)
    apart = max(1, int(0.6 * recording.rate / frequency))
    # the record's edges cannot hold a reversal: a turning point needs samples on both sides
    minima, _ = find_peaks(-smooth, distance=apart, prominence=0.25 * float(np.ptp(smooth)))
    reversals = _refined(recording.time, stroke, minima, max(3, round(recording.rate / frequency / 6)))
    _refuse_implausible(reversals, recording.name)
    return Wingbeats(reversals=reversals)


def phase_average(channel: FloatArray, time: FloatArray, beats: Wingbeats, samples: int = 100) -> PhaseAverage:
    """Mean and spread of a channel over the wingbeats, each resampled by a cubic spline on its own phase.

    Parameters
    ----------
    channel : (N,) any unit
    time : (N,) [s]
    beats : the wingbeats
    samples : points a wingbeat
    """
    phase = np.arange(samples) / samples
    at = beats.reversals[:-1, None] + phase * beats.durations[:, None]
    each = CubicSpline(time, channel)(at)
    return PhaseAverage(phase=phase, beats=each, mean=each.mean(axis=0), spread=each.std(axis=0, ddof=1))


def wingbeat_mean(channel: FloatArray, time: FloatArray, beats: Wingbeats) -> FloatArray:
    """(1/T) integral of the channel over each wingbeat, exact for the cubic spline through the samples.

    Parameters
    ----------
    channel : (N,) or (N, k), any unit
    time : (N,) [s]
    """
    integral = CubicSpline(time, channel).antiderivative()(beats.reversals)
    durations = beats.durations.reshape((-1,) + (1,) * (np.ndim(channel) - 1))
    return np.diff(integral, axis=0) / durations


def _refined(time: FloatArray, stroke: FloatArray, minima: NDArray[np.intp], half: int) -> FloatArray:
    """Find the turning point of a quartic through the samples within a sixth of a period of each coarse minimum [s]."""
    found: list[float] = []
    for i in minima:
        window = slice(max(i - half, 0), min(i + half + 1, len(time)))
        quartic = np.polynomial.Polynomial.fit(time[window] - time[i], stroke[window], 4)
        turning = np.asarray(quartic.deriv().roots())
        real = turning[np.abs(turning.imag) < 1e-9].real
        found.append(float(time[i] + real[np.argmin(np.abs(real))]))
    return np.array(found, dtype=np.float64)


def _refuse_still_wings(stroke: FloatArray, name: str) -> None:
    amplitude = float(np.ptp(stroke))
    if not amplitude >= SMALLEST_STROKE:
        raise InvalidInputError(
            f"{name}: the stroke angle moves by {amplitude / deg:.3g} deg in all, where flapping needs at least "
            f"{SMALLEST_STROKE / deg:.0f} deg; check the stroke channels and their unit in the mapping."
        )
    if amplitude > 2 * np.pi:
        raise InvalidInputError(
            f"{name}: the stroke angle moves by {amplitude / deg:.3g} deg, more than a full turn; "
            "the mapping probably calls degrees radians."
        )


def _refuse_implausible(reversals: FloatArray, name: str) -> None:
    count = max(len(reversals) - 1, 0)
    if count < FEWEST_WINGBEATS:
        raise InvalidInputError(
            f"{name}: {count} whole wingbeats were found and at least {FEWEST_WINGBEATS} are needed; "
            "use a longer recording, or check the sampling rate and the stroke channels in the mapping."
        )
    durations = np.diff(reversals)
    typical = float(np.median(durations))
    odd = np.flatnonzero(np.abs(durations / typical - 1.0) > 0.4)
    if odd.size:
        raise InvalidInputError(
            f"{name}: the wingbeat at {reversals[odd[0]]:.4f} s lasts {durations[odd[0]] * 1e3:.2f} ms where "
            f"{typical * 1e3:.2f} ms is typical, so a reversal was missed or invented; check the stroke channels there."
        )
