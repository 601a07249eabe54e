import numpy as np
import pytest

from flycontrol.errors import InvalidInputError
from flycontrol.model.recording import Recording, WingAngles
from flycontrol.model.wingbeats import Wingbeats, phase_average, segment_wingbeats, wingbeat_mean
from flycontrol.units import deg

RATE = 7500.0


def flapping(seconds: float = 0.1, frequency: float = 187.3, start: float = 0.0013, noise: float = 0.0) -> Recording:
    """Both wings on a sine stroke whose dorsal reversals lie at start + k / frequency."""
    time = np.arange(int(seconds * RATE)) / RATE
    rng = np.random.default_rng(1)
    wings = [
        WingAngles(
            stroke=-70 * deg * np.cos(2 * np.pi * frequency * (time - start)) + noise * rng.standard_normal(len(time)),
            deviation=np.zeros_like(time),
            pitch=np.full_like(time, 90 * deg),
        )
        for _ in range(2)
    ]
    return Recording(name="made", rate=RATE, time=time, source_sha256="", left=wings[0], right=wings[1])


def true_reversals(recording: Recording, frequency: float = 187.3, start: float = 0.0013) -> np.ndarray:
    return start + np.arange(len(segment_wingbeats(recording).reversals)) / frequency


def test_dorsal_reversals_are_found_between_the_samples():
    recording = flapping()
    # the quartic leaves the sixth-order term of a cosine, off centre by at most half a sample
    np.testing.assert_allclose(segment_wingbeats(recording).reversals, true_reversals(recording), atol=0.01 / RATE)


def test_noise_of_two_degrees_moves_a_reversal_by_less_than_half_a_sample():
    recording = flapping(noise=2 * deg)
    np.testing.assert_allclose(segment_wingbeats(recording).reversals, true_reversals(recording), atol=0.5 / RATE)


def test_every_whole_wingbeat_of_the_record_is_counted():
    recording = flapping(seconds=0.2)
    inside = int(np.floor((recording.time[-1] - 0.0013) * 187.3))
    assert segment_wingbeats(recording).count == inside


def test_the_frequency_of_every_wingbeat_comes_back():
    np.testing.assert_allclose(segment_wingbeats(flapping()).frequencies, 187.3, rtol=1e-3)


def test_a_chirp_is_followed_beat_by_beat():
    time = np.arange(1500) / RATE
    cycles = 180 * time + 75 * time**2  # 180 to 210 Hz, as a startled fly does
    wing = WingAngles(stroke=-1.2 * np.cos(2 * np.pi * cycles), deviation=0 * time, pitch=0 * time + 1.5)
    beats = segment_wingbeats(Recording(name="c", rate=RATE, time=time, source_sha256="", left=wing, right=wing))
    np.testing.assert_allclose(beats.frequencies, 180 + 150 * beats.middles, rtol=3e-3)


def test_a_phase_average_of_a_periodic_channel_has_no_spread():
    recording = flapping()
    assert recording.left is not None
    exact = Wingbeats(reversals=0.0013 + np.arange(15) / 187.3)
    average = phase_average(recording.left.stroke, recording.time, exact)
    np.testing.assert_allclose(average.mean, -70 * deg * np.cos(2 * np.pi * average.phase), atol=1e-5)
    assert np.max(average.spread) < 1e-5


def test_the_mean_over_a_wingbeat_is_exact_for_a_ramp():
    time = np.arange(100) / RATE
    beats = Wingbeats(reversals=np.array([0.0011, 0.0043, 0.0101]))
    np.testing.assert_allclose(wingbeat_mean(3.0 * time, time, beats), 3.0 * beats.middles, rtol=1e-12)


def test_fewer_than_three_wingbeats_are_refused():
    with pytest.raises(InvalidInputError, match="2 whole wingbeats were found and at least 3 are needed"):
        segment_wingbeats(flapping(seconds=0.016, start=0.001))


def test_still_wings_and_degrees_called_radians_are_refused():
    still = WingAngles(stroke=np.zeros(300), deviation=np.zeros(300), pitch=np.zeros(300))
    time = np.arange(300) / RATE
    with pytest.raises(InvalidInputError, match="flapping needs at least 20 deg"):
        segment_wingbeats(Recording(name="s", rate=RATE, time=time, source_sha256="", left=still, right=still))
    wild = WingAngles(stroke=70 * np.cos(1200 * time), deviation=np.zeros(300), pitch=np.zeros(300))
    with pytest.raises(InvalidInputError, match="calls degrees radians"):
        segment_wingbeats(Recording(name="w", rate=RATE, time=time, source_sha256="", left=wild, right=wild))


def test_a_recording_without_wings_is_refused():
    with pytest.raises(InvalidInputError, match="needs stroke, deviation and pitch of both wings"):
        segment_wingbeats(Recording(name="n", rate=RATE, time=np.arange(100) / RATE, source_sha256=""))
