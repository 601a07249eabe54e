import json
from dataclasses import replace

import h5py
import numpy as np
import pytest
from command_line import exit_status
from PIL import Image

from flycontrol.cli.track_inputs import FilmOptions, FlyOptions, track_inputs
from flycontrol.errors import InvalidInputError
from flycontrol.io.cameras import read_cameras
from flycontrol.io.morphology_files import read_morphology
from flycontrol.io.recordings import read_recording
from flycontrol.io.trials import read_trials
from flycontrol.model.camera_forms import orthogonal_cameras
from flycontrol.units import deg, mm
from flycontrol.vision.example_flight import example_flight
from flycontrol.vision.flies import fly_of
from flycontrol.vision.render import render_silhouettes

AIMS = {"yaw": 1, "pitch": 1, "roll": 3, "stroke": 2, "deviation": 2, "wing_pitch": 5}  #: root mean square [deg]


def flown(folder, *options):
    assert exit_status("track", "--out", folder, *options) == 0
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
    assert found["frames"]["tracked"] + found["frames"]["partial"] == found["frames"]["count"] == 36
    assert within_the_aims(found["error"]["raw"])
    with h5py.File(beat / "recording.nc") as file:
        assert file["true"].shape == file["raw"].shape == (36, 18)
        assert np.max(np.abs(file["raw"][:, :3] - file["true"][:, :3])) < 1 / (35 / mm)


def test_the_recording_is_read_through_its_mapping(beat):
    (trial,) = read_trials([beat / "recording.nc"], beat / "mapping.toml")
    assert (len(trial.time), trial.rate) == (36, pytest.approx(8000))


def test_the_frame_rate_of_the_result_is_that_of_filming_to_the_last_digit(beat):
    assert json.loads((beat / "result.json").read_text())["frames"]["rate_hz"] == 8000


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
        (("--stroke-plane-angle", "400 deg"), "outside -180 to 180 deg"),
        (("--body-length", "2 m"), "about as long as a wing"),
        (("--fly", "housefly"), "no fly of that name"),
        (("--frames", "1:5"), "belongs to films"),
        (("--grey",), "--grey belongs to films"),
        (("--contrast", "10"), "--contrast belongs to films"),
        (("film.npz", "--cameras", "c.csv", "--wingbeats", "3"), "--wingbeats belongs to the simulated fly"),
        (("film.npz",), "--cameras is missing"),
        (("film.npz", "--cameras", "c.csv", "--up", "w"), "--up must be one of"),
        (("film.npz", "--cameras", "c.csv", "--dust", "3"), "--dust is 3, but it is a share"),
        (("film.npz", "--cameras", "c.csv", "--contrast", "0"), "--contrast is 0, but it must be above 0"),
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


def test_an_option_that_chooses_an_array_is_named_where_it_is_needed_and_refused_where_it_is_not(command, tmp_path):
    np.savez(tmp_path / "film.npz", masks=np.zeros((4, 3, 32, 32), bool), P=np.zeros((3, 3, 4)), Q=np.zeros((3, 3, 4)))
    np.save(tmp_path / "film.npy", np.zeros((4, 3, 32, 32), bool))
    given = ("--cameras", tmp_path / "film.npz", "--frame-rate", "8000", "--out", tmp_path / "out", "--film-variable")
    for film, variable, words in (
        ("film.npz", "masks", "P, Q could be cameras; name one by --camera-variable."),
        ("film.npy", "x", "--film-variable x names an array of a .npz file, but film.npy is none"),
    ):
        status, _, log = command("track", tmp_path / film, *given, variable)
        assert (status, log.count("\n"), (tmp_path / "out").exists()) == (2, 1, False), log
        assert words in log


CAMERAS = orthogonal_cameras(scale=26 / mm, shape=(192, 192), distance=120 * mm)
Z_DOWN = np.diag([1.0, -1.0, -1.0])


@pytest.fixture(scope="module")
def masks():
    """(12, 3, 192, 192) silhouettes of a simulated flight, and its truth."""
    made = example_flight(fly_of(read_morphology("drosophila_melanogaster").morphology))
    return np.array(list(render_silhouettes(made.shape, made.truth[:12], CAMERAS))), made.truth[:12]


def saved(folder, frames, cameras=CAMERAS, **more):
    """A .npz file of silhouettes with the cameras' matrices in mm."""
    matrices = np.array([camera.matrix * [mm, mm, mm, 1] for camera in cameras])
    np.savez(folder / "film.npz", masks=np.asarray(frames), P=matrices, **more)
    return folder / "film.npz"


@pytest.fixture
def tracked(command, tmp_path):
    """Track a film: status, standard error, folder."""

    def run(film, *options):
        given = ("--cameras", film, "--camera-variable", "P", "--film-variable", "masks")
        status, _, log = command("track", film, *given, "--out", tmp_path / "out", *options)
        return status, log, tmp_path / "out"

    return run


def test_a_film_in_a_world_whose_z_points_down_comes_out_upright(tracked, masks, tmp_path):
    frames, truth = masks
    film = saved(tmp_path, frames, [camera.moved(Z_DOWN) for camera in CAMERAS])
    status, log, out = tracked(film, "--up=-z", "--frame-rate", "8000", "--no-fit-sizes", "--format", "csv")
    assert status == 0, log
    found = np.genfromtxt(out / "recording.csv", delimiter=",", names=True)
    assert np.max(np.abs(found["raw_yaw"] - truth.yaw)) < 2 * deg
    assert np.max(np.abs(found["raw_pitch"] - truth.pitch)) < 2 * deg
    assert np.max(np.abs(found["position_W_z"] - truth.position_W[:, 2])) < 1 / (26 / mm)
    assert np.array_equal(found["frame"], np.arange(12))
    assert "x, -y, -z of the calibration" in json.loads((out / "result.json").read_text())["world"]


