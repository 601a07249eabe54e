import numpy as np
import pytest
import scipy.io

from flycontrol.errors import InvalidInputError
from flycontrol.io.anipose import anipose_text, without_skew
from flycontrol.io.cameras import read_cameras
from flycontrol.model.camera import Camera
from flycontrol.model.camera_forms import (
    MATLAB_PIXELS,
    PixelConvention,
    camera_from_pinhole,
    dlt_coefficients,
    looking_at,
    orthogonal_cameras,
    pinhole_of,
)
from flycontrol.units import mm

SHAPE = (480, 640)
VIEWS = [
    looking_at((1 * mm, 0, 0), np.array(place) * mm, focal=3500, shape=SHAPE, name=f"camera {k + 1}")
    for k, place in enumerate([(100, 5, 8), (-4, 110, 3), (2, 6, 120)])
]
POINTS = np.random.default_rng(1).uniform(-3 * mm, 3 * mm, (30, 3))


def assert_same_views(cameras, views=VIEWS, tolerance=1e-6):
    assert len(cameras) == len(views)
    for camera, view in zip(cameras, views, strict=True):
        np.testing.assert_allclose(camera.project(POINTS), view.project(POINTS), rtol=0, atol=tolerance)
        assert np.all(camera.depth(POINTS) > 0)


def dlt_table(**kwargs):
    return np.stack([dlt_coefficients(view, **kwargs) for view in VIEWS], axis=1)


def test_dlt_coefficients_as_dltdv_writes_them_are_read(tmp_path):
    np.savetxt(tmp_path / "cal_DLTcoefs.csv", dlt_table(), delimiter=",", fmt="%.17g")
    assert_same_views(read_cameras(tmp_path / "cal_DLTcoefs.csv", SHAPE))
    assert [camera.name for camera in read_cameras(tmp_path / "cal_DLTcoefs.csv", SHAPE)] == [v.name for v in VIEWS]


def test_units_and_ways_of_counting_pixels_are_taken_as_told(tmp_path):
    below = PixelConvention(first=1.0, from_below=True)
    np.savetxt(tmp_path / "m.csv", dlt_table(unit=1.0, pixels=below), delimiter=",", fmt="%.17g")
    assert_same_views(read_cameras(tmp_path / "m.csv", [SHAPE] * 3, unit=1.0, pixels=below))


def test_easywand_data_is_read(tmp_path):
    focal = np.array([[3500.0] * 3])
    scipy.io.savemat(
        tmp_path / "easyWandData.mat", {"easyWandData": {"coefs": dlt_table(), "focalLengths": focal, "dlm": "x"}}
    )
    assert_same_views(read_cameras(tmp_path / "easyWandData.mat", SHAPE))


def test_matrices_of_any_scale_and_sign_are_read_and_face_the_scene(tmp_path):
    matrices = (
        np.stack([view.matrix * np.array([mm, mm, mm, 1]) for view in VIEWS]) * np.array([-7, 2, -1])[:, None, None]
    )
    np.save(tmp_path / "p.npy", matrices)
    np.savez(tmp_path / "p.npz", north=matrices[0], east=matrices[1], up=matrices[2], error=np.zeros(5))
    np.savetxt(tmp_path / "p.csv", matrices.reshape(-1, 4), delimiter=",", fmt="%.17g")
    np.savetxt(tmp_path / "p.txt", matrices.reshape(-1, 4), fmt="%.17g")
    for name in ("p.npy", "p.npz", "p.csv", "p.txt"):
        assert_same_views(read_cameras(tmp_path / name, SHAPE))
    np.savez(tmp_path / "both.npz", P=matrices, DLT=dlt_table())
    with pytest.raises(InvalidInputError, match="P, DLT could be cameras; name one"):
        read_cameras(tmp_path / "both.npz", SHAPE)
    assert_same_views(read_cameras(tmp_path / "both.npz", SHAPE, variable="DLT"))
    one_based = [np.linalg.inv(MATLAB_PIXELS.to_ours(SHAPE)) @ matrix for matrix in matrices]
    np.save(tmp_path / "p1.npy", one_based)
    assert_same_views(read_cameras(tmp_path / "p1.npy", SHAPE, pixels=MATLAB_PIXELS))


