"""What wing angles do from one wingbeat to the next without a trend: tracking noise, and at most that.

    e_k(p) = sqrt(2/3) (x_k(p) - (x_{k-1}(p) + x_{k+1}(p)) / 2)

at phase p of wingbeat k. White noise keeps its variance, a change that is steady over three wingbeats vanishes; true
changes that are quicker stay in, so that jitter is an upper bound of the noise.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import make_interp_spline

from flycontrol.model.recording import Recording, WingAngles
from flycontrol.model.stroke import both_wings
from flycontrol.model.wingbeats import Wingbeats, phase_average

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Jitter:
    """Residuals of n wingbeats at m phases, (n, m, 3): stroke, deviation, pitch [rad]."""

    left: FloatArray
    right: FloatArray

    @property
    def spread(self) -> FloatArray:
        """(3,) root mean square over both wings [rad]."""
        return np.sqrt(np.mean(np.concatenate([self.left, self.right]) ** 2, axis=(0, 1)))


def wingbeat_jitter(recording: Recording, beats: Wingbeats, samples: int = 40) -> Jitter:
    """Residuals of both wings in all wingbeats but the first and the last."""

    def residuals(wing: WingAngles) -> FloatArray:
        channels = (wing.stroke, wing.deviation, wing.pitch)
        x = np.stack([phase_average(c, recording.time, beats, samples).beats for c in channels], axis=-1)
        return np.sqrt(2 / 3) * (x[1:-1] - 0.5 * (x[2:] + x[:-2]))

    left, right = both_wings(recording)
    return Jitter(left=residuals(left), right=residuals(right))


def jittered(
    recording: Recording, beats: Wingbeats, jitter: Jitter, rng: np.random.Generator, scale: float = 1.0
) -> Recording:
    """The recording with jitter of wingbeats drawn at random added to its own, both wings from the same draw."""
    left, right = both_wings(recording)
    count = beats.count + 2  # the pieces before the first reversal and after the last
    picks = rng.integers(0, len(jitter.left), size=count)
    phase = make_interp_spline(beats.reversals, np.arange(1.0, count), k=1)(recording.time)
    return replace(
        recording,
        left=_added(left, scale * jitter.left[picks], phase),
        right=_added(right, scale * jitter.right[picks], phase),
    )


def _added(wing: WingAngles, jitter: FloatArray, phase: FloatArray) -> WingAngles:
    """Add (n, m, 3), in a line over the phases 0 to n, at the phases (N,)."""
    line = jitter.reshape(-1, 3)
    at = np.stack([np.interp(phase * jitter.shape[1], np.arange(len(line)), column) for column in line.T])
    stroke, deviation, pitch = at
    return WingAngles(stroke=wing.stroke + stroke, deviation=wing.deviation + deviation, pitch=wing.pitch + pitch)
