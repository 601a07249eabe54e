"""What paths mean: which files belong to which camera."""

import film_files as written_as
import numpy as np
import pytest
from PIL import Image

from flycontrol.errors import InvalidInputError
from flycontrol.io.movies.inputs import camera_files
from flycontrol.io.movies.natural_order import gap
from flycontrol.io.movies.open_films import open_films


def touched(folder, *names):
    folder.mkdir(exist_ok=True, parents=True)
    for name in names:
        (folder / name).write_bytes(b"")
    return folder


def refusal(inputs, **options):
    with pytest.raises(InvalidInputError) as caught:
        open_films(inputs, **options)
    sentence = str(caught.value)
    assert sentence.endswith(".")
    assert "\n" not in sentence
    return sentence


def test_a_folder_a_pattern_and_a_file_for_each_camera_are_the_same_film(tmp_path, film):
    (folder,) = written_as.write_stills(tmp_path / "film", film, ".png")
    (arrays,) = written_as.write_npy_cameras(tmp_path / "arrays", film)
    inputs = [
        [folder],
        [folder / f"cam{c}" for c in (1, 2, 3)],
        [f"{folder}/cam{c}/frame*.png" for c in (1, 2, 3)],
        [f"{folder}/cam*/*.png"],
        sorted(folder.rglob("*.png")),  # a pattern that the shell has expanded
        [arrays / f"cam{c}.npy" for c in (1, 2, 3)],
        [f"{arrays}/cam?.npy"],
        [folder / "cam1", arrays / "cam2.npy", f"{folder}/cam3/*"],
    ]
    for given in inputs:
        opened = open_films(given)
        assert [np.array_equal(camera.image(11), film[11, c]) for c, camera in enumerate(opened.films)] == [True] * 3


def test_cameras_are_in_the_order_in_which_they_are_named(tmp_path, film):
    (folder,) = written_as.write_npy_cameras(tmp_path / "film", film)
    opened = open_films([folder / "cam3.npy", folder / "cam1.npy"])
    assert [camera.name for camera in opened.films] == ["cam3", "cam1"]


def test_cameras_whose_files_bear_one_name_are_counted(tmp_path, film):
    inputs = [written_as.write_npy(tmp_path / str(c), film[:, c : c + 1])[0] for c in range(2)]
    assert [camera.name for camera in open_films(inputs).films] == ["camera 1 (1)", "camera 1 (2)"]


def test_folders_and_frames_are_ordered_by_their_numbers(tmp_path):
    for c in (10, 2):
        touched(tmp_path / f"cam{c}", *(f"img_{k}.bmp" for k in (10, 9, 11)))
    cameras = camera_files([tmp_path])
    assert [camera.name for camera in cameras] == ["cam2", "cam10"]


def test_stills_of_several_cameras_in_one_folder_are_told_by_their_names(tmp_path):
    by_number = touched(tmp_path / "a", *(f"fly3_cam{c}_{k:04d}.png" for c in (1, 2) for k in range(5)))
    by_word = touched(tmp_path / "b", *(f"{side}{k}.png" for side in ("top", "left") for k in range(5)))
    frame_first = touched(tmp_path / "c", *(f"P{k}CAM{c}.jpg" for c in (1, 2, 3) for k in range(9)))
    by_clock = touched(tmp_path / "d", *(f"20210101_12000{k // 4}_{k}.png" for k in range(12)))
    assert [camera.name for camera in camera_files([by_number])] == ["cam1", "cam2"]
    assert [camera.name for camera in camera_files([by_clock])] == ["d"]
    assert [camera.name for camera in camera_files([by_word])] == ["left", "top"]
    assert [camera.name for camera in camera_files([frame_first])] == ["CAM1", "CAM2", "CAM3"]
    assert all(len(camera.files) == 9 for camera in camera_files([frame_first]))


