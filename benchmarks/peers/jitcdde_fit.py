"""JiTCDDE and scipy.optimize.least_squares: kp, kd and the delay of one recording, compiled once for all of them.

Two uses. As documented: integrate() to every sample with adaptive steps. Tuned: the compiled integrator driven step by
step, equal steps between all breakpoints that the pulse and the delay leave, samples from its own Hermite polynomials;
so its answer is smooth in the delay. Both get the step of their difference quotients told: with least_squares' own one
(1.5e-8) the adaptive steps' rounding drowns the derivative.
"""

import time
import warnings
from itertools import product

import numpy as np
import stopwatch
import symengine
from jitcdde import jitcdde, t, y
from jitcdde_response import REST, WIDTH, hermite
from scipy.optimize import least_squares

LONGEST = 0.03  # [s]


def compiled(problem):
    kp, kd, T, torque = (symengine.Symbol(name) for name in ("kp", "kd", "T", "torque"))
    right_hand_side = [y(1), -problem["b"] * y(1) - kp * y(0, t - T) - kd * y(1, t - T) + torque]
    dde = jitcdde(
        right_hand_side, control_pars=[kp, kd, T, torque], delays=[0, T], max_delay=LONGEST, verbose=False
    )  # fmt: skip
    dde.compile_C()
    return dde


def start(dde, x, problem):
    a = problem["acceleration"]
    dde.purge_past()
    dde.add_past_points([(-2 * LONGEST, REST, REST), (-WIDTH, REST, REST), (0.0, REST, np.array([0.0, a]))])
    dde.set_parameters(*x, a)
    dde.initial_discontinuities_handled = True


def documented(x, dde, problem, tolerance):
    times, pulse = problem["times"], problem["pulse"]
    start(dde, x, problem)
    dde.set_integration_parameters(rtol=tolerance, atol=tolerance * 0.3, first_step=pulse / 2, max_step=pulse)
    angles, pushed = np.zeros(len(times)), True
    for k, time_k in enumerate(times[1:], 1):
        if pushed and time_k >= pulse:
            dde.integrate(pulse)
            dde.set_parameters(*x, 0.0)
            dde.jump(0, pulse, WIDTH)
            pushed = False
        angles[k] = dde.integrate(time_k)[0]
    return angles


def tuned(x, dde, problem, times, per_pulse):
    start(dde, x, problem)
    T, pulse, end = x[2], problem["pulse"], times[-1]
    periods = range(int(end / T) + 1)
    kinks = sorted(k for k in [*(k * T for k in periods), *(k * T + pulse for k in periods)] if 0 < k < end - 1e-9)
    core = dde.DDE
    step, accept, state = core.get_next_step, core.accept_step, core.get_current_state
    grid, states, now = [0.0], [REST], 0.0
    for kink in [*kinks, end]:
        count = max(1, round(per_pulse * (kink - now) / pulse))
        h = (kink - now) / count
        for k in range(1, count + 1):
            step(h)
            accept()
            grid.append(now + k * h)
            states.append(state().copy())
        now = kink
        if kink == pulse:
            dde.set_parameters(*x, 0.0)
            dde.jump(0, kink, WIDTH)
    return hermite(np.array(grid), np.array(states), times)


def fit(solve, problem, difference, *setting):
    measured = np.array(problem["yaw"])
    return least_squares(
        lambda x: solve(x, *setting) - measured, problem["start"], x_scale=problem["start"], diff_step=difference,
        bounds=([0, 0, 0.002], [2e4, 400, 0.9 * LONGEST]),
    ).x  # fmt: skip


def measure(problem):
    warnings.simplefilter("ignore", UserWarning)  # integrate() to a sample that its last step has passed already
    began = time.perf_counter()
    dde = compiled(problem)
    compile_s = time.perf_counter() - began
    times = np.array(problem["times"])

    def row(use, setting, difference, solve, *extra):
        call = (solve, problem, difference, dde, problem, *extra)
        error = stopwatch.estimate_error(problem, fit(*call))
        timing = stopwatch.timed(lambda: fit(*call), fewest=5)
        setting = f"{setting}, differences {difference:g}"
        return {"use": use, "setting": setting, "setup_s": compile_s, "error": error, **timing}

    for exponent, difference in product((3, 4, 5, 6, 8), (1e-2, 1e-3, 1e-4)):
        yield row("as documented", f"rtol 1e-{exponent}", difference, documented, 10.0**-exponent)
    for n in (1, 2, 4, 8):
        yield row("tuned", f"{n} steps a pulse", 1e-6, tuned, times, n)


if __name__ == "__main__":
    stopwatch.main("jitcdde", measure)
