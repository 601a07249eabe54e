import contextlib
import json
import re
import sys
from functools import partial

import numpy as np
import pytest
from PIL import Image

from flycontrol import cli
from flycontrol.io.flight_experiments import experiment_text
from flycontrol.io.recordings import read_recording
from flycontrol.io.trials import read_trials

SHORT = "[march]\nwingbeats = 6\n"
PULSE = '[[pulse]]\naxis = "yaw"\ntorque = "3e-9 N m"\nonset = "2 wingbeats"\nduration = "1 wingbeat"\n'


def run(capsys, monkeypatch, *arguments):
    monkeypatch.setattr(sys, "argv", ["flycontrol", *map(str, arguments)])
    with pytest.raises(SystemExit) as done:
        cli.main()
    printed = capsys.readouterr()
    return done.value.code or 0, printed.out, printed.err


@pytest.fixture
def command(monkeypatch, capsys):
    """Run `flycontrol` in this process: exit status, standard output, standard error."""
    return partial(run, capsys, monkeypatch)


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
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sys, "argv", ["flycontrol", "simulate", f"{folder}/flight.toml", "--out", f"{folder}/out"])
        with contextlib.suppress(SystemExit):
            cli.main()
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
