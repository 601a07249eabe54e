from collections.abc import Callable
from dataclasses import replace

import mpmath
import numpy as np
import pytest
from pd_loop import pd_closed
from random_systems import random_system

from flycontrol.delay.interconnect import delay
from flycontrol.delay.piecewise import piecewise_polynomial, sampled
from flycontrol.delay.response_sensitivity import BlockDerivatives, delay_derivatives, response_sensitivity
from flycontrol.delay.system import DelayLTI, delay_lti
from flycontrol.delay.timeresponse import forced_response, initial_response
from flycontrol.errors import InvalidParameterError

BLOCKS = ("A", "B1", "B2", "C1", "C2", "D11", "D12", "D21", "D22", "tau")


def richardson(value: Callable[[float], np.ndarray], step: float) -> np.ndarray:
    """Central difference with an error of order step^6."""
    first, second, third = ((value(h) - value(-h)) / (2 * h) for h in (step, step / 2, step / 4))
    one, other = (4 * second - first) / 3, (4 * third - second) / 3
    return (16 * other - one) / 15


def hand_steps(k, T, t):
    """x' = -k x(t - T), x = 1 in the past: sum_j (-k)^j (t - (j - 1) T)^j / j!."""
    return mpmath.nsum(
        lambda j: (-k) ** j * (t - (j - 1) * T) ** j / mpmath.factorial(j) if t > (j - 1) * T else mpmath.mpf(0),
        [0, 12],
    )


def test_derivatives_of_the_delayed_integrator_are_those_of_its_polynomials():
    k, T = 1.3, 0.73
    loop = delay_lti(A=[[0.0]], B1=[[1.0]], B2=[[-k]], C1=[[1.0]], C2=[[1.0]], tau=[T])
    still = sampled([0.0, 5.0], [0.0, 0.0])
    found = response_sensitivity(loop, [BlockDerivatives(B2=[[-1.0]]), *delay_derivatives(loop)], still, [1.0])
    times = [0.4, 1.0, 2.0, 3.1, 4.7]
    with mpmath.workdps(40):
        exact = [
            [float(mpmath.diff(lambda a, t=t: hand_steps(a, mpmath.mpf(T), t), k)) for t in times],
            [float(mpmath.diff(lambda a, t=t: hand_steps(mpmath.mpf(k), a, t), T)) for t in times],
        ]
    np.testing.assert_allclose(found(times)[:, 0], exact, atol=1e-11)


def test_the_yaw_loop_moves_with_its_gains_and_its_delay_as_differences_say():
    b, gains, end = 69.0, np.array([3050.0, 45.0, 3 / 220]), 0.1
    pulse = piecewise_polynomial([0.0, 1 / 220, end], [[[1.0]], [[0.0]]])
    t = np.linspace(0.001, 0.0999, 83)

    def yaw(at):
        return forced_response(pd_closed(b, *at), np.append(0.0, end), pulse).exact[0](t)[0]

    loop = pd_closed(b, *gains)
    parameters = [BlockDerivatives(C2=[[1.0, 0.0]]), BlockDerivatives(C2=[[0.0, 1.0]]), BlockDerivatives(tau=[1.0])]
    found = response_sensitivity(loop, parameters, pulse)(t)[:, 0]
    for i, ours in enumerate(found):
        unit = np.eye(3)[i] * gains
        # a difference across a kink that moves says nothing: samples keep clear of the breakpoints
        exact = richardson(lambda h, unit=unit: yaw(gains + h * unit), 2e-3) / gains[i]
        clear = np.abs(t[:, None] - (np.arange(1, 9) * gains[2])[None] + 1e-12).min(axis=1) > 3e-4
        clear &= np.abs(t[:, None] - (1 / 220 + np.arange(1, 9) * gains[2])[None]).min(axis=1) > 3e-4
        scale = np.abs(ours).max()
        np.testing.assert_allclose(ours[clear], exact[clear], atol=1e-8 * scale)