def test_some_frames_of_a_film_keep_their_numbers_and_times(tracked, masks, tmp_path):
    film = saved(tmp_path, masks[0])
    status, log, out = tracked(film, "--frame-rate", "8000", "--no-fit-sizes", "--frames", "3:7:2")
    assert status == 0, log
    with h5py.File(out / "recording.nc") as file:
        assert list(file["frame"]) == [3, 5, 7]
        assert np.allclose(file["time"], np.array([3, 5, 7]) / 8000, rtol=1e-12)
    assert json.loads((out / "result.json").read_text())["frames"]["rate_hz"] == 4000


def test_a_fly_that_leaves_for_good_ends_with_status_3_and_says_when(tracked, masks, tmp_path):
    gone = np.zeros((44, *masks[0].shape[1:]), dtype=bool)
    status, log, out = tracked(saved(tmp_path, [*masks[0][:6], *gone]), "--frame-rate", "8000", "--no-fit-sizes")
    found = json.loads((out / "result.json").read_text())
    assert status == 3
    assert "6 of 50 frames tracked, 40 bridged, 4 lost" in log
    assert [(part["first"], part["last"], part["status"]) for part in found["unusual"]] == [
        (6, 45, "bridged"), (46, 49, "lost")
    ]  # fmt: skip
    with h5py.File(out / "recording.nc") as file:
        assert np.all(np.isnan(file["raw"][46:]))


def hovering_before_pictures(folder, masks):
    """A dark fly that hovers (N, 3, rows, columns), filmed in grey, and the three pictures of its ground."""
    ground = [(200 - 10 * k + np.indices(mask.shape)[1] % 5).astype(np.uint8) for k, mask in enumerate(masks[0])]
    (folder / "empty").mkdir()
    for k, picture in enumerate(ground, start=1):
        Image.fromarray(picture).save(folder / "empty" / f"cam{k}.png")
    return saved(folder, np.where(masks, np.uint8(40), np.array(ground))), ground


def test_cameras_are_checked_before_a_background_that_cannot_be_made(tracked, masks, tmp_path):
    film, _ = hovering_before_pictures(tmp_path, masks[0])
    for options, words in (((), "stays in one place"), (("--unit", "m"), "These cameras see a field that is")):
        status, log, out = tracked(film, "--frame-rate", "8000", *options)
        assert (status, log.count("\n"), out.exists()) == (2, 1, False), log
        assert words in log


def test_a_picture_for_each_camera_is_a_background(masks, tmp_path):
    film, ground = hovering_before_pictures(tmp_path, masks[0])
    films = FilmOptions(
        inputs=(str(film),), cameras=film, frame_rate=8000.0, frames=None, up="z", unit="mm", camera_variable="P",
        first_pixel=None, rows_from_below=False, film_variable="masks", silhouettes=None,
        background=str(tmp_path / "empty"), bright=False, contrast=None, dust=0.02, wingbeats=10,
    )  # fmt: skip
    which = FlyOptions(
        file="drosophila_melanogaster", body_length=None, stroke_plane_angle=None, fit_sizes=None, hull_only=False
    )
    found = track_inputs(films, which).filmed.footage.backgrounds
    assert all(np.array_equal(one, picture) for one, picture in zip(found, ground, strict=True))
    with pytest.raises(InvalidInputError, match="one picture or film for each camera is needed"):
        track_inputs(replace(films, background=str(tmp_path / "empty" / "cam1.png")), which)


def test_films_that_cannot_be_tracked_are_refused_in_a_sentence_and_nothing_is_written(tracked, masks, tmp_path):
    film, rate = saved(tmp_path, masks[0]), ("--frame-rate", "8000")
    for options, words in (
        ((), "--frame-rate is missing"),
        (("--frame-rate", "8"), "8 frames a second"),
        (("--frame-rate", "nan"), "nan frames a second"),
        ((*rate, "--frames", "5:4"), "--frames is '5:4'"),
        ((*rate, "--frames", "0:12"), "the films have the frames 0 to 11"),
        ((*rate, "--unit", "m"), "m across"),
        ((*rate, "--unit", "px"), "--unit"),
        ((*rate, "--rows-from-below"), "needs --first-pixel"),
        ((*rate, "--camera-variable", "Q"), "Q"),
        ((*rate, "--cameras", "nowhere.csv"), "nowhere.csv"),
        ((*rate, "--contrast", "-3"), "--contrast"),
        ((*rate, "--up", "z up"), "--up must be one of"),
        ((*rate, "--contrast", "10"), "--contrast says how silhouettes are made from grey images"),
        ((*rate, "--bright"), "--bright says how"),
    ):
        status, log, out = tracked(film, *options)
        assert (status, log.count("\n"), out.exists()) == (2, 1, False), log
        assert words in log
    for frames, words in (
        (masks[0][:, :2], "3 cameras"),
        (np.zeros_like(masks[0]), "shows none in any of them"),
        (np.ones_like(masks[0]), "fills 100 % of the image"),
        (np.roll(masks[0], 40, axis=-1), "do not fit the images"),
    ):
        status, log, out = tracked(saved(tmp_path, frames), *rate, "--silhouettes")
        assert (status, log.count("\n"), out.exists()) == (2, 1, False), log
        assert words in log
