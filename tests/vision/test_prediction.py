import numpy as np
from filmed_flights import BARE, turning_flight

from flycontrol.units import deg
from flycontrol.vision.fit_shape import fit_shape
from flycontrol.vision.search.prediction import drifted, expectations
from flycontrol.vision.stance import STEPS, TURN, WING_TURN, stances_of, step_between

BASES = fit_shape(BARE).bases_B
STANCES = stances_of(turning_flight(1)[4:7])
WINGS = slice(WING_TURN[0].start, WING_TURN[1].stop)


def test_a_wing_without_sight_stops_where_a_body_goes_on():
    past = STANCES[:2]
    step = step_between(*past)
    for _ in range(30):
        past = [past[-1], expectations(past, BASES, unseen=True)[0]]
    last = step_between(*past)
    assert np.max(np.abs(last[WINGS])) < 1e-5 * np.max(np.abs(step[WINGS]))
    np.testing.assert_allclose(last[TURN], step[TURN], atol=1e-9)


def test_a_wing_without_sight_comes_to_rest_within_two_of_its_steps():
    """0.6 + 0.6^2 + ... = 1.5 steps about an axis that stays."""
    past = STANCES[:2]
    step = step_between(*past)
    for _ in range(30):
        past = [past[-1], expectations(past, BASES, unseen=True)[0]]
    for side in WING_TURN:
        moved = step_between(STANCES[1], past[-1])[side]
        np.testing.assert_allclose(moved, 1.5 * step[side], rtol=1e-4)


def test_what_is_not_seen_grows_uncertain_as_if_every_error_went_on():
    """n frames add n standard deviations; a turn of which nothing is known grows no further."""
    rng = np.random.default_rng(7)
    A = rng.normal(size=(STEPS, STEPS)) * 1e-2
    covariance = A @ A.T
    before = np.sqrt(np.diag(covariance))
    once, ten = drifted(covariance), covariance
    for _ in range(10):
        ten = drifted(ten)
    growth = np.sqrt(np.diag(once)) - before
    free = np.r_[0:6, 12:18]
    np.testing.assert_allclose((np.sqrt(np.diag(ten)) - before)[free], 10 * growth[free], rtol=1e-9)
    for _ in range(100):
        ten = drifted(ten)
    assert np.all(np.sqrt(np.diag(ten))[WINGS] < 90 * deg)
    assert np.min(np.linalg.eigvalsh(ten / np.sqrt(np.outer(np.diag(ten), np.diag(ten))))) > -1e-12


def test_what_was_certain_becomes_uncertain():
    assert np.all(np.diag(drifted(np.zeros((STEPS, STEPS)))) > 0)
