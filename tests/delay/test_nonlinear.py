import math
from itertools import pairwise

import numba
import numpy as np
import pytest
from pd_loop import pd_closed
from scipy.integrate import solve_ivp

from flycontrol.delay.nonlinear import nonlinear_response
from flycontrol.delay.piecewise import piecewise_polynomial, sampled
from flycontrol.delay.timeresponse import forced_response
from flycontrol.errors import InvalidParameterError

T, KP, KD, DAMPING, LIMIT, PULSE = 0.0136, 3050.0, 45.0, 69.0, 300.0, 0.0045


@numba.njit
def saturated(t, x, w, u, p):
    """psi'' = -b psi' - L tanh((kp psi + kd psi')(t - T) / L) + u."""
    return np.array([x[1], -p[2] * x[1] - p[3] * np.tanh(w[0] / p[3]) + u[0]])


@numba.njit
def demand(t, x, w, u, p):
    return np.array([p[0] * x[0] + p[1] * x[1]])


@numba.njit
def itself(t, x, w, u, p):
    return x.copy()


@numba.njit
def growth(t, x, w, u, p):
    """x' = -k x(t - 1) (1 + x)."""
    return -p[0] * w * (1.0 + x)


@numba.njit
def mackey_glass(t, x, w, u, p):
    return 0.2 * w / (1.0 + w**10) - 0.1 * x


def by_segments(slope, past, tau, kinks, x0, probes):
    """SciPy's DOP853 from kink to kink for one delay; slope(t, x, delayed x, middle of the segment)."""
    segments, x, found = [], np.array(x0, float), {}

    def before(t, middle):
        return past(t) if middle < 0 else next(sol for a, b, sol in segments if a <= middle < b)(t)

    for a, b in pairwise(kinks):
        middle = (a + b) / 2
        sol = solve_ivp(
            lambda t, y, m=middle: slope(t, y, before(t - tau, m - tau), m), (a, b), x, method="DOP853", rtol=3e-14,
            atol=1e-15, max_step=(b - a) / 24, dense_output=True,
        )  # fmt: skip
        segments.append((a, b, sol.sol))
        x = sol.y[:, -1]
        found.update({t: sol.sol(t) for t in probes if a <= t <= b})
    return np.array([found[t] for t in probes]).T


def test_a_saturated_yaw_loop_agrees_with_segments_of_dop853():
    end, strength = 0.1, 8000.0
    p = np.array([KP, KD, DAMPING, LIMIT])
    pulse = piecewise_polynomial([0.0, PULSE, end], [[[strength]], [[0.0]]])
    probes = np.linspace(0.0003, 0.0997, 71)
    kinks = sorted({0.0, end, *(k * T for k in range(8)), *(PULSE + k * T for k in range(8))} - {0.0 + 8 * T})
    kinks = [k for k in kinks if k <= end]

    def slope(t, x, old, middle):
        w = KP * old[0] + KD * old[1]
        push = strength if middle < PULSE else 0.0
        return [x[1], -DAMPING * x[1] - LIMIT * np.tanh(w / LIMIT) + push]

    exact = by_segments(slope, lambda _: np.zeros(2), T, kinks, [0.0, 0.0], probes)
    ours = nonlinear_response(saturated, demand, [T], end, [0.0, 0.0], inputs=pulse, parameters=p)
    for got, wanted in zip(ours(probes), exact, strict=True):
        np.testing.assert_allclose(got, wanted, atol=1e-9 * np.abs(wanted).max())


def test_a_loop_far_from_saturation_is_the_linear_one():
    p = np.array([KP, KD, DAMPING, 1e9])
    pulse = piecewise_polynomial([0.0, PULSE, 0.1], [[[1.0]], [[0.0]]])
    t = np.linspace(0.0, 0.1, 201)
    ours = nonlinear_response(saturated, demand, [T], 0.1, [0.0, 0.0], inputs=pulse, parameters=p, atol=1e-16)
    linear = forced_response(pd_closed(DAMPING, KP, KD, T), t, pulse).outputs
    np.testing.assert_allclose(ours(t)[0], linear, atol=1e-10 * np.abs(linear).max())


@pytest.mark.parametrize("k", [1.0, 2.0])
def test_delayed_growth_agrees_with_segments_of_dop853(k):
    kinks = np.arange(0.0, 13.0)
    probes = np.linspace(0.05, 11.95, 60)
    exact = by_segments(lambda t, x, old, m: -k * old * (1 + x), lambda _: np.array([0.3]), 1.0, kinks, [0.3], probes)
    ours = nonlinear_response(growth, itself, [1.0], 12.0, [0.3], parameters=[k])
    np.testing.assert_allclose(ours(probes), exact, atol=1e-9)


def test_mackey_glass_after_a_wave_agrees_with_segments_of_dop853():
    tau, end = 17.0, 68.0
    probes = np.linspace(0.5, 67.5, 60)

    def past(t):
        return np.array([0.5 + 0.2 * np.cos(t)])

    exact = by_segments(
        lambda t, x, old, m: 0.2 * old / (1 + old**10) - 0.1 * x,
        past,
        tau,
        np.arange(0.0, end + 1, tau),
        past(0),
        probes,
    )
    ours = nonlinear_response(mackey_glass, itself, [tau], end, past(0.0), history=past)
    np.testing.assert_allclose(ours(probes), exact, atol=1e-9)


