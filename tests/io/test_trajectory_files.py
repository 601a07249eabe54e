import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from flycontrol.io.flight_experiments import read_flight_experiment
from flycontrol.io.recordings import read_recording
from flycontrol.io.trajectory_files import FILE_NAMES, FORMATS, trajectory_writer
from flycontrol.io.trajectory_mapping import trajectory_mapping
from flycontrol.io.trials import read_trials
from flycontrol.model.trajectory import Trajectory, wing_motion_of
from flycontrol.units import deg

RATE, FREQUENCY, ANGLE = 11_000.0, 220.0, 55 * deg


def turning_flight(first, last):
    """A level flight that turns to the right at 5 rad/s, from sample `first` to sample `last`."""
    time = np.arange(first, last + 1) / RATE
    yaw, zero = 5.0 * time, np.zeros_like(time)
    beat = 2 * np.pi * FREQUENCY
    wings = np.stack([1.2 * np.cos(beat * time), 0.1 * np.sin(beat * time), 1.5 + np.sin(beat * time)], axis=1)
    rates = beat * np.stack([-1.2 * np.sin(beat * time), 0.1 * np.cos(beat * time), np.cos(beat * time)], axis=1)
    motion = wing_motion_of(wings, rates)
    still = np.zeros((len(time), 3))
    return Trajectory(
        time=time,
        phase=FREQUENCY * time,
        frequency=FREQUENCY,
        position_W=np.stack([0.1 * time, zero, zero], axis=1),
        q_WS=np.stack([zero, np.cos(yaw / 2), -np.sin(yaw / 2), zero], axis=1),
        velocity_S=np.stack([0.1 * np.cos(yaw), -0.1 * np.sin(yaw), zero], axis=1),
        angular_velocity_S=np.stack([zero, zero, zero + 5.0], axis=1),
        acceleration_S=still,
        angular_acceleration_S=still,
        left=motion,
        right=motion,
        left_acceleration=still,
        right_acceleration=still,
        wingbeats=last // 50,
        samples_per_wingbeat=50,
        status="complete",
    )


def written(folder, form):
    """A flight of 8,000 samples, handed over in three pieces that share their ends: path of its file."""
    path = folder / FILE_NAMES[form]
    with trajectory_writer(path, form, stroke_plane_angle=ANGLE, about={"title": "t"}, name=path.name) as writer:
        for first, last in ((0, 3000), (3000, 5000), (5000, 8000)):
            writer.add(turning_flight(first, last))
    return path


@pytest.mark.parametrize("form", FORMATS)
def test_a_written_trajectory_is_read_back_as_a_recording(form, tmp_path):
    path, mapping = written(tmp_path, form), tmp_path / "mapping.toml"
    mapping.write_text(trajectory_mapping(read_flight_experiment(), FREQUENCY, form))
    found, true = read_recording(path, mapping), turning_flight(0, 8000)
    tolerance = 1e-13  # fifteen digits in CSV, and turning into the body's axes and back
    assert found.rate == pytest.approx(RATE, rel=1e-9)
    np.testing.assert_allclose(found.time, true.time, atol=tolerance)
    np.testing.assert_allclose(found.yaw, 5.0 * true.time, atol=tolerance)
    np.testing.assert_allclose(found.position_W, true.position_W, atol=tolerance)
    np.testing.assert_allclose(found.velocity_S, true.velocity_S, atol=tolerance)
    np.testing.assert_allclose(found.angular_velocity_S, true.angular_velocity_S, atol=tolerance)
    for side in ("left", "right"):
        for angle in ("stroke", "deviation", "pitch"):
            np.testing.assert_allclose(
                getattr(getattr(found, side), angle), getattr(true.wing(side), angle), atol=tolerance
            )
    nose = 2 * (found.q_WB[:, 1] * found.q_WB[:, 3] - found.q_WB[:, 0] * found.q_WB[:, 2])
    np.testing.assert_allclose(nose, np.sin(ANGLE), atol=tolerance)  # the nose points up by the stroke plane's angle


@pytest.mark.parametrize("form", FORMATS)
def test_a_written_trajectory_is_a_trial_with_its_pulse(form, tmp_path):
    path, mapping = written(tmp_path, form), tmp_path / "mapping.toml"
    mapping.write_text(trajectory_mapping(read_flight_experiment(), FREQUENCY, form))
    (trial,) = read_trials([path], mapping)
    assert trial.perturbation.onset == pytest.approx(5 / FREQUENCY, rel=1e-12)
    assert trial.perturbation.duration == pytest.approx(1 / FREQUENCY, rel=1e-12)


def test_heading_goes_on_across_pieces_beyond_half_a_turn(tmp_path):
    path, mapping = written(tmp_path, "netcdf"), tmp_path / "mapping.toml"
    mapping.write_text(trajectory_mapping(read_flight_experiment(), FREQUENCY, "netcdf"))
    assert read_recording(path, mapping).yaw[-1] == pytest.approx(5.0 * 8000 / RATE, abs=1e-12)  # 208 deg


@pytest.mark.parametrize("form", FORMATS)
def test_the_same_flight_is_the_same_bytes(form, tmp_path):
    (tmp_path / "a").mkdir()
    (tmp_path / "b").mkdir()
    assert written(tmp_path / "a", form).read_bytes() == written(tmp_path / "b", form).read_bytes()


WRITE = """
import resource, sys
from pathlib import Path
sys.path.insert(0, {tests!r})
from test_trajectory_files import written
from flycontrol.errors import OutputError
resource.setrlimit(resource.RLIMIT_FSIZE, ({limit}, {limit}))
try:
    written(Path({folder!r}), {form!r})
except OutputError as refusal:
    print(refusal)
"""


@pytest.mark.skipif(sys.platform == "win32", reason="needs limits on the size of files")
@pytest.mark.parametrize("form", FORMATS)
@pytest.mark.parametrize("limit", [0, 100_000])
def test_a_full_disk_is_a_sentence_and_no_crash(form, limit, tmp_path):
    code = WRITE.format(tests=str(Path(__file__).parent), limit=limit, folder=str(tmp_path), form=form)
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False, env=os.environ)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout == f"{FILE_NAMES[form]} could not be written: File too large.\n"


def test_two_pulses_leave_a_mapping_without_a_perturbation_and_with_a_remark(tmp_path):
    from flycontrol.io.flight_experiments import read_flight_experiment
    from flycontrol.io.trajectory_mapping import trajectory_mapping

    pulse = '[[pulse]]\naxis = "{}"\ntorque = "1e-9 N m"\nonset = "2 wingbeats"\nduration = "2 wingbeats"\n'
    (tmp_path / "two.toml").write_text(pulse.format("yaw") + pulse.format("roll"))
    text = trajectory_mapping(read_flight_experiment(tmp_path / "two.toml"), 220.0, "netcdf")
    assert "\n[perturbation]" not in text
    assert "# 2 torque pulses acted" in text
