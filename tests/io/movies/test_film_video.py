"""Video is read in order, frame k being frame k, where the libraries are installed; else they are named."""

import importlib.util

import numpy as np
import pytest

from flycontrol.errors import InvalidInputError
from flycontrol.io.movies import video
from flycontrol.io.movies.open_films import open_films

INSTALLED = importlib.util.find_spec("imageio") is not None and importlib.util.find_spec("av") is not None
needs_video = pytest.mark.skipif(
    not INSTALLED, reason="imageio and av are not installed: pip install 'flycontrol[video]'"
)


@pytest.fixture
def long_film():
    """(40, 64, 96): a bright block that moves by a pixel a frame, over more than one group of pictures."""
    film = np.tile(np.linspace(40, 80, 96).astype(np.uint8), (40, 64, 1))
    for k in range(40):
        film[k, 10:30, k : k + 20] = 200
    return film


def written(path, film, codec, rate=30):
    import imageio.v3 as imageio

    pixels = "gray" if codec == "ffv1" else "yuv420p"
    imageio.imwrite(path, film, plugin="pyav", codec=codec, fps=rate, in_pixel_format="gray", out_pixel_format=pixels)
    return path


@needs_video
@pytest.mark.parametrize("ending", [".avi", ".mkv"])
def test_frames_of_a_lossless_video_come_back_in_any_order(tmp_path, long_film, ending):
    camera = open_films([written(tmp_path / f"cam1{ending}", long_film, "ffv1")]).films[0]
    assert len(camera) == 40
    for k in (39, 0, 20, 19, 38, 3, 3, 12, 2):
        assert np.array_equal(camera.image(k), long_film[k])


@needs_video
def test_frames_of_a_lossy_video_are_the_right_ones(tmp_path, long_film):
    """The block's edge moves by a pixel a frame: a frame is nearer to its own original than to its neighbours'."""
    camera = open_films([written(tmp_path / "cam1.mp4", long_film, "libx264")]).films[0]
    for k in (30, 4, 17, 16, 39):
        distance = np.abs(long_film.astype(int) - camera.image(k)).sum(axis=(1, 2))
        assert np.argmin(distance) == k


@needs_video
def test_the_rate_of_showing_is_not_taken_for_that_of_filming(tmp_path, long_film):
    shown = open_films([written(tmp_path / "shown.mkv", long_film, "ffv1")])
    assert shown.frame_rate is None
    assert "30 frames/s are those of showing it" in shown.notes[0]
    filmed = open_films([written(tmp_path / "filmed.mp4", long_film, "libx264", rate=8000)])
    assert filmed.frame_rate == pytest.approx(8000, rel=1e-3)
    coarse = open_films([written(tmp_path / "coarse.mkv", long_film, "ffv1", rate=8000)])
    assert coarse.frame_rate is None  # its clock counts milliseconds, and it says 1000


@needs_video
def test_a_video_that_is_cut_off_is_mentioned_or_refused(tmp_path, long_film):
    whole = written(tmp_path / "cam1.avi", long_film, "ffv1").read_bytes()
    cut = tmp_path / "cut.avi"
    cut.write_bytes(whole[: 3 * len(whole) // 4])
    opened = open_films([cut])
    assert len(opened.films[0]) < 36
    assert "cut.avi may be cut off: it says about" in opened.notes[1]
    with pytest.raises(InvalidInputError, match="must have equally many frames"):
        open_films([tmp_path / "cam1.avi", cut])


@needs_video
def test_what_is_no_video_is_refused(tmp_path):
    (tmp_path / "cam1.avi").write_bytes(b"no video" * 99)
    with pytest.raises(InvalidInputError, match=r"cam1\.avi cannot be read"):
        open_films([tmp_path / "cam1.avi"])


def test_without_the_libraries_it_is_said_how_to_install_them(tmp_path, monkeypatch):
    monkeypatch.setattr(video, "find_spec", lambda name: None)
    (tmp_path / "cam1.mp4").write_bytes(b"\0")
    with pytest.raises(InvalidInputError, match=r"needs imageio and av: run pip install 'flycontrol\[video\]'"):
        open_films([tmp_path / "cam1.mp4"])
