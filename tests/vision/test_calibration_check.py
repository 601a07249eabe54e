import numpy as np
import pytest
from hull_scenes import SCALE, SHAPE, cameras_around, ellipsoid, silhouette_of_ellipsoid

from flycontrol.errors import InvalidInputError
from flycontrol.model.camera import Camera
from flycontrol.model.camera_forms import camera_from_dlt, orthogonal_cameras
from flycontrol.units import mm
from flycontrol.vision.checks.calibration_check import check_calibration
from flycontrol.vision.silhouettes import cleaned


def shifted(camera, pixels):
    """The camera as a calibration that is wrong by so many pixels along u and v."""
    shift = np.eye(3)
    shift[:2, 2] = pixels
    return Camera(matrix=shift @ camera.matrix, shape=camera.shape, name=camera.name)


def test_true_cameras_leave_less_than_a_pixel():
    for seed in range(8):
        cameras, (A, centre) = cameras_around(seed), ellipsoid(seed)
        masks = [silhouette_of_ellipsoid(camera, A, centre) for camera in cameras]
        check = check_calibration([masks], cameras)
        for pair in check.pairs:
            assert abs(pair.shift[0]) < 1  # each touching plane is known to half a pixel in each view
            assert abs(pair.growth[0]) < 2
        assert check.residual < 0.7


def test_a_camera_moved_across_the_common_planes_shows_by_how_many_pixels():
    x, y, z = orthogonal_cameras(scale=SCALE, shape=SHAPE)
    A, centre = ellipsoid(1)
    masks = [silhouette_of_ellipsoid(camera, A, centre) for camera in (x, y, z)]
    # cameras along x and y share the heights: rows; a calibration whose images lie 6 px lower than the true ones
    check = check_calibration([masks], [x, shifted(y, (0, 6)), z])
    assert abs(check.pairs[0].shift[0]) == pytest.approx(6, abs=1)
    assert check.pairs[0].cameras == ("from x", "from y")
    assert check.pairs[1].median < 1
    assert check.pairs[2].median < 1
    along = check_calibration([masks], [x, shifted(y, (6, 0)), z])  # seen against the camera from above
    assert along.pairs[0].median < 1
    assert along.pairs[2].median == pytest.approx(6, abs=1)


def test_a_silhouette_cut_too_wide_shows_as_growth_and_not_as_shift():
    cameras = orthogonal_cameras(scale=SCALE, shape=SHAPE)
    A, centre = ellipsoid(2)
    masks = [silhouette_of_ellipsoid(camera, A, centre) for camera in cameras]
    wide = masks[1].copy()
    for _ in range(3):
        wide[1:-1, 1:-1] |= wide[:-2, 1:-1] | wide[2:, 1:-1]
    pair = check_calibration([[masks[0], wide, masks[2]]], cameras).pairs[0]
    assert abs(pair.growth[0]) == pytest.approx(6, abs=1.5)
    assert abs(pair.shift[0]) < 1


def test_frames_with_an_empty_silhouette_do_not_count():
    cameras = cameras_around(3)
    A, centre = ellipsoid(3)
    masks = np.array([silhouette_of_ellipsoid(camera, A, centre) for camera in cameras])
    gone = masks.copy()
    gone[0] = False
    check = check_calibration([masks, gone], cameras)
    assert np.isnan(check.pairs[0].shift).tolist() == [False, True]
    assert np.isfinite(check.residual)
    with pytest.raises(InvalidInputError, match="every frame had an empty one"):
        check_calibration([gone & False], cameras)
    with pytest.raises(InvalidInputError, match="there were none"):
        check_calibration([], cameras)


def test_a_published_take_off_was_calibrated_to_a_pixel_or_so(real_data):
    """Three cameras at 35 px/mm; the residual holds errors of segmentation and legs too."""
    file = real_data / "silhouettes" / "exp095_first47.npz"
    if not file.is_file():
        pytest.skip(f"{file.name} is not there.")
    with np.load(file) as data:
        masks = np.unpackbits(data["masks_packed"], axis=-1).reshape(47, 3, 512, 512).astype(bool)
        masks = [[cleaned(mask).mask for mask in views] for views in masks]  # corners of the images are set
        cameras = [camera_from_dlt(row, (512, 512), unit=mm, name=f"camera {k}") for k, row in enumerate(data["DLT"].T)]
    assert check_calibration(masks, cameras).residual < 2.0
    assert check_calibration(masks, [*cameras[1:], cameras[0]]).residual > 10.0  # cameras in the wrong order
