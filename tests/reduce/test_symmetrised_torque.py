"""Yaw torque of symmetrised wing motion: symmetry, signs, and who turned the fly."""

from dataclasses import replace

import numpy as np
import pytest
from reduced_fly import FLY, wiggling

from flycontrol.errors import InvalidParameterError
from flycontrol.flight.flight_record import taken
from flycontrol.flight.wing_loads import loads_along
from flycontrol.model.stroke_kinematics import StrokeKinematics
from flycontrol.model.symmetrised import VERSIONS, symmetrised
from flycontrol.model.trajectory import wing_angles, wing_rates
from flycontrol.model.wing_stroke import Modulation
from flycontrol.model.wingbeats import Wingbeats
from flycontrol.reduce.factorial import Factorial
from flycontrol.reduce.steady_turn import steady_turn
from flycontrol.reduce.symmetrised_torque import at_rest, torques_by_wingbeat, torques_of_stroke
from flycontrol.units import deg

STROKE = wiggling().kinematics
LEFT = Modulation(stroke_gain=-0.08, stroke_offset=2 * deg, deviation_offset=3 * deg, pitch_offset=-4 * deg)
RIGHT = Modulation(stroke_gain=0.05, stroke_offset=-1 * deg, deviation_offset=-2 * deg, pitch_offset=5 * deg)
ASYMMETRIC = STROKE.modulated(LEFT, RIGHT)
STILL = np.zeros(3)
ROUNDING = 1e-22  # of torques of 1e-9 N m made of parts of 1e-8 N m


def steered(**change: float) -> StrokeKinematics:
    return STROKE.modulated(Modulation(**{k: -v for k, v in change.items()}), Modulation(**change))


def test_wings_with_no_angle_kept_are_mirror_images_and_do_not_turn_the_fly():
    held = symmetrised(steady_turn(ASYMMETRIC, STILL, 100))
    assert np.array_equal(wing_angles(held.left), wing_angles(held.right))
    assert np.array_equal(wing_rates(held.left), wing_rates(held.right))
    assert np.array_equal(held.left_acceleration, held.right_acceleration)
    assert np.max(np.abs(loads_along(FLY, held).total.torque[:, [0, 2]])) < ROUNDING


def test_all_angles_kept_are_the_motion_as_it_was():
    held = steady_turn(ASYMMETRIC, STILL, 100)
    kept = symmetrised(held, VERSIONS[-1])
    assert np.array_equal(wing_angles(kept.right), wing_angles(held.right))
    assert np.array_equal(kept.left_acceleration, held.left_acceleration)


@pytest.mark.parametrize("kept", VERSIONS, ids="-".join)
def test_symmetrising_leaves_the_mean_of_both_wings(kept):
    held = steady_turn(ASYMMETRIC, STILL, 100)
    changed = symmetrised(held, kept)
    for read in (wing_angles, wing_rates):
        before, after = (read(f.left) + read(f.right) for f in (held, changed))
        assert np.allclose(after, before, rtol=1e-14, atol=1e-12 * np.max(np.abs(before)))


def test_an_unknown_angle_is_refused():
    with pytest.raises(InvalidParameterError, match="roll"):
        symmetrised(steady_turn(STROKE, STILL, 100), ["roll"])  # type: ignore[list-item]


def test_exchanged_wings_turn_the_other_way_in_every_version():
    swapped = replace(ASYMMETRIC, left=ASYMMETRIC.right, right=ASYMMETRIC.left)
    assert np.allclose(torques_of_stroke(FLY, ASYMMETRIC), -torques_of_stroke(FLY, swapped), rtol=0, atol=ROUNDING)


@pytest.mark.parametrize(
    ("angle", "change"),
    [
        (0, {"stroke_gain": 0.1}),
        (0, {"stroke_offset": 5 * deg}),
        (1, {"deviation_offset": 5 * deg}),
        (2, {"pitch_offset": 3 * deg}),
    ],
)
def test_a_turn_made_by_one_angle_is_attributed_to_that_angle_alone(angle, change):
    of = Factorial(values=torques_of_stroke(FLY, steered(**change)))
    only = np.eye(3)[angle]
    for effects in (of.alone, of.all_but_one, of.shapley):
        assert np.allclose(effects / of.total, only, rtol=0, atol=1e-9)


def test_the_torque_attributed_to_pitch_is_that_of_the_paddling_angle():
    experiment, angle = wiggling(), 3 * deg
    pitch = Factorial(values=torques_of_stroke(FLY, steered(pitch_offset=angle), experiment.instants)).shapley[2]
    assert abs(pitch - experiment.torque(d_alpha=angle)) < ROUNDING


def test_effects_of_a_mixed_turn_are_those_of_its_parts_and_the_interaction_says_how_nearly():
    parts = {"stroke_gain": 0.1, "deviation_offset": -5 * deg, "pitch_offset": 3 * deg}
    mixed = Factorial(values=torques_of_stroke(FLY, steered(**parts)))
    apart = [Factorial(values=torques_of_stroke(FLY, steered(**{k: v}))).total for k, v in parts.items()]
    slack = np.abs(mixed.effects[1:]).sum() - np.abs(mixed.alone).sum()
    assert np.all(np.abs(mixed.alone - apart) < ROUNDING + 1e-2 * abs(mixed.total))
    assert abs(sum(apart) + mixed.interaction - mixed.total) < 2e-2 * abs(mixed.total)
    assert 0 < slack < 0.1 * abs(mixed.total)


def test_wingbeats_of_a_body_at_rest_have_the_torque_of_their_stroke():
    """Samples at (k + 1/2) / n of a wingbeat, against a spline's integral through a longer flight: kinks, 2e-3."""
    flight = steady_turn(ASYMMETRIC, STILL, 400)
    beat = 1.0 / ASYMMETRIC.frequency
    times = (np.arange(3 * 400) + 0.5) / 400 * beat
    thrice = replace(taken(flight, np.tile(np.arange(400), 3)), time=times)
    torques = torques_by_wingbeat(FLY, at_rest(thrice), Wingbeats(reversals=np.array([0.5, 1.5, 2.5]) * beat))
    assert np.allclose(torques, torques_of_stroke(FLY, ASYMMETRIC, 400), rtol=0, atol=2e-3 * np.max(np.abs(torques)))
