import json
import sys
from functools import partial

import h5py
import numpy as np
import pytest

from flycontrol import cli
from flycontrol.io.cameras import read_cameras
from flycontrol.io.recordings import read_recording
from flycontrol.io.trials import read_trials
from flycontrol.model.camera_forms import orthogonal_cameras
from flycontrol.units import mm

AIMS = {"yaw": 1, "pitch": 1, "roll": 3, "stroke": 2, "deviation": 2, "wing_pitch": 5}  #: root mean square [deg]


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


def flown(folder, *options):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sys, "argv", ["flycontrol", "track", "--out", str(folder), *options])
        with pytest.raises(SystemExit) as done:
            cli.main()
    assert done.value.code in (0, None)
    return folder


@pytest.fixture(scope="module")
def beat(tmp_path_factory):
    """Folder of one wingbeat of the simulated fly."""
    return flown(tmp_path_factory.mktemp("beat") / "out", "--wingbeats", "1")


def within_the_aims(error):
    limits = {f"{name}_deg": AIMS[name] for name in ("yaw", "pitch", "roll")}
    for side in ("left", "right"):
        limits |= {f"{side}_{name}_deg": AIMS[name] for name in ("stroke", "deviation")}
        limits[f"{side}_pitch_deg"] = AIMS["wing_pitch"]
    return {name: error[name] for name, limit in limits.items() if error[name] > limit} == {}


def test_the_simulated_fly_is_tracked_within_the_aims_and_its_truth_lies_beside_it(beat):
    found = json.loads((beat / "result.json").read_text())
    assert found["frames"]["tracked"] == found["frames"]["count"] == 36
    assert within_the_aims(found["error"]["raw"])
    with h5py.File(beat / "recording.nc") as file:
        assert file["true"].shape == file["raw"].shape == (36, 18)
        assert np.max(np.abs(file["raw"][:, :3] - file["true"][:, :3])) < 1 / (35 / mm)


def test_the_recording_is_read_through_its_mapping(beat):
    (trial,) = read_trials([beat / "recording.nc"], beat / "mapping.toml")
    assert (len(trial.time), trial.rate) == (36, pytest.approx(8000))


def test_the_cameras_are_those_that_filmed(beat):
    points = np.random.default_rng(0).uniform(-1, 1, (20, 3)) * mm
    filming = orthogonal_cameras(scale=35 / mm, shape=(256, 256), distance=120 * mm)
    for camera, again in zip(filming, read_cameras(beat / "cameras.toml"), strict=True):
        assert np.max(np.abs(camera.project(points) - again.project(points))) < 1e-3


def test_every_field_of_the_result_is_described(beat):
    found = json.loads((beat / "result.json").read_text())
    described = found.pop("fields")

    def paths(value, name=""):
        if isinstance(value, dict):
            for key, part in value.items():
                yield from paths(part, f"{name}.{key}" if name else key)
        elif isinstance(value, list):
            for part in value:
                yield from paths(part, f"{name}[]")
        else:
            yield name

    def told(path):
        words = path.split(".")
        return any(f"{'.'.join(words[:n])}.*" in described for n in range(len(words))) or path in described

    assert [path for path in paths(found) if not told(path)] == []


def test_what_cannot_be_meant_is_refused_in_a_sentence_and_nothing_is_written(command, tmp_path):
    for options, words in (
        (("--format", "xls"), "--format must be one of"),
        (("--stroke-plane-angle", "50"), "--stroke-plane-angle"),
        (("--body-length", "2 m"), "about as long as a wing"),
        (("--fly", "housefly"), "no fly of that name"),
        (("--frames", "1:5"), "belongs to films"),
        (("film.npz",), "--cameras is missing"),
        (("film.npz", "--cameras", "c.csv", "--up", "w"), "--up must be one of"),
    ):
        status, _, log = command("track", *options, "--out", tmp_path / "out")
        assert (status, log.count("\n"), (tmp_path / "out").exists()) == (2, 1, False), log
        assert words in log


@pytest.mark.slow
def test_the_default_flight_is_tracked_within_the_aims_and_reported_on(command, tmp_path):
    out = flown(tmp_path / "out")
    found = json.loads((out / "result.json").read_text())
    assert found["frames"]["lost"] == 0
    assert within_the_aims(found["error"]["raw"])
    assert within_the_aims(found["error"]["smoothed"])
    assert found["wingbeat_frequency_hz"] == pytest.approx(220, rel=0.01)
    assert len(read_recording(out / "recording.nc", out / "mapping.toml").time) == 363
    reading = ("--recording", out / "recording.nc", "--mapping", out / "mapping.toml")
    assert command("report", *reading, "--out", tmp_path / "report")[0] == 0
    assert not (out / "unfinished").exists()