def test_anipose_files_come_back_as_they_went_out_lens_included(tmp_path):
    lenses = [
        camera_from_pinhole(pinhole_of(view), SHAPE, radial=(0.1, -0.2, 0.05), tangential=(1e-3, -2e-3), name=view.name)
        for view in VIEWS
    ]
    for views in (VIEWS, lenses):
        (tmp_path / "calibration.toml").write_text(anipose_text(views))
        again = read_cameras(tmp_path / "calibration.toml")
        assert_same_views(again, views)
        assert [camera.shape for camera in again] == [SHAPE] * 3
    assert "size = [640, 480]" in anipose_text(VIEWS)  # OpenCV's order: width first
    with pytest.raises(InvalidInputError, match="camera 1 was calibrated with images of 480 x 640"):
        read_cameras(tmp_path / "calibration.toml", (512, 512))


def test_what_anipose_cannot_hold_is_refused_with_the_way_out():
    skewed = Camera(matrix=np.array([[1, 0.002, 0], [0, 1, 0], [0, 0, 1.0]]) @ VIEWS[0].matrix, shape=SHAPE, name="cam")
    with pytest.raises(InvalidInputError, match=r"skew of 7 px, 0.48 px at the border"):
        anipose_text([skewed])
    straight = without_skew(skewed, POINTS)
    anipose_text([straight])
    loss = np.linalg.norm(straight.project(POINTS) - skewed.project(POINTS), axis=1)
    # a shear of 0.002 over 100 px is a rotation of 0.001 and 0.1 px of what no rotation mends
    assert loss.max() < 0.15
    with pytest.raises(InvalidInputError, match="orthographic"):
        anipose_text(orthogonal_cameras(scale=35 / mm, shape=SHAPE))
    with pytest.raises(InvalidInputError, match="mirrored"):
        anipose_text([Camera(matrix=np.diag([1.0, -1, 1]) @ VIEWS[0].matrix, shape=SHAPE)])


def test_taking_out_no_skew_changes_nothing():
    np.testing.assert_allclose(without_skew(VIEWS[1], POINTS).project(POINTS), VIEWS[1].project(POINTS), atol=1e-6)


@pytest.mark.parametrize(
    ("name", "text", "sentence"),
    [
        ("a.csv", "1,2,3\n4,5,6\n", r"11 rows of DLT coefficients .* got 2 x 3 numbers"),
        ("a.csv", "\n".join(["1,1"] * 11), "singular"),
        ("a.csv", "\n".join(["1,nan"] * 11), "not a finite number"),
        ("a.csv", "\n".join(["1"] * 11), "singular"),
        ("a.xlsx", "x", "cameras are read from"),
        ("a.npy", "x", "cannot be read as a NumPy file"),
        ("a.npz", "PK\x03\x04 broken", "cannot be read as a NumPy file"),
        ("a.toml", "[metadata]\nerror = 1.0\n", "has no camera"),
        ("a.toml", '[cam_0]\nname = "a"\n', "size is missing"),
        (
            "a.toml",
            '[cam_0]\nname = "a"\nsize = [640]\nmatrix = [[1.0]]\ndistortions = []\nrotation = []\ntranslation = []\n',
            r"\[cam_0\]: a camera needs size",
        ),
    ],
)
def test_files_that_hold_no_cameras_are_refused_in_a_sentence(tmp_path, name, text, sentence):
    (tmp_path / name).write_text(text)
    with pytest.raises(InvalidInputError, match=sentence):
        read_cameras(tmp_path / name, SHAPE)


def test_missing_files_and_sizes_and_single_cameras_are_refused(tmp_path):
    for name in ("none.csv", "none.npy", "none.mat", "none.toml"):
        with pytest.raises(InvalidInputError, match="there is no such file"):
            read_cameras(tmp_path / name, SHAPE)
    np.savetxt(tmp_path / "dlt.csv", dlt_table(), delimiter=",")
    with pytest.raises(InvalidInputError, match="does not say how large"):
        read_cameras(tmp_path / "dlt.csv")
    with pytest.raises(InvalidInputError, match="calibration of 3 cameras, but there are images of 2;"):
        read_cameras(tmp_path / "dlt.csv", [SHAPE] * 2)
    with pytest.raises(InvalidInputError, match=r"no variables from which 'zzz' could be chosen"):
        read_cameras(tmp_path / "dlt.csv", SHAPE, variable="zzz")
    with pytest.raises(InvalidInputError, match="> 0 m"):
        read_cameras(tmp_path / "dlt.csv", SHAPE, unit=0.0)
    np.savetxt(tmp_path / "one.csv", dlt_table()[:, :1], delimiter=",")
    with pytest.raises(InvalidInputError, match="two or more"):
        read_cameras(tmp_path / "one.csv", SHAPE)
    scipy.io.savemat(tmp_path / "other.mat", {"a": np.ones(5)})
    with pytest.raises(InvalidInputError, match=r"has no easyWandData\.coefs"):
        read_cameras(tmp_path / "other.mat", SHAPE)
