"""Derivatives of a trial against complex steps, and against the Jacobians of the loop that CasADi knows."""

import casadi as ca
import complex_steps
import numpy as np
import pytest
from numpy.polynomial import chebyshev

from flycontrol.identify.gains.kernels import march as kernels
from flycontrol.identify.gains.response import NAMES, drive_of, parameter_vector, span_of, yaw_response
from flycontrol.model.symbolic import right_hand_side
from flycontrol.model.trial import Pulse
from flycontrol.model.yaw import yaw_system

TRUTH = {"kp": 3050.0, "kd": 45.0, "delay": 0.0136, "damping": 69.0, "impulse": 35.0}
TURNING = {"initial_yaw": 0.1, "initial_rate": 3.0, "heading": 0.2, "ki": 5e4}
PULSE = Pulse(onset=0.0103, duration=0.00457)
TIMES = np.sort(np.random.default_rng(0).uniform(0.0, 0.1, 400))


@pytest.mark.parametrize(
    ("further", "tolerance"),
    [
        ({}, 1e-13),
        (TURNING, 1e-13),
        ({"kp": 20000.0, "kd": 90.0}, 1e-13),  # unstable
        ({"limit": 900.0}, 2e-9),  # so well panels as long as the delay resolve tanh
        (TURNING | {"limit": 700.0, "delay": 0.0021}, 1e-11),
    ],
)
def test_every_derivative_is_that_of_complex_steps(further, tolerance):
    values = TRUTH | further
    names = [name for name in NAMES if name != "paddling_gain" and (name != "limit" or name in values)]
    found = yaw_response(values, TIMES, PULSE, derivatives=names, torque=True)
    answers = complex_steps.response(values, TIMES, PULSE)
    for mine, exact in zip((found.yaw, found.fly), answers, strict=True):
        np.testing.assert_allclose(mine, exact.real, rtol=0, atol=tolerance * np.abs(exact).max())
    for name, *slopes in zip(names, found.by_parameter, found.fly_by_parameter, strict=True):
        for mine, exact in zip(slopes, complex_steps.derivative_by(name, values, TIMES, PULSE), strict=True):
            size = np.abs(exact).max()
            np.testing.assert_allclose(mine, exact, rtol=0, atol=10 * tolerance * size, err_msg=name)


class Panels:
    """psi and its derivatives by the parameters as the kernel's series, with two derivatives in time."""

    def __init__(self, values, active):
        drive = drive_of(PULSE)
        p = parameter_vector(values)
        self.start, self.end = span_of(TIMES, drive)
        pieces = drive.majors, drive.minors, drive.pieces
        self.edges, self.series, _ = kernels.march(p, active, self.start, self.end, *pieces, False, kernels.RULE)

    def __call__(self, t):
        """(3, 1 + m): values, first and second derivatives at t."""
        if t < self.start:
            return np.zeros((3, self.series.shape[1]))
        k = min(np.searchsorted(self.edges, t, side="right") - 1, len(self.series) - 1)
        half = (self.edges[k + 1] - self.edges[k]) / 2
        x, c = (t - self.edges[k]) / half - 1, self.series[k].T
        return np.array([chebyshev.chebval(x, chebyshev.chebder(c, d, scl=1 / half)) for d in (0, 1, 2)])


@pytest.fixture(scope="module")
def symbolic():
    """The loop with saturated paddling: f, h and their Jacobians by CasADi at (x, w, u, p)."""
    system = yaw_system(saturated=True)
    evaluated = right_hand_side(system)
    arguments = [system.states, system.delayed, system.inputs, system.parameters]
    f, h = system.derivative[1], system.delayed_signals
    slopes = [ca.jacobian(row, column) for row in (f, h) for column in arguments]
    return evaluated, ca.Function("slopes", arguments, [ca.densify(slope) for slope in slopes])


@pytest.mark.parametrize(("limit", "tolerance"), [(900.0, 1e-7), (1e12, 1e-10)])
def test_the_kernel_solves_casadis_equation_and_its_variations(symbolic, limit, tolerance):
    """psi'' = f(x, w, u, p); s'' = f_x s + f_w (h_x s(t - T) + h_p - h_x x'(t - T) dT) + f_p by CasADi's Jacobians."""
    evaluated, slopes = symbolic
    asked = ["damping", "kp", "kd", "delay", "limit"]  # beta, K_P, K_D, T, N_max for an inertia of one
    felt = slice(None) if limit < 1e6 else slice(-1)  # far from saturation the last of them leaves no trace
    active = np.array([NAMES.index(name) for name in asked], dtype=np.int64)
    panels = Panels(TRUTH | {"limit": limit}, active)
    p = [1.0, *(TRUTH[name] for name in asked[:-1]), limit]
    found, expected = [], []
    for t in TIMES[::4]:
        now, then = panels(t), panels(t - TRUTH["delay"])
        push = TRUTH["impulse"] / PULSE.duration * (PULSE.onset <= t < PULSE.onset + PULSE.duration)
        w = float(evaluated(then[:2, 0], 0, 0, p)[2])
        x = now[:2, 0]
        f_x, f_w, _, f_p, *_ = (np.array(block) for block in slopes(x, w, push, p))
        h_x, _, _, h_p = (np.array(block) for block in slopes(then[:2, 0], 0, 0, p)[4:])
        moved = (h_x @ then[:2, 1:]).ravel() + h_p.ravel()[1:]
        moved[3] -= (h_x @ then[1:, 0]).item()
        found.append(now[2])
        expected.append(
            [float(evaluated(x, w, push, p)[0][1]), *(f_x @ now[:2, 1:] + f_w * moved + f_p[:, 1:]).ravel()]
        )
    found, expected = np.array(found), np.array(expected)
    error, size = np.abs(found - expected).max(axis=0), np.abs(expected).max(axis=0)
    assert (error[felt] < tolerance * size[felt]).all()
