from dataclasses import replace

import numpy as np
import pytest
from filmed_flights import BARE, drawn, turning_flight

from flycontrol.errors import InvalidInputError
from flycontrol.model.camera_forms import looking_at
from flycontrol.units import mm
from flycontrol.vision.checks.camera_fit import compared_frames, fit_of_cameras
from flycontrol.vision.checks.camera_order import fitting_order
from flycontrol.vision.sighting import Sighting
from flycontrol.vision.silhouettes import cleaned

PLACES = ((100, 10, 15), (-20, 95, 25), (15, -25, 105))
CAMERAS = tuple(
    looking_at((0, 0, 0), np.array(place) * mm, focal=30 * np.linalg.norm(place), shape=(360, 420), name=f"camera {k}")
    for k, place in enumerate(PLACES, start=1)
)
POSE = turning_flight(1)[:32:4]
EXCHANGED = (CAMERAS[1], CAMERAS[0], CAMERAS[2])


def beside(pose, away):
    """The same flight elsewhere [mm]."""
    X = pose.coordinates.copy()
    X[:, :3] += np.array(away) * mm
    return replace(pose, coordinates=X)


def seen(*poses):
    """Sightings of one fly or of several."""
    together = [
        np.logical_or.reduce(views) for views in zip(*(drawn(pose, BARE, CAMERAS) for pose in poses), strict=True)
    ]
    return [
        Sighting(
            masks=tuple(views),
            crowded=tuple(c.name for c, v in zip(CAMERAS, views, strict=True) if cleaned(v).animals > 1),
        )
        for views in together
    ]


def fit(sightings, cameras):
    return fit_of_cameras(compared_frames(sightings, cameras), cameras)


def test_exchanged_cameras_are_refused_with_the_order_that_fits():
    one = seen(POSE)
    assert fit(one, CAMERAS).doubt == ""
    with pytest.raises(InvalidInputError, match=r"in the order 2, 1, 3 they would fit to 0\.\d+ px; check the order"):
        fit(one, EXCHANGED)


def test_the_order_is_that_in_which_the_given_cameras_belong_to_the_films():
    given = (CAMERAS[2], CAMERAS[0], CAMERAS[1])
    frames = [sighting.masks for sighting in seen(POSE)]
    found = fitting_order(frames, given, 50.0)
    assert found is not None
    assert [given[k].name for k in found.order] == [camera.name for camera in CAMERAS]
    assert fitting_order(frames, CAMERAS, 0.3) is None  # nothing fits four times better than the truth


def test_cameras_are_not_blamed_for_a_second_fly_that_one_of_them_does_not_see():
    pairs = zip(seen(POSE, beside(POSE, (5, -4.5, 0))), seen(POSE), strict=True)
    two = [replace(both, masks=(*both.masks[:2], one.masks[2])) for both, one in pairs]
    assert all(sighting.crowded for sighting in two)
    found = fit(two, CAMERAS)
    assert found.doubt == ""
    assert found.calibration.residual < 0.7  # a touching plane is known to half a pixel in each view


def test_where_several_flies_are_in_view_and_no_pairing_fits_the_calibration_is_only_doubted():
    two = seen(POSE, beside(POSE, (5, -4.5, 0)))
    assert fit(two, EXCHANGED).doubt.startswith("several animals are in view, so that the calibration could not be")


def test_silhouettes_that_the_border_cuts_are_compared_only_where_there_are_no_others():
    whole, cut = seen(POSE), seen(beside(POSE, (0, 0, 5.5)))
    assert any(mask[0].any() for sighting in cut for mask in sighting.masks)
    assert len(compared_frames([*whole, *cut], CAMERAS).frames) == len(whole)
    assert compared_frames(cut, CAMERAS).cut


def test_silhouettes_that_miss_each_other_a_little_are_told_with_both_causes():
    one = [replace(each, masks=(np.roll(each.masks[0], 4, axis=0), *each.masks[1:])) for each in seen(POSE)]
    doubt = fit(one, CAMERAS).doubt
    assert "miss each other by" in doubt
    assert "either the calibration is off, or legs or lost pixels" in doubt
    assert "track more frames" in doubt
