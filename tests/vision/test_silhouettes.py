import numpy as np
import pytest

from flycontrol.errors import InvalidInputError, InvalidParameterError
from flycontrol.model.camera_forms import orthogonal_cameras
from flycontrol.model.flapping_pose import flapping_pose
from flycontrol.model.planform import Planform
from flycontrol.model.stroke_kinematics import hover_stroke
from flycontrol.units import deg, mm
from flycontrol.vision.fly_shape import fly_shape
from flycontrol.vision.render import Imaging, render_frames, render_silhouettes
from flycontrol.vision.silhouettes import Segmentation, background_of, cleaned, silhouette_of

PLANFORM = Planform(length=2.4 * mm, mean_chord=0.7 * mm, second_moment_radius=0.58)
FLY = fly_shape(PLANFORM, legs=True)
CAMERA = orthogonal_cameras(scale=35 / mm, shape=(200, 320))[:1]


def passing(count=11):
    """A fly that comes from outside and crosses the field of view of a camera that looks along x."""
    place = np.stack([np.zeros(count), np.linspace(-12, 12, count), np.zeros(count)], axis=1) * mm
    return flapping_pose(
        hover_stroke(), np.arange(count) / 1111, right_base_B=FLY.right_base_B, stroke_plane_angle=50 * deg,
        position_W=place, attitude=(0, 45 * deg, 0),
    )  # fmt: skip


def test_a_moving_fly_is_not_in_the_background_and_comes_back_out_of_its_frames():
    pose, imaging = passing(), Imaging(blur=0.7, noise=0.03)
    clean = [masks[0] for masks in render_silhouettes(FLY, pose, CAMERA)]
    lamp = np.linspace(-20, 20, 320)  # uneven light
    frames = [np.clip(views[0] + lamp, 0, 255) for views in render_frames(((mask,) for mask in clean), imaging, seed=1)]
    background = background_of(frames)
    assert np.max(np.abs(background - 200 - lamp)) < 25  # no trace of the fly, 160 levels darker
    for frame, mask in zip(frames, clean, strict=True):
        found = silhouette_of(frame, background)
        wrong = np.count_nonzero(found.mask != mask)
        assert wrong <= 0.06 * mask.sum() + 5  # legs, 1.75 px wide, lose contrast by blur
        assert found.animals == (1 if mask.any() else 0)


def test_a_threshold_is_half_the_animals_contrast_for_any_gain():
    mask = np.zeros((50, 60), bool)
    mask[20:30, 20:40] = True
    for gain, offset in ((1.0, 0.0), (0.1, 3.0)):
        cover = mask.astype(float)
        cover[20:30, 40] = 0.6
        cover[20:30, 41] = 0.4
        frame = gain * (200 - 150 * cover) + offset
        found = silhouette_of(frame, np.full((50, 60), gain * 200 + offset)).mask
        assert found[25, 40]
        assert not found[25, 41]


def test_a_bright_animal_on_dark_ground_is_found_as_well():
    frame = np.zeros((40, 40))
    frame[10:20, 10:20] = 90
    assert silhouette_of(frame, np.zeros((40, 40)), Segmentation(dark=False)).mask.sum() == 100
    assert silhouette_of(frame, np.zeros((40, 40))).mask.sum() == 0


def test_dust_goes_and_parts_of_the_animal_stay():
    raw = np.zeros((60, 80), bool)
    raw[20:40, 20:40] = True
    raw[25:30, 45:60] = True  # a wing cut off by a fold
    raw[0, 0] = raw[59, 79] = raw[5:7, 70:72] = True
    found = cleaned(raw)
    assert found.mask.sum() == 400 + 75
    assert found.animals == 1
    np.testing.assert_array_equal(found.raw, raw)


def test_legs_go_by_opening_and_the_body_stays():
    pose = passing(11)[5]
    legs = next(render_silhouettes(FLY, pose, CAMERA, parts=["legs"]))[0]
    body = next(render_silhouettes(FLY, pose, CAMERA, parts=["body"]))[0]
    found = cleaned(next(render_silhouettes(FLY, pose, CAMERA))[0])
    outside = legs & ~next(render_silhouettes(FLY, pose, CAMERA, parts=["body", "left", "right"]))[0]
    assert np.count_nonzero(found.mask & outside) == outside.sum()
    assert np.count_nonzero(found.core & outside) < 0.35 * outside.sum()  # feet of legs stay where they meet the body
    assert np.count_nonzero(body & ~found.core) < 0.01 * body.sum()


def test_two_flies_and_none_are_counted():
    raw = np.zeros((60, 80), bool)
    assert cleaned(raw).animals == 0
    raw[10:20, 10:20] = raw[40:50, 60:70] = True
    assert cleaned(raw).animals == 2


def test_frames_that_do_not_fit_and_settings_without_sense_are_refused():
    with pytest.raises(InvalidInputError, match="got none"):
        background_of([])
    with pytest.raises(InvalidInputError, match="equal rows and columns"):
        background_of([np.zeros((3, 4)), np.zeros((4, 3))])
    with pytest.raises(InvalidInputError, match="does not fit its background"):
        silhouette_of(np.zeros((3, 4)), np.zeros((4, 3)))
    with pytest.raises(InvalidParameterError, match="contrast must be > 0"):
        Segmentation(contrast=0.0)
    with pytest.raises(InvalidParameterError, match="shares"):
        Segmentation(smallest_share=2.0)
