"""Yaw control through biased springs: the wings pitch passively, and the reduced loop has to know it."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from controlled_fly import DELAY, QUICK, STROKE, TORQUE, gains, predicted, pulse
from simulated_fly import FLY

from flycontrol.flight.feedback import YawFeedback
from flycontrol.flight.feedback_flight import controlled_flight
from flycontrol.flight.hinge_fit import at_pitch_axis, fitted_spring
from flycontrol.flight.hinge_motion import passive_wingbeat, sprung
from flycontrol.flight.hinge_transmission import hinge_transmission
from flycontrol.flight.multibody.freedoms import YAW_ONLY, Hinge
from flycontrol.model.hinge import HingeStroke, SteeredSpring
from flycontrol.model.yaw import PDController, YawLoop, YawPlant
from flycontrol.reduce.reduced_yaw import reduced_yaw

AXIS = 0.05  # chords behind the leading edge: where the lab note on the hinge finds the closest spring
KP, KD = 3050.0, 45.0


@cache
def sprung_fly():
    """Fly, stroke of rest angles, state on the periodic wingbeat, transmission, reduced model of given pitch."""
    fly = at_pitch_axis(FLY, AXIS)
    spring = fitted_spring(fly, STROKE).spring
    joint = SteeredSpring(stiffness=spring.stiffness, damping=spring.damping)
    steered = replace(fly, body=YAW_ONLY, left=Hinge(pitch=joint), right=Hinge(pitch=joint))
    rests = HingeStroke(stroke=STROKE.left, rest_angle=spring.rest_angle)
    stroke = replace(STROKE, left=rests, right=rests)
    start = passive_wingbeat(sprung(fly, spring), STROKE).start
    return steered, stroke, start, hinge_transmission(fly, STROKE, spring), reduced_yaw(fly, STROKE)


def control() -> YawFeedback:
    """Gains of a hinge bias, by the torque that a bias makes."""
    _, _, _, transmission, given = sprung_fly()
    per = given.inertia.total / transmission.torque_per_bias
    return YawFeedback(gains=PDController(proportional=KP * per, derivative=KD * per), delay=DELAY)


def misfit(loop: YawLoop, phase: float) -> float:
    fly, stroke, start, _, _ = sprung_fly()
    flight = controlled_flight(fly, stroke, control(), 16, start=start, pulses=[pulse(phase)], settings=QUICK)
    expected = predicted(loop, pulse(phase), flight.trajectory.time)
    return float(np.abs(flight.yaw - expected).max() / np.abs(expected).max())


@pytest.mark.parametrize("phase", np.arange(4) / 4)
def test_with_the_damping_of_wings_that_give_way_both_levels_agree_within_a_fiftieth(phase):
    """A tenth is asked for. beta with wings on their springs, torque by biasing them; nothing is fitted to flights."""
    _, _, _, transmission, given = sprung_fly()
    inertia = given.inertia.total
    plant = YawPlant(inertia=inertia, damping=transmission.damping)
    loop = YawLoop(
        plant=plant, controller=PDController(proportional=KP * inertia, derivative=KD * inertia), delay=DELAY
    )
    assert misfit(loop, phase) < 0.02


def test_the_damping_of_wings_whose_pitch_is_given_misses_by_a_fifth_and_more():
    """A turning body's wings give way on their springs: the dynamics that gamma mu and the rigid wing's beta lack."""
    _, _, _, transmission, given = sprung_fly()
    loop = given.loop(replace(given, transmission=transmission.mu).by_hinge(control().gains), DELAY)
    assert misfit(loop, 0.0) > 0.2
    assert transmission.damping < 0.8 * given.damping


def test_wings_pitch_the_way_that_their_springs_are_biased():
    fly, stroke, start, _, _ = sprung_fly()
    flight = controlled_flight(
        fly, stroke, control(), 16, start=start, pulses=[pulse(torque=10 * TORQUE)], settings=QUICK
    )
    paddled = flight.d_alpha
    asked = flight.averaged(flight.command)[QUICK.samples // 2 :: QUICK.samples][: len(paddled)]
    late = asked < -0.3 * np.abs(asked).max()
    assert late.any()
    assert np.all(paddled[late] < 0)
    assert np.abs(paddled).max() > 0.3 * np.abs(asked).max()


def test_the_gains_of_a_bias_are_not_those_of_paddling():
    assert control().gains.proportional > 1.3 * gains(KP, KD).proportional