def test_of_matlab_files_in_a_folder_only_those_named_sparse_are_films(tmp_path):
    folder = touched(tmp_path / "mov1", "mov1_cam1_sparse.mat", "mov1_cam2_sparse.mat", "wand_easyWandData.mat")
    assert [camera.name for camera in camera_files([folder])] == ["mov1_cam1_sparse", "mov1_cam2_sparse"]


def test_a_missing_still_is_named_by_its_neighbours(tmp_path, film):
    (folder,) = written_as.write_stills(tmp_path / "film", film, ".png", first=36)
    (folder / "cam2" / "frame42.png").unlink()
    assert "Camera cam2: a still is missing" in (sentence := refusal([folder]))
    assert "41 is followed by 43" in sentence


@pytest.mark.parametrize(
    ("names", "found"),
    [
        (("a1", "a2", "a4"), (2, 4)),
        (("a10", "a20", "a30"), None),  # every tenth frame
        (("a10", "a20", "a40"), (20, 40)),
        (("d1_t5_1", "d1_t5_2", "d1_t7_3"), None),  # the counter counts, the time does as it likes
        (("a1", "a9"), None),
    ],
)
def test_a_gap_is_where_a_counter_jumps(tmp_path, names, found):
    assert gap([tmp_path / f"{name}.png" for name in names]) == found


def test_stills_that_begin_with_different_numbers_are_mentioned(tmp_path, film):
    (folder,) = written_as.write_stills(tmp_path / "film", film[:, :1], ".png", first=7)
    (other,) = written_as.write_stills(tmp_path / "other", film[:, 1:2], ".png", first=8)
    (note,) = open_films([folder / "cam1", other / "cam1"]).notes
    assert "with 7" in note
    assert "with 8" in note


def test_cameras_of_unequal_length_are_refused(tmp_path, film):
    (folder,) = written_as.write_stills(tmp_path / "film", film, ".png")
    (folder / "cam3" / "frame11.png").unlink()
    assert "cam1 has 12, cam2 has 12, cam3 has 11" in refusal([folder])


def test_images_of_unequal_size_within_a_camera_are_refused(tmp_path, film):
    (folder,) = written_as.write_stills(tmp_path / "film", film, ".png")
    Image.new("L", (9, 7)).save(folder / "cam2" / "frame0.png")
    assert "Camera cam2: frames of one camera must have equally many pixels" in (sentence := refusal([folder]))
    assert "frame0.png has 7 x 9" in sentence
    assert "frame1.png has 24 x 32" in sentence


def test_a_picture_that_is_not_numbered_like_the_others_is_refused(tmp_path, film):
    (folder,) = written_as.write_stills(tmp_path / "film", film, ".png")
    Image.new("L", (32, 24)).save(folder / "cam2" / "background.png")
    assert "background.png: the stills of camera cam2 are numbered as frame0.png is" in refusal([folder])


def test_a_still_that_is_there_twice_is_refused(tmp_path, film):
    (folder,) = written_as.write_stills(tmp_path / "film", film, ".png")
    second = folder / "cam2" / "frame03.png"
    second.write_bytes((folder / "cam2" / "frame3.png").read_bytes())
    assert "frame03.png and frame3.png" in (sentence := refusal([folder])) or "frame3.png and frame03.png" in sentence
    second.rename(folder / "cam2" / "frame3.tif")
    assert "frame3.tif: the stills of camera cam2 are numbered as frame0.png is" in refusal([folder])


def test_what_is_no_film_is_refused_with_what_is_read(tmp_path):
    text = tmp_path / "notes.txt"
    text.write_text("hello")
    empty = touched(tmp_path / "empty")
    no_images = touched(tmp_path / "papers", "a.pdf", ".hidden.png")
    nested = touched(tmp_path / "nested" / "cam1")
    touched(tmp_path / "nested" / "cam2", "a1.png")
    assert "notes.txt: films are stills (.png" in refusal([text])
    assert "empty holds no images and no films" in refusal([empty])
    assert "papers holds no images and no films" in refusal([no_images])
    assert "cam1 holds no images" in refusal([nested, empty])
    assert "there is no such file or folder" in refusal([tmp_path / "nothing"])
    assert "No image and no film matches" in refusal([tmp_path / "nothing*.png"])
    assert "No film is named" in refusal([])
    assert "named twice" in refusal([text.parent / "nested" / "cam2"] * 2)


