from dataclasses import replace

import numpy as np
import pytest
from filmed_flights import RATE, apart, turning_flight
from scipy.interpolate import make_interp_spline
from scipy.spatial.transform import Rotation

from flycontrol.model.pose import pose_of_axes
from flycontrol.units import deg, mm
from flycontrol.vision.smoothed_pose import SmoothedPose
from flycontrol.vision.smoothing import smoothed
from flycontrol.vision.tracked_frame import Track

#: Standard deviations as a tracker states them: most of those of the wings come from the body's roll.
_WING, _BASE = [2.1 * deg, 1.2 * deg, 1.4 * deg], [6e-3 * mm, 15e-3 * mm, 18e-3 * mm]
SPREAD = np.array([*[6e-3 * mm] * 3, 0.24 * deg, 0.17 * deg, 2.8 * deg, *_WING, *_WING, *_BASE, *_BASE])
LASTING = 2800 / RATE  #: of a tracker's errors, per frame


def lasting(rng, shape):
    """Errors of variance 1 whose correlation after m frames is (1 + kappa m) exp(-kappa m)."""
    frames = np.arange(-40, 41)
    kernel = np.exp(-LASTING * np.abs(frames))  # convolved with itself it is that correlation
    kernel /= np.sqrt(np.sum(kernel**2))
    white = rng.standard_normal((shape[0] + len(kernel) - 1, *shape[1:]))
    return np.apply_along_axis(np.convolve, 0, white, kernel, mode="valid")


def seen_with_errors(pose, rng):
    """A pose as silhouettes show it: the roll of the body badly, the place of its wings in the world well."""
    n = len(pose)
    last, white = lasting(rng, (n, 18)), rng.standard_normal((n, 18))
    body, wing = last + 0.2 * white, 0.7 * (last + white)
    R = pose.body_axes_W @ turned(body[:, 3:6] * [2.8 * deg, 0.17 * deg, 0.17 * deg])
    x = pose.position_W + 6e-3 * mm * body[:, :3]
    wings = [pose.body_axes_W @ turned(0.2 * deg * wing[:, part]) @ np.swapaxes(pose.body_axes_W, 1, 2)
             @ pose.wing_axes_W(side) for side, part in (("left", slice(6, 9)), ("right", slice(9, 12)))]  # fmt: skip
    bases = [np.einsum("nji,nj->ni", R, pose.base_W(side) + 4e-3 * mm * wing[:, part] - x)
             for side, part in (("left", slice(12, 15)), ("right", slice(15, 18)))]  # fmt: skip
    return pose_of_axes(x, R, tuple(wings), tuple(bases), pose.stroke_plane_angle)


def turned(vectors):
    return Rotation.from_rotvec(vectors).as_matrix()


def track_of(pose, spread=SPREAD):
    n = len(pose)
    return Track(
        pose=pose, uncertainty=np.broadcast_to(spread, (n, 18)).copy(),
        status=("tracked",) * n, reasons=("",) * n, overlap=np.ones((n, 3)), precision=np.ones((n, 3)),
    )  # fmt: skip


def unseen(track, frames, status="bridged"):
    states, X, U = list(track.status), track.pose.coordinates.copy(), track.uncertainty.copy()
    for k in frames:
        states[k] = status
    if status == "lost":
        X[frames], U[frames] = np.nan, np.nan
    return replace(track, status=tuple(states), pose=replace(track.pose, coordinates=X), uncertainty=U)


def with_coordinates(track, X):
    return replace(track, pose=replace(track.pose, coordinates=X))


def rms(values):
    return np.sqrt(np.nanmean(np.square(values), axis=0))


def alike(one: SmoothedPose, other: SmoothedPose, share=1e-3):
    """Two smoothed poses differ by far less than is known of them."""
    assert np.nanmax(np.abs(apart(one.pose, other.pose)) / one.uncertainty) < share
    assert np.nanmax(np.abs(one.rate - other.rate) / one.rate_uncertainty) < share
    assert np.nanmax(np.abs(one.acceleration - other.acceleration) / one.acceleration_uncertainty) < share
    omega = np.abs(one.angular_velocity_B - other.angular_velocity_B)
    assert np.nanmax(omega / one.angular_velocity_uncertainty) < share


@pytest.fixture(scope="module")
def flight():
    pose = turning_flight(6)
    return pose, track_of(seen_with_errors(pose, np.random.default_rng(7)))


@pytest.fixture(scope="module")
def smooth_flight(flight):
    return smoothed(flight[1], RATE)


def test_a_cubic_that_is_known_well_comes_back_with_its_derivatives():
    u = np.linspace(0, 1, 200)
    T = 199 / RATE
    pose = turning_flight(6)[:200]
    X = pose.coordinates.copy()
    X[:, 0] = mm * (1 + 2 * u - 3 * u**2 + u**3)
    found = smoothed(track_of(replace(pose, coordinates=X), spread=1e-4 * SPREAD), RATE)
    assert np.max(np.abs(found.pose.position_W[:, 0] - X[:, 0])) < 1e-4 * SPREAD[0]
    assert found.rate[:, 0] == pytest.approx(mm * (2 - 6 * u + 3 * u**2) / T, abs=1e-3 * mm / T)
    assert found.acceleration[:, 0] == pytest.approx(mm * (6 * u - 6) / T**2, abs=0.05 * mm / T**2)


def test_smoothing_brings_every_coordinate_nearer_to_the_truth(flight, smooth_flight):
    pose, track = flight
    gain = rms(apart(smooth_flight.pose, pose)) / rms(apart(track.pose, pose))
    assert np.all(gain < 1), gain
    assert np.all(gain[[5, 6, 7, 9, 10]] < 0.75)  # roll, and strokes and deviations, which its errors had reached


def test_95_percent_bands_hold_the_truth_as_often_as_they_say(flight, smooth_flight):
    pose, _ = flight
    inside = np.abs(apart(smooth_flight.pose, pose)) < 1.96 * smooth_flight.uncertainty
    assert np.all(np.mean(inside, axis=0) > 0.85), np.mean(inside, axis=0)
    time = np.arange(len(pose)) / RATE
    rate = make_interp_spline(time, np.unwrap(pose.coordinates, axis=0), k=5).derivative()(time)
    known = np.abs(smooth_flight.rate - rate) < 1.96 * smooth_flight.rate_uncertainty
    assert np.all(np.mean(known, axis=0) > 0.85), np.mean(known, axis=0)


def test_derivatives_are_those_of_the_smoothed_curve(smooth_flight):
    X = np.unwrap(smooth_flight.pose.coordinates, axis=0)
    step = 1 / RATE
    # Hermite: the slopes and curvatures at both ends of a step give its length to the fourth order
    for low, high, width in (
        (X, smooth_flight.rate, smooth_flight.rate_uncertainty),
        (smooth_flight.rate, smooth_flight.acceleration, smooth_flight.acceleration_uncertainty),
    ):
        away = np.abs(np.diff(low, axis=0) / step - (high[1:] + high[:-1]) / 2)
        assert np.all(np.median(away / width[1:], axis=0) < 0.5)
