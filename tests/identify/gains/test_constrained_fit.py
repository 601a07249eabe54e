"""Fits under constraints, by the exact delay and by an approximant."""

import casadi as ca
import numpy as np
import pytest
from scipy.optimize import minimize_scalar

from flycontrol.errors import InvalidParameterError
from flycontrol.identify.gains.constrained import constrained_fit, fit_gains_under
from flycontrol.identify.gains.constraints import Constraint, modulus_margin_at_least, stable
from flycontrol.identify.gains.fit import fit_gains
from flycontrol.identify.gains.model import gain_model
from flycontrol.identify.gains.response import yaw_response
from flycontrol.model.gains import largest_stable_delay
from flycontrol.model.trial import Pulse, Trial
from flycontrol.model.yaw import YawLoop
from flycontrol.units import deg

PULSE = Pulse(onset=0.01, duration=0.0045)
TIMES = np.arange(401) / 4000
KNOWN = {"damping": 69.0, "initial_yaw": 0.0, "initial_rate": 0.0, "heading": 0.0, "impulse": 35.0}
FLY = {"kp": 3050.0, "kd": 45.0, "delay": 0.0136, "damping": 69.0, "impulse": 35.0}


def recording(seed=0, **truth):
    rng = np.random.default_rng(seed)
    yaw = yaw_response(FLY | truth, TIMES, PULSE).yaw + 0.3 * deg * rng.standard_normal(len(TIMES))
    return Trial(name="fly", time=TIMES, yaw=yaw, rate=4000.0, perturbation=PULSE)


def loop_of(found):
    return YawLoop.from_rates(b=69.0, kp=found.values["kp"], kd=found.values["kd"], delay=found.values["delay"])


@pytest.fixture(scope="module")
def free():
    return fit_gains([recording()], gain_model(fixed=KNOWN))


def test_constraints_that_hold_anyway_leave_the_fit_where_it_is(free):
    found = constrained_fit(free, [stable(), modulus_margin_at_least(0.2)])
    assert found.converged
    assert found.binding == ()
    errors = [e.standard_error for e in free.estimates]
    assert np.abs(found.x - free.minimum.x).max() < 1e-4 * max(errors)
    np.testing.assert_allclose(np.sqrt(np.diag(found.covariance)), errors, rtol=1e-3)
    assert abs(found.price) < 1e-6


def test_a_binding_line_is_kept_exactly_and_its_price_is_that_of_the_nearest_point_on_it(free):
    """Of a quadratic bowl the price is (distance / deviation of the distance)^2."""
    off = 0.5 * free["kd"].standard_error
    edge = free.minimum.x[1] - off
    found = constrained_fit(free, [Constraint(name="kd low", expression=lambda p: p["kd"], low=-np.inf, high=edge)])
    assert found.converged
    assert found.binding == ("kd low",)
    assert found.values["kd"] == pytest.approx(edge, rel=1e-7)
    assert found.price == pytest.approx(0.25, rel=0.05)  # the bowl is not quite quadratic
    assert found.standard_errors["kd"] < 1e-6 * free["kd"].standard_error
    assert found.standard_errors["kp"] < free["kp"].standard_error


def test_a_wanted_modulus_margin_is_that_of_the_exact_loop(free):
    assert loop_of_values(free.minimum.x).margins().modulus_margin < 0.6
    found = constrained_fit(free, [stable(), modulus_margin_at_least(0.65)])
    assert found.converged
    assert found.binding == ("modulus margin >= 0.65",)
    assert loop_of(found).margins().modulus_margin == pytest.approx(0.65, abs=3e-4)
    assert found.price > 1.0


def loop_of_values(x):
    return YawLoop.from_rates(b=69.0, kp=x[0], kd=x[1], delay=x[2])


def test_the_constrained_minimum_beats_its_neighbours_on_the_boundary(free):
    """Walk along the boundary by the gain: no point of it fits better."""
    found = constrained_fit(free, [stable(), modulus_margin_at_least(0.65)])
    delay = found.values["delay"]

    def cost(kp):
        def miss(kd):
            return (YawLoop.from_rates(b=69.0, kp=kp, kd=kd, delay=delay).margins().modulus_margin - 0.65) ** 2

        kd = minimize_scalar(miss, bracket=(0.97 * found.values["kd"], 1.03 * found.values["kd"]), tol=1e-10).x
        return free.weighted.normal_equations(np.array([kp, kd, delay])).cost

    for factor in (0.97, 0.99, 1.01, 1.03):
        assert cost(factor * found.values["kp"]) > found.at.cost - 0.02


def test_an_unstable_estimate_is_moved_to_the_boundary_of_stability():
    grown = recording(kp=9000.0, kd=60.0, delay=0.0155)
    free = fit_gains([grown], gain_model(fixed=KNOWN))
    kp, kd, delay = free.minimum.x
    assert delay > largest_stable_delay(69.0, kp, kd)
    found = constrained_fit(free, [stable()])
    kp, kd, delay = found.x
    assert found.converged
    assert delay == pytest.approx(largest_stable_delay(69.0, kp, kd), rel=1e-6)
    assert abs(loop_of(found).poles(1)[0].real) < 1e-3


@pytest.mark.parametrize("pade_order", [None, 6])
def test_both_routes_keep_the_same_constraints(free, pade_order):
    found = constrained_fit(free, [stable(0.008)], pade_order)
    assert found.converged
    kp, kd, delay = found.x
    assert largest_stable_delay(69.0, kp, kd) - delay >= 0.008 - 1e-8
    assert found.route == ("exact delay" if pade_order is None else "Padé [6/6]")


def test_constraints_that_contradict_each_other_end_in_a_status():
    low = Constraint(name="low", expression=lambda p: p["kp"], low=-np.inf, high=1000.0)
    high = Constraint(name="high", expression=lambda p: p["kp"], low=2000.0)
    found = fit_gains_under([low, high], [recording()], gain_model(fixed=KNOWN))
    assert not found.converged
    assert "not converged: IPOPT ended with" in found.status


def test_what_is_no_constraint_is_refused_in_a_sentence(free):
    with pytest.raises(InvalidParameterError, match="at least one constraint"):
        fit_gains_under([], [recording()])
    with pytest.raises(InvalidParameterError, match="asks for 'kpp'"):
        constrained_fit(free, [Constraint(name="typo", expression=lambda p: p["kpp"])])
    with pytest.raises(InvalidParameterError, match="does not depend on any unknown"):
        constrained_fit(free, [Constraint(name="known", expression=lambda p: p["damping"] - 3.0)])
    with pytest.raises(InvalidParameterError, match="between 0 and 1"):
        modulus_margin_at_least(1.5)
    with pytest.raises(InvalidParameterError, match="that of P and PD"):
        constrained_fit(fit_gains([recording()], gain_model("PID", fixed=KNOWN)), [stable()])
    with pytest.raises(InvalidParameterError, match="low must lie below high"):
        Constraint(name="empty", expression=lambda p: p["kp"], low=1.0, high=0.0)


def test_float_of_a_symbol_never_reaches_a_fit(free):
    """CasADi answers float(symbol) with NaN, or refuses: either way a sentence comes out."""
    with pytest.raises(InvalidParameterError, match="functions"):
        constrained_fit(free, [Constraint(name="squared", expression=lambda p: float(p["kp"]) ** 2)])
    with pytest.raises(InvalidParameterError, match="must be a finite number"):
        gain_model(fixed={"kp": ca.SX.sym("kp")})
