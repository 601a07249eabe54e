"""The map of what data cannot tell apart, against profiles and against a covariance."""

import numpy as np
import pytest

from flycontrol.errors import InvalidParameterError
from flycontrol.identify.gains.fit import fit_gains
from flycontrol.identify.gains.model import gain_model
from flycontrol.identify.gains.profile import profile
from flycontrol.identify.gains.response import yaw_response
from flycontrol.identify.gains.ridge import blind_pair, ridge, window
from flycontrol.model.trial import Pulse, Trial
from flycontrol.units import deg, ms

TRUTH = {"kp": 3050.0, "kd": 45.0, "delay": 13.6 * ms, "damping": 69.0, "impulse": 35.0}
PULSE = Pulse(onset=10 * ms, duration=4.5 * ms)


def fitted(noise, end, free=("damping",)):
    times = np.arange(0, end, 1 / 4000)
    yaw = yaw_response(TRUTH, times, PULSE).yaw + noise * np.random.default_rng(0).standard_normal(len(times))
    known = {"initial_yaw": 0.0, "initial_rate": 0.0} | ({} if free else {"damping": TRUTH["damping"]})
    trial = Trial(name="fly", time=times, yaw=yaw, rate=4000.0, perturbation=PULSE)
    return fit_gains([trial], gain_model(fixed=known))


def mapped(found, names, side=7):
    one, other = (profile(found.weighted, found.minimum, found.uncertainty, name) for name in names)
    return one, ridge(found.weighted, found.minimum, (one, other), side=side)


@pytest.fixture(scope="module")
def sharp():
    return fitted(0.1 * deg, 0.1, free=())


def test_with_little_noise_the_map_is_the_covariances_quadratic_form(sharp):
    _, found = mapped(sharp, ("kp", "kd"))
    names = sharp.problem.names
    at = [names.index("kp"), names.index("kd")]
    C = np.linalg.inv(sharp.minimum.at.matrix)[at][:, at]
    away = np.stack(np.meshgrid(found.first - found.estimate[0], found.second - found.estimate[1], indexing="ij"), -1)
    expected = np.einsum("mni,ij,mnj->mn", away, np.linalg.inv(C), away)
    near = expected < 20
    assert near.sum() > 10
    np.testing.assert_allclose(found.deviance[near], expected[near], rtol=0.15, atol=0.05)  # the model's curvature


def test_the_floor_of_the_map_is_never_below_the_profile_and_meets_it_at_the_estimate(sharp):
    one, found = mapped(sharp, ("kp", "kd"), side=9)
    floor = found.deviance.min(axis=1)
    inside = (found.first >= one.values[0]) & (found.first <= one.values[-1])
    along = np.interp(found.first[inside], one.values, np.sqrt(one.deviance) * np.sign(one.values - found.estimate[0]))
    assert np.all(floor[inside] > along**2 - 0.1)
    assert floor.min() == pytest.approx(0.0, abs=1e-3)
    assert not found.open_ends


def test_a_recording_too_short_for_the_reflex_leaves_a_valley_with_an_open_end():
    found = fitted(0.3 * deg, 0.04)
    pair = blind_pair(found.weighted, found.minimum)
    assert pair is not None
    assert set(pair) < {"kp", "kd", "delay", "damping"}
    _, valley = mapped(found, pair)
    assert valley.open_ends
    assert len(valley.valley) > 1


def test_a_window_holds_the_estimate_and_respects_the_bounds(sharp):
    seen = profile(sharp.weighted, sharp.minimum, sharp.uncertainty, "delay")
    grid = window(seen, sharp.weighted, 11)
    i = sharp.problem.names.index("delay")
    assert sharp.minimum.x[i] in grid
    assert np.all(np.diff(grid) > 0)
    assert grid[0] >= sharp.problem.low[i]
    assert grid[-1] <= sharp.problem.high[i]


def test_a_ridge_of_one_unknown_is_refused(sharp):
    with pytest.raises(InvalidParameterError, match="two different unknowns"):
        mapped(sharp, ("kp", "kp"))
