"""A simulated flight as a recording and as a trial."""

import numpy as np
import pytest

from flycontrol.errors import InvalidInputError, InvalidParameterError
from flycontrol.io.simulated_trials import MAPPING, simulated_trial_files
from flycontrol.io.trials import read_trials
from flycontrol.model.simulated_recording import CameraNoise, simulated_recording, simulated_trial
from flycontrol.model.stroke import WingMotion
from flycontrol.model.trajectory import Trajectory
from flycontrol.model.trial import Pulse
from flycontrol.units import deg

FREQUENCY, FRAMES, BEATS = 200.0, 40, 12
PULSE = Pulse(onset=0.01, duration=0.005)


def turning(d_alpha: float = 3 * deg) -> Trajectory:
    """A level fly that yaws at 20 rad/s while its wings paddle."""
    phase = np.arange(FRAMES * BEATS + 1) / FRAMES
    time, still = phase / FREQUENCY, np.zeros((len(phase), 3))
    yaw = 20.0 * time
    turned = np.stack([np.zeros_like(yaw), np.cos(yaw / 2), -np.sin(yaw / 2), np.zeros_like(yaw)], axis=1)

    def wing(sign):
        flat = np.zeros_like(phase)
        return WingMotion(
            stroke=-np.cos(2 * np.pi * phase),
            deviation=flat,
            pitch=np.pi / 2 + sign * d_alpha + flat,
            stroke_rate=2 * np.pi * FREQUENCY * np.sin(2 * np.pi * phase),
            deviation_rate=flat,
            pitch_rate=flat,
        )

    return Trajectory(
        time=time,
        phase=phase,
        frequency=FREQUENCY,
        position_W=still,
        q_WS=turned,
        velocity_S=still,
        angular_velocity_S=np.tile([0.0, 0.0, 20.0], (len(phase), 1)),
        acceleration_S=still,
        angular_acceleration_S=still,
        left=wing(-1),
        right=wing(1),
        left_acceleration=still,
        right_acceleration=still,
        wingbeats=BEATS,
        samples_per_wingbeat=FRAMES,
        status="complete",
    )


def test_without_noise_a_recording_is_the_flight():
    flight = turning()
    seen = simulated_recording(flight, "one", stroke_plane_angle=45 * deg)
    np.testing.assert_allclose(seen.yaw, flight.yaw, rtol=0, atol=1e-12)
    np.testing.assert_array_equal(seen.right.pitch, flight.right.pitch)
    np.testing.assert_array_equal(seen.angular_velocity_S, flight.angular_velocity_S)
    assert seen.rate == FREQUENCY * FRAMES


def test_a_trial_has_the_paddling_of_each_wingbeat_in_its_middle():
    trial = simulated_trial(turning(), "one", PULSE)
    there = np.flatnonzero(np.isfinite(trial.paddling))
    np.testing.assert_array_equal(there, FRAMES // 2 + FRAMES * np.arange(BEATS))
    np.testing.assert_allclose(trial.paddling[there], 3 * deg, rtol=1e-12)


def test_noise_has_the_deviation_that_is_asked_for_and_the_same_seed_gives_the_same_trial():
    flight, noise = turning(), CameraNoise(yaw=0.5 * deg, wing_angle=2 * deg)
    first, again = (simulated_trial(flight, "one", PULSE, noise=noise, rng=np.random.default_rng(3)) for _ in range(2))
    np.testing.assert_array_equal(first.yaw, again.yaw)
    spread = (first.yaw - flight.yaw).std() / (0.5 * deg)
    assert abs(spread - 1) < 4 / np.sqrt(2 * len(flight.time))  # four standard errors of a deviation
    seen = simulated_recording(flight, "one", stroke_plane_angle=0.0, noise=noise, rng=np.random.default_rng(4))
    assert seen.angular_velocity_S is None
    assert abs((seen.left.stroke - flight.left.stroke).std() / (2 * deg) - 1) < 4 / np.sqrt(2 * len(flight.time))
    assert abs((seen.yaw - flight.yaw).std() / (0.5 * deg) - 1) < 4 / np.sqrt(2 * len(flight.time))


def test_tables_of_trials_come_back_through_the_shipped_mapping(tmp_path):
    trials = [
        simulated_trial(turning(), name, PULSE, fly="fly1", noise=CameraNoise(yaw=deg), rng=np.random.default_rng(k))
        for k, name in enumerate(("weak", "strong"))
    ]
    for name, text in simulated_trial_files(trials).items():
        (tmp_path / name).write_text(text)
    back = {trial.name: trial for trial in read_trials([tmp_path / "weak.csv", tmp_path / "strong.csv"], MAPPING)}
    for trial in trials:
        same = back[trial.name]
        np.testing.assert_allclose(same.yaw, trial.yaw, rtol=0, atol=1e-8)
        np.testing.assert_allclose(same.time, trial.time, rtol=0, atol=1e-11)
        np.testing.assert_allclose(same.paddling, trial.paddling, rtol=0, atol=1e-9)
        assert (same.fly, same.perturbation) == ("fly1", PULSE)


def test_what_cannot_be_recorded_is_refused_in_a_sentence():
    with pytest.raises(InvalidParameterError, match="give rng"):
        simulated_trial(turning(), "one", PULSE, noise=CameraNoise(yaw=deg))
    with pytest.raises(InvalidParameterError, match="must be >= 0 rad"):
        CameraNoise(yaw=-1.0)
    with pytest.raises(InvalidParameterError, match="finite stroke plane angle in rad, got nan"):
        simulated_recording(turning(), "one", stroke_plane_angle=float("nan"))
    trial = simulated_trial(turning(), "one", PULSE)
    with pytest.raises(InvalidInputError, match="Two simulated trials"):
        simulated_trial_files([trial, trial])
    with pytest.raises(InvalidInputError, match="take letters"):
        simulated_trial_files([simulated_trial(turning(), "a,b", PULSE)])
