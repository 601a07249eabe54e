"""Yaw control at the wing level: against the reduced loop whose coefficients were found apart, and by itself."""

from dataclasses import replace

import numpy as np
import pytest
from controlled_fly import (
    DELAY,
    FREQUENCY,
    QUICK,
    STROKE,
    TETHERED,
    TORQUE,
    feedback,
    flown,
    gains,
    misfit,
    predicted,
    pulse,
    reduced,
)

from flycontrol.errors import InvalidParameterError
from flycontrol.flight.feedback import Sampling, YawFeedback
from flycontrol.flight.feedback_flight import controlled_flight
from flycontrol.flight.multibody.freedoms import HELD, Hinge
from flycontrol.flight.sensors import Haltere, IdealSensor
from flycontrol.flight.simulate import simulate_flight
from flycontrol.model.hinge import DampedSpring
from flycontrol.model.yaw import PDController


@pytest.mark.parametrize("phase", np.arange(8) / 8)
def test_wings_and_reduced_loop_agree_within_a_hundredth_of_the_peak_at_any_phase_of_the_pulse(phase):
    """A pulse of one wingbeat, as in the experiments; beta, gamma and I from the wings, nothing fitted."""
    loop = reduced().loop(reduced().by_paddling(gains()), DELAY)
    assert misfit(feedback(), loop, pulse(phase)) < 0.01


def test_so_do_their_means_over_a_wingbeat():
    loop = reduced().loop(reduced().by_paddling(gains()), DELAY)
    flight = flown(feedback(), pulse(0.3))
    expected = flight.averaged(predicted(loop, pulse(0.3), flight.trajectory.time))
    inside = np.isfinite(expected)
    assert np.abs(flight.averaged(flight.yaw) - expected)[inside].max() < 0.01 * np.nanmax(expected)


@pytest.mark.parametrize(
    ("name", "law"),
    [("P", {"kd": 0.0, "kp": 900.0}), ("PI", {"kd": 0.0, "kp": 900.0, "ki": 2e4}), ("PID", {"ki": 4e4})],
)
def test_p_pi_and_pid_agree_with_their_reduced_loops(name, law):
    control = feedback(gains=gains(**law))
    loop = reduced().loop(reduced().by_paddling(control.gains), DELAY)
    assert misfit(control, loop, pulse()) < 0.01


def test_a_fly_that_asks_for_nothing_flies_as_without_a_controller():
    idle = feedback(gains=PDController(proportional=0.0))
    plain = simulate_flight(TETHERED, STROKE, 4, pulses=[pulse()], settings=QUICK)
    controlled = flown(idle, pulse(), 4).trajectory
    np.testing.assert_allclose(controlled.q_WS, plain.q_WS, rtol=0, atol=1e-13)
    np.testing.assert_allclose(controlled.angular_acceleration_S, plain.angular_acceleration_S, rtol=0, atol=1e-7)


def test_a_mirrored_pulse_makes_the_mirrored_flight():
    right, left = flown(feedback(), pulse(0.2)), flown(feedback(), pulse(0.2, -TORQUE))
    np.testing.assert_allclose(left.yaw, -right.yaw, rtol=0, atol=1e-12)
    np.testing.assert_allclose(left.command, -right.command, rtol=0, atol=1e-12)


def test_wings_paddle_as_the_command_asks_and_not_before_the_delay_has_passed():
    flight = flown(feedback(), pulse())
    trajectory = flight.trajectory
    np.testing.assert_allclose(0.5 * (trajectory.right.pitch - trajectory.left.pitch), flight.command, atol=1e-14)
    assert np.all(flight.command[trajectory.time <= 1 / FREQUENCY + DELAY] == 0)
    assert flight.d_alpha[5] < -0.1 * np.abs(flight.command).max()  # turned right, it paddles to the left


def test_a_delay_counts_the_same_in_the_sensor_and_behind_it():
    together, apart = feedback(), feedback(delay=DELAY / 3, sensor=IdealSensor(delay=DELAY * 2 / 3))
    np.testing.assert_allclose(flown(apart, pulse()).yaw, flown(together, pulse()).yaw, rtol=0, atol=1e-12)


def test_a_delay_of_less_than_a_wingbeat_is_resolved():
    control = feedback(delay=0.23 / FREQUENCY)
    loop = reduced().loop(reduced().by_paddling(gains()), control.delay)
    assert misfit(control, loop, pulse()) < 0.01


def test_reading_the_delay_line_between_its_entries_costs_a_millionth():
    """A delay of 600.5 steps: halfway between those of 600 and 601, up to squares of a step and what reading costs.

    A filter keeps the command smooth; without it, its rate jumps with the pulse and the wings' inertia feels where.
    """
    step = 1 / (FREQUENCY * QUICK.steps)
    smooth = feedback(sensor=Haltere(time_constant=1e-3))
    early, between, late = (flown(replace(smooth, delay=n * step), pulse()).yaw for n in (600, 600.5, 601))
    assert np.abs(between - (early + late) / 2).max() < 2e-6 * between.max()