def test_names_that_do_not_tell_the_cameras_apart_are_refused(tmp_path):
    folder = touched(tmp_path / "film", *(f"{chr(97 + k)}.png" for k in range(20)))
    assert "do not tell which belong to one camera" in refusal([folder])


@pytest.mark.parametrize(
    ("array", "sentence"),
    [
        (np.zeros((24, 32)), "has the shape 24 x 32; films are (frames, rows, columns)"),
        (np.zeros((2, 3, 4, 5, 6)), "has the shape 2 x 3 x 4 x 5 x 6"),
        (np.zeros((5, 24, 32, 3)), "looks like coloured images of one camera"),
        (np.zeros((3, 40, 24, 32)), "its second axis counts the cameras, at most 16"),
        (np.zeros((0, 3, 24, 32)), "holds no frames"),
        (np.zeros((2, 3, 0, 32)), "an image of 0 x 32 pixels is empty"),
        (np.zeros((2, 3, 24, 32), dtype=complex), "holds complex128"),
        (np.zeros((2, 3, 24, 32), dtype="U3"), "images are of booleans or real numbers"),
    ],
)
def test_arrays_that_are_no_films_are_refused(tmp_path, array, sentence):
    np.save(tmp_path / "film.npy", array)
    assert sentence in (said := refusal([tmp_path / "film.npy"]))
    assert said.startswith(str(tmp_path / "film.npy"))


def test_pickled_objects_are_refused_unopened(tmp_path):
    class Trap:
        def __reduce__(self):
            return (pytest.fail, ("a pickle was opened",))

    trap = np.array([Trap()], dtype=object)
    np.save(tmp_path / "film.npy", trap, allow_pickle=True)
    np.savez(tmp_path / "film.npz", film=trap, allow_pickle=True)
    assert "holds pickled objects" in refusal([tmp_path / "film.npy"])
    assert "has no film" in refusal([tmp_path / "film.npz"])
    assert "holds pickled objects" in refusal([tmp_path / "film.npz"], variable="film")


def test_of_several_arrays_that_could_be_the_film_one_must_be_named(tmp_path, film, masks):
    path = tmp_path / "both.npz"
    np.savez(path, film=film, masks=masks)
    assert "film, masks could be the film; name one" in refusal([path])
    assert open_films([path], variable="masks").films[0].binary
    assert "has no variable 'mask'; it has film, masks" in refusal([path], variable="mask")


def test_packing_can_be_said_and_denied(tmp_path, masks):
    np.save(tmp_path / "bits.npy", np.packbits(masks, axis=-1))
    said = open_films([tmp_path / "bits.npy"], packed=True)
    assert np.array_equal(said.films[2].image(5), masks[5, 2])
    assert open_films([tmp_path / "bits.npy"]).films[0].shape == (24, 4)
    np.save(tmp_path / "packed.npy", masks)
    assert "packed masks are uint8" in refusal([tmp_path / "packed.npy"])
    assert np.array_equal(open_films([tmp_path / "packed.npy"], packed=False).films[1].image(7), masks[7, 1])


def test_frame_rates_that_disagree_are_refused(tmp_path, masks):
    for name, rate in (("a", 8000.0), ("b", 7500.0)):
        np.savez(tmp_path / f"{name}.npz", cam=masks[:, 0], fps=rate)
    assert "a" in (sentence := refusal([tmp_path / "a.npz", tmp_path / "b.npz"]))
    assert "8000" in sentence
    assert "7500" in sentence