def test_a_tighter_tolerance_brings_a_smaller_error():
    def error(rtol):
        ours = nonlinear_response(growth, itself, [1.0], 8.0, [0.3], parameters=[2.0], rtol=rtol, atol=rtol)
        return np.abs(ours([7.9])[0, 0] - fine), len(ours.starts)

    fine = nonlinear_response(growth, itself, [1.0], 8.0, [0.3], parameters=[2.0], rtol=1e-13, atol=1e-15)([7.9])[0, 0]
    assert error(1e-4)[0] < 1e-4
    assert error(1e-9)[0] < 1e-9
    assert error(1e-4)[1] <= error(1e-9)[1]


@numba.njit
def escaping(t, x, w, u, p):
    return x * x


def test_impossible_experiments_are_refused_in_a_sentence():
    with pytest.raises(InvalidParameterError, match="compiled by numba"):
        nonlinear_response(lambda t, x, w, u, p: x, itself, [1.0], 1.0, [0.0])
    with pytest.raises(InvalidParameterError, match="Delays must be > 0 s"):
        nonlinear_response(growth, itself, [-1.0], 1.0, [0.0], parameters=[1.0])
    with pytest.raises(InvalidParameterError, match=r"cannot be followed beyond 1\b|beyond 0.99"):
        nonlinear_response(escaping, itself, [1.0], 2.0, [1.0])
    with pytest.raises(InvalidParameterError, match="Inputs must cover"):
        nonlinear_response(growth, itself, [1.0], 2.0, [1.0], inputs=sampled([0.0, 1.0], [1.0, 1.0]), parameters=[1.0])
    with pytest.raises(InvalidParameterError, match=r"shape \(2,\), one a delay"):
        nonlinear_response(growth, itself, [1.0, 2.0], 2.0, [1.0], parameters=[1.0])


@numba.njit
def twice_as_many(t, x, w, u, p):
    return np.zeros(2)


@numba.njit
def bare_number(t, x, w, u, p):
    return x[0]


@numba.njit
def whole_numbers(t, x, w, u, p):
    return np.array([1])


@numba.njit
def timeless(x, w, u, p):
    return x


@numba.njit
def third_parameter(t, x, w, u, p):
    return np.array([-p[2] * x[0]])


@numba.njit
def driven(t, x, w, u, p):
    return np.array([u[0] - x[0]])


@numba.njit
def out_of_its_domain(t, x, w, u, p):
    return np.array([math.sqrt(-1.0 - x[0])])


ILL_FITTING = [
    (third_parameter, r"`{}` reads outside .*there are 1 in x, 1 in w, 0 in u, 1 in p"),
    (driven, r"`{}` reads outside .*0 in u"),
    (twice_as_many, r"`{}` must return a float64 array of shape \(1,\), one a \w+, got float64 of shape \(2,\)"),
    (bare_number, r"`{}` must return a float64 array of shape \(1,\), one a \w+, got float64"),
    (whole_numbers, r"`{}` must return a float64 array of shape \(1,\), one a \w+, got int64"),
    (timeless, r"`{}` must take five arguments \(t, x, w, u, p\), got a function of 4"),
    (out_of_its_domain, r"`{}` fails at the start, at t = 0 with x = \[0\.5\]: ValueError"),
]


@pytest.mark.parametrize(("function", "sentence"), ILL_FITTING)
def test_right_hand_sides_that_do_not_fit_are_refused_before_anything_compiled_runs(function, sentence):
    with pytest.raises(InvalidParameterError, match=sentence.format("slope")):
        nonlinear_response(function, itself, [1.0], 1.0, [0.5], parameters=[1.0])
    with pytest.raises(InvalidParameterError, match=sentence.format("delayed")):
        nonlinear_response(growth, function, [1.0], 1.0, [0.5], parameters=[1.0])


@numba.njit
def now_and_then_another_type(t, x, w, u, p):
    return x if t < 1.0 else np.zeros((1, 1))


def test_what_numba_cannot_compile_is_refused_in_a_sentence():
    with pytest.raises(InvalidParameterError, match=r"must return a float64 array .*Numba says: \w+"):
        nonlinear_response(now_and_then_another_type, itself, [1.0], 1.0, [0.5])


def test_callbacks_compiled_ahead_give_the_same_response():
    vector = numba.float64[::1]
    callback = numba.cfunc(vector(numba.float64, vector, vector, vector, vector))
    ahead, behind = callback(growth.py_func), callback(itself.py_func)
    t = np.linspace(0.0, 3.0, 31)
    found = nonlinear_response(ahead, behind, [1.0], 3.0, [0.3], parameters=[1.0])(t)
    assert (found == nonlinear_response(growth, itself, [1.0], 3.0, [0.3], parameters=[1.0])(t)).all()