@pytest.mark.parametrize("chained", [False, True])
@pytest.mark.parametrize("name", BLOCKS)
def test_each_block_of_a_random_system_moves_the_response_as_differences_say(name, chained):
    system = random_system(11, 3, 2, inputs=2, outputs=2, chained=chained)
    rng = np.random.default_rng(5)
    direction = rng.normal(size=getattr(system, name).shape)
    if name == "D22":
        direction = np.triu(direction, 1)
    if name == "tau":
        direction = direction * 0.05
    inputs = piecewise_polynomial([0.0, 0.317, 2.0], rng.normal(size=(2, 2, 3)))
    x0 = rng.normal(size=3)
    t = _clear_of_kinks(system, np.linspace(0.02, 1.98, 60), [0.0, 0.317])

    def at(h: float) -> np.ndarray:
        moved: DelayLTI = replace(system, **{name: getattr(system, name) + h * direction})
        return forced_response(moved, 2.0, inputs, x0).exact[0](t)

    ours = response_sensitivity(system, [BlockDerivatives(**{name: direction})], inputs, x0)(t)[0]
    exact = richardson(at, 2e-2)
    np.testing.assert_allclose(ours, exact, atol=2e-9 * (1 + np.abs(exact).max()))


def _clear_of_kinks(system, t, edges):
    images = set(edges)
    for _ in range(8):
        images |= {e + float(d) for e in images for d in system.tau if e + d < t[-1] + 0.1}
    return t[np.abs(t[:, None] - np.array(sorted(images))[None]).min(axis=1) > 0.006]


def test_moving_an_input_delay_moves_the_response_backwards():
    """y(t) = g(t - T) for t > T, so dy/dT = -g'(t - T); g = 1 - exp(-t), hence a jump of the derivative at T."""
    system = delay_lti(A=[[-1.0]], B1=[[0.0]], B2=[[1.0]], C1=[[1.0]], C2=[[0.0]], D21=[[1.0]], tau=[0.4])
    t = np.linspace(0.0, 2.0, 41)
    found = response_sensitivity(system, delay_derivatives(system), sampled([0.0, 2.0], [1.0, 1.0]))(t)[0, 0]
    np.testing.assert_allclose(found, np.where(t >= 0.4 - 1e-12, -np.exp(0.4 - t), 0.0), atol=1e-13)


def test_moving_one_of_two_delays_in_a_chain_moves_as_their_sum():
    chain = delay(0.3) * delay_lti(A=[[-1.0]], B1=[[0.0]], B2=[[1.0]], C1=[[1.0]], C2=[[0.0]], D21=[[1.0]], tau=[0.2])
    t = np.linspace(0.01, 1.99, 37)
    both = response_sensitivity(chain, delay_derivatives(chain), sampled([0.0, 2.0], [1.0, 1.0]))(t)[:, 0]
    exact = np.where(t > 0.5, -np.exp(0.5 - t), 0.0)
    np.testing.assert_allclose(both, [exact, exact], atol=1e-12)


def test_with_a_history_the_derivative_is_that_of_the_sine_it_follows():
    # x' = -k x(t - T) after sin(pi t / 2): on 0 < t < T, x = k (2/pi) (cos(pi (t - T)/2) - cos(pi T/2))
    k, T, a = np.pi / 2, 1.0, np.pi / 2
    loop = delay_lti(A=[[0.0]], B1=[[1.0]], B2=[[1.0]], C1=[[1.0]], C2=[[-k]], tau=[T])
    parameters = [BlockDerivatives(C2=[[-1.0]]), *delay_derivatives(loop)]
    still = sampled([0.0, 1.0], [0.0, 0.0])
    t = np.linspace(0.0, 0.99, 34)
    found = response_sensitivity(loop, parameters, still, history=lambda s: [np.sin(a * s)])(t)[:, 0]
    by_gain = (np.cos(a * (t - T)) - np.cos(a * T)) / a
    by_delay = k * (np.sin(a * (t - T)) + np.sin(a * T))
    np.testing.assert_allclose(found, [by_gain, by_delay], atol=1e-11)


def test_the_initial_state_is_a_parameter_too():
    system = random_system(4, 2, 2)
    still = sampled([0.0, 2.0], [0.0, 0.0])
    t = np.linspace(0.0, 2.0, 21)
    ours = response_sensitivity(system, [BlockDerivatives(initial_state=[1.0, -2.0])], still, [0.3, 0.1])(t)[0]
    np.testing.assert_allclose(ours, initial_response(system, 2.0, [1.0, -2.0]).exact[0](t), atol=1e-12)


def test_derivatives_that_do_not_fit_are_refused_in_a_sentence():
    system = random_system(4, 2, 2, chained=True)
    still = sampled([0.0, 2.0], [0.0, 0.0])
    with pytest.raises(InvalidParameterError, match=r"BlockDerivatives.A must be finite with shape \(2, 2\)"):
        response_sensitivity(system, [BlockDerivatives(A=[1.0])], still)
    with pytest.raises(InvalidParameterError, match="constant past"):
        response_sensitivity(system, [], still, history=lambda _: [1.0, 1.0])