def test_on_a_tether_an_unfiltered_haltere_is_an_ideal_sensor():
    np.testing.assert_allclose(
        flown(feedback(sensor=Haltere()), pulse()).yaw, flown(feedback(), pulse()).yaw, rtol=0, atol=1e-9
    )


def test_a_halteres_filter_acts_as_a_delay_of_its_time_constant():
    """1 / (1 + s tau) = exp(-s tau) + O((s tau)^2): 0.4 ms against a loop of 60 rad/s, (s tau)^2 / 2 = 3e-4."""
    tau = 0.4e-3
    loop = reduced().loop(reduced().by_paddling(gains()), DELAY + tau)
    assert misfit(feedback(sensor=Haltere(time_constant=tau)), loop, pulse()) < 0.01


@pytest.mark.parametrize("per_wingbeat", [1, 2, 4, 200])
def test_a_sampled_and_held_command_comes_later_by_half_an_interval_and_half_its_ramp(per_wingbeat):
    sampling = Sampling(per_wingbeat=per_wingbeat)
    late = (1 + sampling.ramp) / (2 * per_wingbeat * FREQUENCY)
    loop = reduced().loop(reduced().by_paddling(gains()), DELAY + late)
    assert misfit(feedback(sampling=sampling), loop, pulse()) < 0.01


def test_a_limited_command_stays_within_its_limit_and_is_the_unlimited_one_where_small():
    limit, strong = 0.02, pulse(torque=60 * TORQUE)
    limited = flown(feedback(limit=limit), strong, 30)
    free = flown(feedback(), strong, 30)
    assert np.abs(limited.command).max() <= limit < np.abs(free.command).max()
    assert np.abs(limited.yaw).sum() > np.abs(free.yaw).sum()
    weak = pulse(torque=1e-3 * TORQUE)
    np.testing.assert_allclose(flown(feedback(limit=limit), weak).yaw, flown(feedback(), weak).yaw, rtol=0, atol=1e-9)


def test_halving_the_step_changes_little():
    """Kinks of |w| w at reversals, not the delay line, are what is left of it."""
    coarse = flown(feedback(), pulse())
    fine = flown(feedback(), pulse(), settings=replace(QUICK, steps=400))
    assert np.abs(fine.yaw - coarse.yaw).max() < 3e-3 * fine.yaw.max()


def test_what_cannot_be_controlled_is_refused_in_a_sentence():
    deaf = replace(TETHERED, left=Hinge(pitch=DampedSpring(stiffness=2e-9)))
    with pytest.raises(InvalidParameterError, match="at least one step"):
        flown(feedback(delay=0.0), pulse())
    with pytest.raises(InvalidParameterError, match="both pitch joints"):
        controlled_flight(deaf, STROKE, feedback(), 1)
    for wingbeats in (0, 2.5, float("nan"), "3"):
        with pytest.raises(InvalidParameterError, match="at least one wingbeat, and whole ones, got"):
            controlled_flight(TETHERED, STROKE, feedback(), wingbeats)
    with pytest.raises(InvalidParameterError, match="this one's yaw is held"):
        controlled_flight(replace(TETHERED, body=HELD), STROKE, feedback(), 1)
    with pytest.raises(InvalidParameterError, match=r"PDController or a PIDController, got \(0.03, 0.0004\)"):
        feedback(gains=(0.03, 0.0004))
    with pytest.raises(InvalidParameterError, match="delay must be >= 0"):
        YawFeedback(gains=gains(), delay=float("nan"))
    with pytest.raises(InvalidParameterError, match="limit must be > 0"):
        feedback(limit=0.0)
    with pytest.raises(InvalidParameterError, match="at least 1"):
        Sampling(per_wingbeat=0)
    with pytest.raises(InvalidParameterError, match="time_constant must be >= 0"):
        Haltere(time_constant=-1e-3)


def test_a_flight_that_diverges_keeps_what_was_flown_and_says_why():
    thrown = flown(feedback(), pulse(torque=1e9 * TORQUE), 4)
    assert not thrown.trajectory.complete
    assert "stopped in wingbeat" in thrown.trajectory.status
    assert len(thrown.command) == len(thrown.trajectory.time)


@pytest.mark.parametrize("fly", [simulate_flight, lambda *a, **k: controlled_flight(*a[:2], feedback(), *a[2:], **k)])
def test_a_pulse_that_never_acts_is_refused_and_one_that_does_so_in_part_is_not(fly):
    late, early, partly = (replace(pulse(), start=start / FREQUENCY) for start in (2.0, -1.0, 1.5))
    for idle in (late, early):
        with pytest.raises(
            InvalidParameterError, match=r"during the flight of 2 wingbeats, 0 to 0.00909091 s, got one"
        ):
            fly(TETHERED, STROKE, 2, pulses=[idle], settings=QUICK)
    fly(TETHERED, STROKE, 2, pulses=[partly], settings=QUICK)


def test_means_of_other_values_than_the_flights_are_refused():
    flight = controlled_flight(TETHERED, STROKE, feedback(), 2, settings=QUICK)
    with pytest.raises(InvalidParameterError, match=r"each of the flight's 101 instants, got shape \(20,\)"):
        flight.averaged(flight.yaw[:20])
