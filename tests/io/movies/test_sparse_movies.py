"""Sparse movies: what their fields mean, and what is refused of them."""

import film_files as written_as
import numpy as np
import pytest
from binary_files import write_matlab5, write_matlab73

from flycontrol.errors import InvalidInputError
from flycontrol.io.movies.open_films import open_films

BEHIND = np.full((24, 32), 200, dtype=np.uint16)
SPOT = np.array([[1, 1, 40], [24, 32, 41], [3, 5, 42]], dtype=np.uint16)
NOTHING = np.zeros((0, 0), dtype=np.uint16)
VERSIONS = pytest.mark.parametrize("version", ["5", "7.3"])


def meta(**fields):
    given = {"bg": BEHIND, "frameSize": np.array([[24, 32]]), "startFrame": 0, "frameRate": 20000.0} | fields
    return {name: value for name, value in given.items() if value is not None}


def movie(folder, tables, version, name="cam1_sparse.mat", **fields):
    return written_as.write_sparse(folder / name, tables, meta(**fields), version)


def refusal(paths):
    with pytest.raises(InvalidInputError) as caught:
        open_films(paths)
    return str(caught.value)


@VERSIONS
def test_rows_columns_and_values_are_counted_from_one(tmp_path, version):
    """Row before column: the corners of an image that is wider than high."""
    image = open_films([movie(tmp_path, [SPOT, SPOT], version)]).films[0].image(1)
    expected = BEHIND.copy()
    expected[0, 0], expected[23, 31], expected[2, 4] = 40, 41, 42
    assert np.array_equal(image, expected)


@VERSIONS
def test_a_frame_without_pixels_is_the_background(tmp_path, version):
    path = tmp_path / "cam1_sparse.mat"
    if version == "7.3":
        written_as.write_sparse(path, [SPOT, NOTHING, SPOT], meta(), version)
        _mark_empty(path)
    else:
        written_as.write_sparse(path, [SPOT, NOTHING, SPOT], meta(), version)
    assert np.array_equal(open_films([path]).films[0].image(1), BEHIND)


def _mark_empty(path):
    """Rewrite an empty dataset as MATLAB does: its shape as the numbers, with an attribute that says so."""
    import h5py

    with h5py.File(path, "r+") as file:
        (name,) = [name for name, item in file["#refs#"].items() if item.size == 0]
        group = file["#refs#"]
        del group[name]
        group.create_dataset(name, data=np.array([0, 0], dtype=np.uint64)).attrs["MATLAB_empty"] = np.uint8(1)
        group[name].attrs["MATLAB_class"] = np.bytes_("uint16")
        references = file["frames"]["indIm"][()]
        references[0, 1] = group[name].ref
        file["frames"]["indIm"][...] = references


@VERSIONS
def test_without_a_background_the_pixels_are_the_silhouette(tmp_path, version):
    camera = open_films([movie(tmp_path, [SPOT, SPOT[:, :2]], version, bg=None)]).films[0]
    assert camera.binary
    for k in (0, 1):
        assert np.array_equal(np.argwhere(camera.image(k)) + 1, SPOT[[0, 2, 1], :2])


@VERSIONS
def test_cameras_are_brought_together_by_their_start_frames(tmp_path, version):
    """Each frame's only pixel says its number: from -5 and from -3, ten and nine of them."""
    for camera, start, count in (("cam1", -5, 10), ("cam2", -3, 9)):
        tables = [np.array([[2, 2, 100 + start + k]], dtype=np.uint16) for k in range(count)]
        movie(tmp_path, tables, version, f"{camera}_sparse.mat", startFrame=start)
    opened = open_films([tmp_path])
    numbers = [[int(camera.image(k)[1, 1]) - 100 for k in range(len(camera))] for camera in opened.films]
    assert numbers == [list(range(-3, 5))] * 2
    assert "cut to the 8 frames that all have, from frame -3" in opened.notes[0]


