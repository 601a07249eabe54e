"""The flight after a kick against the reduced model's exponential."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from reduced_fly import FLY, MELANOGASTER, hover, trim

from flycontrol.errors import InvalidParameterError
from flycontrol.flight.hinge_fit import at_pitch_axis
from flycontrol.flight.hinge_motion import passive_wingbeat, sprung
from flycontrol.flight.hinge_transmission import hinge_transmission
from flycontrol.flight.quasi_steady import VACUUM
from flycontrol.model.hinge import DampedSpring
from flycontrol.model.stroke_kinematics import StrokeKinematics
from flycontrol.model.wing_stroke import paddling
from flycontrol.reduce.half_life import YawDecay, yaw_decay
from flycontrol.reduce.reduced_yaw import reduced_yaw
from flycontrol.reduce.yaw_inertia import yaw_inertia
from flycontrol.reduce.yaw_torque import yaw_slopes


@cache
def tethered() -> YawDecay:
    return yaw_decay(FLY, trim().kinematics)


@cache
def flying() -> YawDecay:
    return yaw_decay(FLY, trim().kinematics, trim().start, freedom="all")


def test_on_a_tether_yaw_halves_in_ln2_inertia_over_damping():
    """Within 1 %: damping and inertia vary over the wingbeat, and only a fourteenth of the inertia does."""
    assert tethered().half_life == pytest.approx(reduced_yaw(FLY, trim().kinematics).half_life, rel=0.01)


def test_after_a_whole_wingbeat_it_does_not_matter_when_the_kick_came():
    """A linear law with periodic coefficients, to the part of damping that is cubic."""
    assert np.ptp(tethered().decay) < 1e-5 * tethered().decay.mean()


def test_what_averaging_over_the_wingbeat_loses_goes_with_the_inverse_of_the_inertia():
    """A body that turns less within a wingbeat: three times the inertia, a third of what separates both half-lives."""
    m = MELANOGASTER
    heavy = replace(FLY, morphology=replace(m, inertia=tuple(tuple(3 * x for x in row) for row in m.inertia)))
    off = []
    for fly, decay in ((FLY, tethered()), (heavy, yaw_decay(heavy, trim().kinematics, phases=(0.0, 0.5)))):
        off.append(abs(decay.half_life / reduced_yaw(fly, trim().kinematics).half_life - 1))
    assert off[1] < 0.45 * off[0]


def test_wings_on_springs_make_yaw_last_as_long_as_their_own_damping_says():
    """Once their pitch follows; a prescribed pitch would let it halve in half the time."""
    spring = DampedSpring(stiffness=3e-9, damping=1.5e-12)
    fly = at_pitch_axis(FLY, 0.05)
    given = reduced_yaw(fly, trim().kinematics)
    passive = given.through(hinge_transmission(fly, trim().kinematics, spring))
    sprung_fly = sprung(fly, spring)
    start = passive_wingbeat(sprung_fly, trim().kinematics).trajectory.state(0)
    found = yaw_decay(sprung_fly, trim().kinematics, start)
    assert found.late_half_life == pytest.approx(passive.half_life, rel=0.03)
    assert found.late_half_life > 1.5 * given.half_life


def test_small_and_large_kicks_decay_alike():
    larger = yaw_decay(FLY, trim().kinematics, rate=30.0, phases=(0.25,))
    assert larger.decay[0] == pytest.approx(tethered().decay[2], rel=1e-3)


def test_in_free_flight_yaw_halves_sooner_since_the_body_rolls_along():
    """The product of inertia: a short yaw torque turns 1 / (n J^-1 n), two thirds of I, and yaw decays as fast."""
    inertia = yaw_inertia(hover())
    damping = yaw_slopes(hover()).damping
    assert inertia.free < 0.7 * inertia.total
    assert flying().half_life < 0.7 * tethered().half_life
    assert flying().half_life == pytest.approx(np.log(2) * inertia.free / damping, rel=0.1)


def test_a_short_kick_gives_the_rate_that_the_inertia_says():
    """Mean over the phases; the rigid body alone would turn at 1 rad/s."""
    inertia = yaw_inertia(hover())
    assert tethered().rates[:, 0].mean() == pytest.approx(inertia.body / inertia.total, rel=0.02)
    assert flying().rates[:, 0].mean() == pytest.approx(inertia.body / inertia.free, rel=0.02)


def test_without_air_nothing_decays_and_it_says_so():
    with pytest.raises(InvalidParameterError, match="did not halve within 4 wingbeats"):
        yaw_decay(replace(FLY, air=VACUUM), trim().kinematics, phases=(0.0,))


def test_a_stroke_that_turns_by_itself_is_refused():
    stroke: StrokeKinematics = trim().kinematics.modulated(*paddling(0.1))
    with pytest.raises(InvalidParameterError, match="symmetrise them first"):
        yaw_decay(FLY, stroke)


def test_a_kick_to_the_left_decays_as_one_to_the_right():
    """The mirror image of a fly with wings alike: the same flight but for the sign of its rate."""
    right, left = (yaw_decay(FLY, trim().kinematics, rate=rate, phases=[0.25]) for rate in (1.0, -1.0))
    np.testing.assert_allclose(left.rates, -right.rates, rtol=1e-9)
    np.testing.assert_allclose(left.first_halves, right.first_halves, rtol=1e-9)
    assert left.half_life == pytest.approx(right.half_life, rel=1e-9)


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"rate": 0.0}, "a finite rate other than 0 rad/s, got 0.0"),
        ({"rate": float("nan")}, "a finite rate other than 0 rad/s, got nan"),
        ({"phases": 0.5}, r"a list of at least one phase, got 0.5; write phases=\[0.25\]"),
        ({"phases": []}, r"at least one phase, got \[\]"),
        ({"phases": [1.0]}, "must lie in 0..1 wingbeats"),
        ({"freedom": "roll"}, "freedom 'yaw' or 'all', got 'roll'"),
    ],
)
def test_what_is_no_kick_is_refused_in_a_sentence(changes, sentence):
    with pytest.raises(InvalidParameterError, match=sentence):
        yaw_decay(FLY, trim().kinematics, **changes)
