"""What a fit says of each recording: fitted samples, residuals, innovations, autocorrelations."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.signal
from numpy.typing import NDArray

from flycontrol.identify.gains.noise import Noise, whitened
from flycontrol.identify.gains.problem import Channel, TrialPart
from flycontrol.identify.gains.response import NAMES
from flycontrol.identify.gains.result import FitResult
from flycontrol.model.trial import Trial

FloatArray = NDArray[np.float64]
_LAGS = 80  #: of autocorrelations, in samples
_CURVE = 600  #: points of a fitted curve


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ChannelFit:
    """Measured and fitted samples of one channel of one recording."""

    kind: str  #: "yaw" or "paddling"
    time: FloatArray  #: of the samples (n,) [s]
    measured: FloatArray  #: (n,) [rad]
    residual: FloatArray  #: measured less fitted (n,) [rad]
    innovation: FloatArray  #: residual with the noise's correlation removed (n,), unit variance if the noise is right
    firsts: NDArray[np.int64]  #: indices at which a stretch without gap begins
    curve_time: FloatArray  #: evenly over the recording (m,) [s]
    curve: FloatArray  #: fitted (m,) [rad]
    noise: Noise

    @property
    def rms(self) -> float:
        """Root mean square of the residual [rad]."""
        return float(np.sqrt(np.mean(self.residual**2)))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RecordingFit:
    """One recording in the fit."""

    trial: Trial
    heading: float  #: fitted [rad]
    channels: tuple[ChannelFit, ...]  #: yaw, then paddling where it was measured

    @property
    def yaw(self) -> ChannelFit:
        """The first channel."""
        return self.channels[0]


def recording_fits(result: FitResult) -> tuple[RecordingFit, ...]:
    """Measured, fitted and left over, recording by recording, at the least-squares values."""
    x = result.minimum.x
    return tuple(
        RecordingFit(
            trial=part.trial,
            heading=_heading(part, x),
            channels=tuple(
                _channel_fit(part, channel, noise, x, k)
                for k, (channel, noise) in enumerate(zip(part.channels, noises, strict=True))
            ),
        )
        for part, noises in zip(result.problem.parts, result.noise, strict=True)
    )


def _heading(part: TrialPart, x: FloatArray) -> float:
    return float(part.parameters(x)[NAMES.index("heading")])


def _channel_fit(part: TrialPart, channel: Channel, noise: Noise, x: FloatArray, place: int) -> ChannelFit:
    residual = channel.values - part.predicted(x, False)[place][0]
    time = np.linspace(channel.times[0], channel.times[-1], _CURVE)
    return ChannelFit(
        kind=channel.kind,
        time=channel.times,
        measured=channel.values,
        residual=residual,
        innovation=whitened(residual[None, :], channel.firsts, noise)[0],
        firsts=channel.firsts,
        curve_time=time,
        curve=part.predicted_at(x, time)[place],
        noise=noise,
    )


def autocorrelation(values: FloatArray, firsts: NDArray[np.int64], lags: int = _LAGS) -> FloatArray:
    """Correlation of samples at lags 0 to `lags` (lags + 1,), pairs within stretches without gap; NaN for no pair."""
    products, pairs = np.zeros(lags + 1), np.zeros(lags + 1)
    for part in np.split(values - values.mean(), firsts[1:]):
        n = min(len(part), lags + 1)
        products[:n] += scipy.signal.correlate(part, part, method="auto")[len(part) - 1 : len(part) - 1 + n]
        pairs[:n] += len(part) - np.arange(n)
    with np.errstate(divide="ignore", invalid="ignore"):
        covariance = products / pairs
        return covariance / covariance[0]