@VERSIONS
def test_a_movie_of_one_frame_is_read(tmp_path, version):
    assert len(open_films([movie(tmp_path, [SPOT], version)]).films[0]) == 1


def test_many_frames_are_unpacked_in_several_goes(tmp_path):
    tables = [np.array([[k % 24 + 1, k // 24 + 1, k % 200]] * (1 + k % 3), dtype=np.uint16) for k in range(600)]
    camera = open_films([movie(tmp_path, tables, "5")]).films[0]
    for k in (599, 0, 250, 249):
        assert camera.image(k)[k % 24, k // 24] == k % 200


def test_images_that_were_mirrored_in_place_are_mentioned(tmp_path):
    (note,) = open_films([movie(tmp_path, [SPOT], "7.3", isFlipped=np.array([[1]], dtype=np.uint8))]).notes
    assert "mirrored in place" in note


@VERSIONS
@pytest.mark.parametrize(
    ("table", "sentence"),
    [
        ([[25, 1, 9]], "frame 1 (from 0): indIm names the pixel in row 25, column 1"),
        ([[0, 1, 9]], "names the pixel in row 0, column 1"),
        ([[1, 2, 3, 4]], "must have a row for each pixel, of its row, column and grey value; it is 1 x 4"),
        ([[1, 2]], "has no grey values in its third column"),
    ],
)
def test_pixels_that_cannot_be_cost_one_frame(tmp_path, version, table, sentence):
    tables = [SPOT, np.array(table, dtype=np.uint16), SPOT]
    camera = open_films([movie(tmp_path, tables, version)]).films[0]
    with pytest.raises(InvalidInputError) as caught:
        camera.image(1)
    assert sentence in str(caught.value)
    assert camera.image(2)[2, 4] == 42


@VERSIONS
@pytest.mark.parametrize(
    ("fields", "sentence"),
    [
        ({"bg": BEHIND[:5]}, "metaData.bg has 5 x 32 pixels and metaData.frameSize says 24 x 32"),
        ({"bg": None, "frameSize": None}, "has neither frameSize nor bg"),
        ({"bg": None, "frameSize": np.array([[24.5, 32]])}, "frameSize must be rows and columns"),
        ({"bg": None, "frameSize": np.array([[1e6, 1e6]])}, "1000000 x 1000000 pixels are more than"),
        ({"frameRate": 0.0}, "frameRate must be one number > 0"),
        ({"startFrame": 0.5}, "startFrame must be one whole number"),
    ],
)
def test_what_is_said_of_all_frames_must_be_possible(tmp_path, version, fields, sentence):
    path = movie(tmp_path, [SPOT, SPOT], version, **fields)
    assert sentence in (said := refusal([path]))
    assert said.startswith(str(path))


def test_other_matlab_files_are_no_movies(tmp_path):
    calibration = write_matlab5(tmp_path / "wand.mat", {"easyWandData": {"coefs": np.zeros((11, 3))}})
    other = write_matlab73(tmp_path / "other.mat", {"frames": [{"image": SPOT}, {"image": SPOT}]})
    assert "has no group or structure 'frames'; there are the variables easyWandData" in refusal([calibration])
    assert "has neither frameSize nor bg" in refusal([other])


def test_frames_without_pixels_fields_are_refused(tmp_path):
    frames = [{"image": SPOT}, {"image": SPOT}]
    path = write_matlab73(tmp_path / "cam1_sparse.mat", {"frames": frames, "metaData": meta()})
    assert "frame 0 (from 0) has no indIm" in refusal([path])


def test_movies_without_a_common_frame_are_refused(tmp_path):
    for camera, start in (("cam1", 0), ("cam2", 2)):
        movie(tmp_path, [SPOT, SPOT], "7.3", f"{camera}_sparse.mat", startFrame=start)
    assert "cam1_sparse 0 to 1, cam2_sparse 2 to 3" in refusal([tmp_path])
