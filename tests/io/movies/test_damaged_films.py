"""A damaged frame costs that frame; a damaged file ends in one sentence that names it."""

import random
from contextlib import suppress

import film_files as written_as
import numpy as np
import pytest
from PIL import Image

from flycontrol.errors import InvalidInputError
from flycontrol.io.movies.open_films import open_films

FORMS = {
    "png": lambda to, film, _: written_as.write_stills(to, film, ".png"),
    "tif": lambda to, film, _: written_as.write_stills(to, film, ".tif"),
    "jpg": lambda to, film, _: written_as.write_stills(to, film, ".jpg"),
    "bmp": lambda to, film, _: written_as.write_stills(to, film, ".bmp"),
    "pages": lambda to, film, _: written_as.write_pages(to, film),
    "npy": lambda to, film, _: written_as.write_npy(to, film),
    "npz": lambda to, film, _: written_as.write_npz(to, film),
    "sparse 5": lambda to, film, behind: written_as.write_sparse_film(to, film, behind, "5"),
    "sparse 7.3": lambda to, film, behind: written_as.write_sparse_film(to, film, behind, "7.3"),
}
ROUNDS = {"sparse 5": 12, "sparse 7.3": 12}


@pytest.mark.parametrize("ending", [".png", ".tif", ".bmp", ".jpg"])
def test_a_truncated_still_costs_one_frame(tmp_path, film, ending):
    (folder,) = written_as.write_stills(tmp_path / "film", film, ending)
    broken = folder / "cam2" / f"frame5{ending}"
    data = broken.read_bytes()
    broken.write_bytes(data[: 2 * len(data) // 3])
    camera = open_films([folder]).films[1]
    for k in range(12):
        if k == 5:
            with pytest.raises(InvalidInputError, match=f"frame5{ending} cannot be read"):
                camera.image(k)
        else:
            assert camera.image(k).shape == (24, 32)


def test_a_damaged_still_is_named_by_its_camera_and_not_by_the_machines_folders(tmp_path, film):
    (folder,) = written_as.write_stills(tmp_path / "film", film, ".png")
    (folder / "cam2" / "frame5.png").write_bytes(b"")
    camera = open_films([folder]).films[1]
    with pytest.raises(InvalidInputError, match=r"^cam2/frame5\.png is empty\.$"):
        [camera.image(k) for k in range(12)]


def test_a_page_whose_data_are_damaged_costs_one_frame(tmp_path, film):
    (folder,) = written_as.write_pages(tmp_path / "film", film[:, :1], compression="tiff_adobe_deflate")
    path = folder / "cam1.tif"
    with Image.open(path) as pages:
        pages.seek(7)
        start, length = pages.tag_v2[273][0], pages.tag_v2[279][0]
    data = bytearray(path.read_bytes())
    data[start : start + length] = bytes(length)
    path.write_bytes(data)
    camera = open_films([folder]).films[0]
    for k in (6, 7, 8, 7, 0):
        if k == 7:
            with pytest.raises(InvalidInputError, match=r"cam1\.tif, frame 7 \(from 0\) cannot be read"):
                camera.image(k)
        else:
            assert np.array_equal(camera.image(k), film[k, 0])


def test_a_still_of_another_size_costs_one_frame(tmp_path, film):
    long = np.tile(film, (3, 1, 1, 1))
    (folder,) = written_as.write_stills(tmp_path / "film", long, ".png")
    Image.new("L", (9, 7)).save(folder / "cam1" / "frame1.png")
    camera = open_films([folder]).films[0]
    with pytest.raises(
        InvalidInputError, match=r"frame1\.png has 7 x 9 pixels, other frames of camera cam1 have 24 x 32"
    ):
        camera.image(1)
    assert np.array_equal(camera.image(2), film[2, 0])


def test_a_film_without_a_frame_that_can_be_read_is_refused(tmp_path):
    (tmp_path / "cam1").mkdir()
    for k in range(4):
        (tmp_path / "cam1" / f"{k}.png").write_bytes(b"")
    with pytest.raises(InvalidInputError, match=r"0\.png is empty"):
        open_films([tmp_path])


@pytest.mark.parametrize("name", ["film.npy", "film.npz", "film.mat", "film.tif", "film.png"])
def test_a_file_that_is_not_what_its_name_says_is_refused(tmp_path, name):
    path = tmp_path / name
    path.write_bytes(b"\xff\xd8\xff\xe0 no more than a beginning of a photograph" * 9)
    with pytest.raises(InvalidInputError) as caught:
        open_films([path])
    assert str(path) in str(caught.value)


def test_images_of_more_pixels_than_any_camera_has_are_refused_before_they_are_decoded(tmp_path):
    (tmp_path / "cam1").mkdir()
    Image.new("1", (9_000, 9_000)).save(tmp_path / "cam1" / "frame1.png")
    with pytest.raises(InvalidInputError, match="9000 x 9000 pixels are more than an image may have"):
        open_films([tmp_path])


def test_arrays_that_declare_more_than_there_is_are_refused(tmp_path):
    head = np.lib.format
    with (tmp_path / "film.npy").open("wb") as file:
        head.write_array_header_1_0(file, {"descr": "|u1", "fortran_order": False, "shape": (10**9, 3, 500, 500)})
    with pytest.raises(InvalidInputError, match="is cut off: 0 bytes instead of"):
        open_films([tmp_path / "film.npy"])


@pytest.mark.parametrize("form", FORMS)
def test_flipped_and_missing_bytes_end_in_a_sentence_or_in_frames(tmp_path, film, background, form):
    inputs = FORMS[form](tmp_path / "film", film[:, :1], background)
    files = [file for file in written_as.files_of(inputs) if "wand" not in file.name]
    draw = random.Random(form)
    for attempt in range(ROUNDS.get(form, 60)):
        file = draw.choice(files)
        whole = file.read_bytes()
        file.write_bytes(_damaged(whole, draw, cut=attempt % 4 == 0))
        _read_all(inputs)
        file.write_bytes(whole)
    opened = open_films(inputs)
    assert len(opened.films[0]) == 12


def _damaged(whole, draw, *, cut):
    if cut:
        return whole[: draw.randrange(len(whole))]
    data = bytearray(whole)
    reach = draw.choice([64, 300, len(data)])  # headers are where it hurts
    for _ in range(draw.choice([1, 1, 2, 8])):
        data[draw.randrange(min(len(data), reach))] = draw.choice([0, 255, draw.randrange(256)])
    return bytes(data)


def _read_all(inputs):
    """Any other error than InvalidInputError, and any warning, fails the test."""
    with suppress(InvalidInputError):
        (camera,) = open_films(inputs).films
        for k in range(len(camera)):
            with suppress(InvalidInputError):
                assert camera.image(k).shape == camera.shape
