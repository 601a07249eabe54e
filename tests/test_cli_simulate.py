import json
import re

import h5py
import numpy as np
import pytest
from command_line import exit_status
from PIL import Image

from flycontrol.io.flight_experiments import experiment_text
from flycontrol.io.recordings import read_recording
from flycontrol.io.trials import read_trials

SHORT = "[march]\nwingbeats = 6\n"
PULSE = '[[pulse]]\naxis = "yaw"\ntorque = "3e-9 N m"\nonset = "2 wingbeats"\nduration = "1 wingbeat"\n'


@pytest.fixture
def simulate(command, tmp_path):
    """Simulate an experiment given as text: status, standard error, folder."""

    def flown(text, *options, name="out"):
        file = tmp_path / "flight.toml"
        file.write_text(text)
        status, _, log = command("simulate", file, "--out", tmp_path / name, *options)
        return status, log, tmp_path / name

    return flown


@pytest.fixture(scope="module")
def pulsed(tmp_path_factory):
    """Folder of a short flight with a pulse."""
    folder = tmp_path_factory.mktemp("pulsed")
    (folder / "flight.toml").write_text(SHORT + PULSE)
    assert exit_status("simulate", folder / "flight.toml", "--out", folder / "out") == 0
    return folder / "out"


def test_a_flight_leaves_page_summary_trajectory_mapping_and_animation(pulsed):
    names = {"flight.gif", "index.html", "mapping.toml", "result.json", "trajectory.nc"}
    assert {path.name for path in pulsed.iterdir()} == names
    page = (pulsed / "index.html").read_text(encoding="utf-8")
    assert set(re.findall(r'(?:src|href)="([^#"]+)"', page)) == names - {"index.html"}
    with Image.open(pulsed / "flight.gif") as film:
        assert (film.n_frames, film.size) == (6 * 10 + 1, (720, 284))


def test_the_trajectory_is_a_recording_and_a_trial(pulsed):
    flown = read_recording(pulsed / "trajectory.nc", pulsed / "mapping.toml")
    (trial,) = read_trials([pulsed / "trajectory.nc"], pulsed / "mapping.toml")
    found = json.loads((pulsed / "result.json").read_text())
    assert len(flown.time) == 6 * 50 + 1
    assert trial.perturbation.duration * found["stroke"]["frequency_hz"] == pytest.approx(1, rel=1e-12)


def test_a_trimmed_fly_hovers_until_the_pulse_turns_it_to_the_right(pulsed):
    found = json.loads((pulsed / "result.json").read_text())
    flown = read_recording(pulsed / "trajectory.nc", pulsed / "mapping.toml")
    before = flown.time < 2 / found["stroke"]["frequency_hz"]
    assert found["status"] == "complete"
    assert found["beats"]["lift_weights"][:2] == pytest.approx([1, 1], abs=1e-4)  # means over samples, not over steps
    assert np.max(np.abs(flown.yaw[before])) < 1e-9
    assert np.max(np.linalg.norm(flown.position_W[before], axis=1)) < 0.05e-3
    assert found["yaw"]["peak_deg"] > 5


def test_the_same_experiment_gives_the_same_bytes(simulate):
    _, _, one = simulate(SHORT, name="one")
    _, _, other = simulate(SHORT, name="other")
    for path in sorted(one.iterdir()):
        assert path.read_bytes() == (other / path.name).read_bytes(), path.name


def test_the_printed_experiment_is_the_default_one(command):
    assert command("experiment") == (0, experiment_text(), "")


def test_a_flight_that_diverges_ends_with_status_3_and_keeps_what_was_flown(simulate):
    mad = '[march]\nwingbeats = 6\n[[pulse]]\naxis = "pitch"\ntorque = "1e-4 N m"\nonset = "3 wingbeats"\n'
    status, log, out = simulate(mad + 'duration = "1 wingbeat"')
    found = json.loads((out / "result.json").read_text())
    assert status == 3
    assert "stopped in wingbeat 3" in log
    assert found["status"] in log
    assert found["wingbeats"] == 3
    assert "stopped in wingbeat 3" in (out / "index.html").read_text(encoding="utf-8")
    with h5py.File(out / "trajectory.nc") as kept:
        assert len(kept["time"]) > 3 * 50


def test_what_cannot_be_flown_is_refused_in_a_sentence_and_nothing_is_written(simulate, command, tmp_path):
    (tmp_path / "file").write_text("x")
    for text, words in (
        ('[march]\ntolerance = "1e-9 rad"\nwingbeats = 2', "steps would do"),
        ("[march]\nsamples = 30", "must divide the 200 steps"),
        ("[march\n", "is not valid TOML"),
        (SHORT + PULSE.replace("2 wingbeats", "9 wingbeats"), "lies outside the flight"),
    ):
        status, log, out = simulate(text)
        assert (status, log.count("\n"), out.exists()) == (2, 1, False), log
        assert words in log
    status, _, log = command("simulate", "--out", tmp_path / "file")
    assert (status, log.count("\n")) == (2, 1)
    assert "is not a folder" in log


def test_an_ensemble_is_the_same_for_any_number_of_workers_and_leaves_nothing_unfinished(simulate):
    drawn = SHORT + PULSE + '[ensemble]\nflights = 3\nseed = 2\n[ensemble.spread]\ntorque = "10 %"\n'
    _, _, one = simulate(drawn, "--workers", "1", name="one")
    _, _, two = simulate(drawn, "--workers", "2", name="two")
    assert (one / "ensemble.csv").read_bytes() == (two / "ensemble.csv").read_bytes()
    rows = (one / "ensemble.csv").read_text().splitlines()
    assert len(set(rows)) == 1 + 3
    assert not (one / "unfinished").exists()
