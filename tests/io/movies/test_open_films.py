import gc

import film_files as written_as
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from flycontrol.errors import InvalidInputError
from flycontrol.io.movies.open_films import open_films

GREY = {
    "png": lambda to, film: written_as.write_stills(to, film, ".png"),
    "bmp": lambda to, film: written_as.write_stills(to, film, ".bmp"),
    "tif": lambda to, film: written_as.write_stills(to, film, ".tif"),
    "png in one folder": written_as.write_flat,
    "png, frame first": lambda to, film: written_as.write_flat(to, film, "P{k}CAM{c}.png"),
    "pages": written_as.write_pages,
    "pages, packed": lambda to, film: written_as.write_pages(to, film, compression="tiff_lzw"),
    "npy": written_as.write_npy,
    "npy by camera": written_as.write_npy_cameras,
    "npz": written_as.write_npz,
    "npz by camera": written_as.write_npz_cameras,
}
MASKS = GREY | {
    "packed": written_as.write_packed,
    "packed as a whole": written_as.write_packed_whole,
    "packed npy": written_as.write_packed_npy,
}


def every_image(opened):
    """(N, C, rows, columns), read backwards."""
    last = len(opened.films[0]) - 1
    backwards = [[camera.image(k) for camera in opened.films] for k in range(last, -1, -1)]
    return np.array(backwards[::-1])


@pytest.mark.parametrize("form", GREY)
def test_grey_frames_come_back_through_every_format(tmp_path, film, form):
    opened = open_films(GREY[form](tmp_path / "film", film))
    images = every_image(opened)
    assert images.dtype == np.uint8
    assert np.array_equal(images, film)
    assert all(camera.shape == film.shape[2:] and not camera.binary for camera in opened.films)
    assert opened.frame_rate is None


@pytest.mark.parametrize("form", MASKS)
def test_silhouettes_come_back_boolean_through_every_format(tmp_path, masks, form):
    opened = open_films(MASKS[form](tmp_path / "film", masks))
    images = every_image(opened)
    assert images.dtype == np.bool_
    assert np.array_equal(images, masks)
    assert all(camera.binary for camera in opened.films)


@pytest.mark.parametrize("version", ["5", "7.3"])
def test_sparse_movies_are_the_background_with_their_pixels_set(tmp_path, film, background, version):
    opened = open_films(written_as.write_sparse_film(tmp_path / "film", film, background, version))
    assert np.array_equal(every_image(opened), film)
    assert opened.frame_rate == 20000.0
    assert all(np.array_equal(behind, background) for behind in opened.backgrounds)


@pytest.mark.parametrize("form", ["png", "pages", "npy", "npz"])
def test_frames_of_16_bit_keep_all_of_them(tmp_path, film, form):
    deep = film.astype(np.uint16) * 257
    images = every_image(open_films(GREY[form](tmp_path / "film", deep)))
    assert images.dtype == np.uint16
    assert np.array_equal(images, deep)


def test_colours_turn_to_their_luminance(tmp_path, film):
    """Equal red, green and blue are the grey that they are; ITU-R 601 weighs others by 0.299, 0.587, 0.114."""
    equal = np.repeat(film[..., None], 3, axis=-1)
    assert np.array_equal(every_image(open_films(written_as.write_stills(tmp_path / "equal", equal, ".png"))), film)
    green = equal * np.array([0, 1, 0], dtype=np.uint8)
    seen = every_image(open_films(written_as.write_stills(tmp_path / "green", green, ".png")))
    assert np.max(np.abs(seen - 0.587 * film)) <= 0.5 + 0.001 * 255


def test_jpeg_frames_come_back_to_within_its_loss(tmp_path, film):
    smooth = np.broadcast_to(np.linspace(60, 200, film.shape[-1]), film.shape).astype(np.uint8)
    images = every_image(open_films(written_as.write_stills(tmp_path / "film", smooth, ".jpg")))
    assert np.max(np.abs(images.astype(int) - smooth)) <= 8


def test_a_dark_animal_on_white_is_the_same_silhouette(tmp_path, masks):
    """The animal is the smaller part; and it is said that this was decided."""
    opened = open_films(written_as.write_stills(tmp_path / "film", np.where(masks, 0, 255).astype(np.uint8), ".png"))
    assert np.array_equal(every_image(opened), masks)
    assert len(opened.notes) == masks.shape[1]


def test_boolean_arrays_are_true_where_the_animal_is_however_large_it_is(tmp_path, masks):
    opened = open_films(written_as.write_npy(tmp_path / "film", ~masks))
    assert np.array_equal(every_image(opened), ~masks)
    assert not opened.notes


def test_being_silhouettes_can_be_said_and_denied(tmp_path, film, masks):
    grey = open_films(written_as.write_npy(tmp_path / "masks", masks), binary=False)
    assert np.array_equal(every_image(grey), np.where(masks, 255, 0))
    split = open_films(written_as.write_npy(tmp_path / "film", film), binary=True)
    assert np.array_equal(every_image(split), masks)  # halfway between 20 and 200, and the darker part is the smaller


def test_a_frame_with_more_values_than_the_others_is_refused_and_the_rest_is_read(tmp_path, masks):
    """It cannot be known at the beginning: only some frames are looked at then."""
    images = np.where(masks, 255, 0).astype(np.uint8)
    images = np.tile(images, (10, 1, 1, 1))
    images[1, 1, 5, 5] = 77
    first = open_films(written_as.write_npy(tmp_path / "film", images)).films[1]
    assert first.binary
    with pytest.raises(InvalidInputError, match=r"film\.npy, camera 2, frame 1 .* has the value 77"):
        first.image(1)
    assert np.array_equal(first.image(2), masks[2, 1])


@given(order=st.permutations(range(12)))
def test_frames_may_be_asked_for_in_any_order(tmp_path_factory, film, order):
    opened = _pages(tmp_path_factory, film)
    assert all(np.array_equal(opened.films[0].image(k), film[k, 0]) for k in order)


_OPENED = []


def _pages(tmp_path_factory, film):
    if not _OPENED:
        folder = tmp_path_factory.mktemp("pages") / "film"
        _OPENED.append(open_films(written_as.write_pages(folder, film, compression="tiff_deflate")))
    return _OPENED[0]


@pytest.mark.parametrize("k", [-1, 12])
def test_frames_beyond_the_film_are_refused(tmp_path, film, k):
    camera = open_films(written_as.write_npy(tmp_path / "film", film)).films[0]
    with pytest.raises(InvalidInputError, match=f"the frames 0 to 11, so there is no frame {k}"):
        camera.image(k)


def test_files_are_closed_with_the_films(tmp_path, film):
    """A file left open warns when it is collected, and warnings are errors here."""
    opened = open_films(written_as.write_pages(tmp_path / "film", film))
    opened.films[0].image(3)
    del opened
    gc.collect()


def test_the_real_silhouettes_are_those_that_their_description_unpacks(real_data):
    path = real_data / "silhouettes" / "exp095_first47.npz"
    if not path.is_file():
        pytest.skip(f"{path.name} is not there")
    opened = open_films([path])
    packed = np.load(path)["masks_packed"]
    assert np.array_equal(every_image(opened), np.unpackbits(packed, axis=-1).reshape(47, 3, 512, 512))
    assert opened.frame_rate == 6000.0
