"""JiTCDDE on one recovery: the loop's constants compiled in, only the torque left as a parameter.

Two uses. As documented: integrate() to every sample with adaptive steps, jump() of width 1e-14 s at the pulse's end so
that the derivative starts afresh there. Tuned: the compiled integrator driven step by step, equal steps between all
breakpoints that the pulse and the delay leave, samples from its own Hermite polynomials; this goes round
integrate_blindly() and is faster than it. The past ends with the derivative that the equation asks for, so that
there is no discontinuity to step on at t = 0.
"""

import os
import warnings

import numpy as np
import stopwatch
import symengine
from jitcdde import jitcdde, t, y

WIDTH = 1e-14  # of a jump of the torque [s]; wider ones show in the angle at 1e-9 deg
REST = np.zeros(2)


def compiled(problem):
    b, kp, kd, T = (problem["loop"][name] for name in ("b", "kp", "kd", "T"))
    torque = symengine.Symbol("torque")
    right_hand_side = [y(1), -b * y(1) - kp * y(0, t - T) - kd * y(1, t - T) + torque]
    dde = jitcdde(right_hand_side, control_pars=[torque], max_delay=T, verbose=False)
    dde.compile_C()
    return dde


def start(dde, problem):
    a = problem["acceleration"]
    dde.purge_past()
    dde.add_past_points(
        [(-2 * problem["loop"]["T"], REST, REST), (-WIDTH, REST, REST), (0.0, REST, np.array([0.0, a]))]
    )
    dde.set_parameters(a)
    dde.initial_discontinuities_handled = True


def release(dde, at):
    dde.set_parameters(0.0)
    dde.jump(0, at, WIDTH)


def documented(dde, problem, tolerance):
    times, pulse = problem["times"], problem["pulse"]
    start(dde, problem)
    dde.set_integration_parameters(rtol=tolerance, atol=tolerance * 0.3, first_step=pulse / 2, max_step=pulse)
    angles = np.zeros(len(times))
    pushed = True
    for k, time_k in enumerate(times[1:], 1):
        if pushed and time_k >= pulse:
            dde.integrate(pulse)
            release(dde, pulse)
            pushed = False
        angles[k] = dde.integrate(time_k)[0]
    return angles


def breakpoints(problem):
    T, pulse, end = problem["loop"]["T"], problem["pulse"], problem["end"]
    periods = range(int(end / T) + 1)
    kinks = sorted([k * T for k in periods] + [k * T + pulse for k in periods])
    return [kink for kink in kinks[1:] if kink < end - 1e-9] + [end]


def tuned_few(dde, problem, kinks, per_pulse, times):
    """For fewer steps than samples: collect states, evaluate all samples at once."""
    start(dde, problem)
    core, pulse = dde.DDE, problem["pulse"]
    step, accept, state = core.get_next_step, core.accept_step, core.get_current_state
    grid, states, now = [0.0], [REST], 0.0
    for i, kink in enumerate(kinks):
        count = max(1, round(per_pulse * (kink - now) / pulse))
        h = (kink - now) / count
        for k in range(1, count + 1):
            step(h)
            accept()
            grid.append(now + k * h)
            states.append(state().copy())
        now = kink
        if i == 0:
            release(dde, now)
    return hermite(np.array(grid), np.array(states), times)


def hermite(grid, states, times):
    left = np.clip(np.searchsorted(grid, times, side="right") - 1, 0, len(grid) - 2)
    q = np.diff(grid)
    x = (times - grid[left]) / q[left]
    psi, rate = states[:, 0], states[:, 1]
    fall, b, d, c = (psi[:-1] - psi[1:])[left], (rate[:-1] * q)[left], (rate[1:] * q)[left], psi[1:][left]
    return (1 - x) * ((1 - x) * (b * x + fall * (2 * x + 1)) - d * x * x) + c


def tuned_many(dde, problem, kinks, per_pulse):
    """For more steps than samples: read each sample off the step that has just passed it."""
    start(dde, problem)
    core, pulse, times = dde.DDE, problem["pulse"], problem["times"]
    step, accept, state_at, forget, T = (
        core.get_next_step, core.accept_step, core.get_recent_state, core.forget, problem["loop"]["T"],
    )  # fmt: skip
    angles, k, now, samples = [], 0, 0.0, [*times, float("inf")]
    for i, kink in enumerate(kinks):
        count = max(1, round(per_pulse * (kink - now) / pulse))
        h = (kink - now) / count
        for j in range(1, count + 1):
            step(h)
            accept()
            reached = now + j * h
            while samples[k] <= reached:
                angles.append(state_at(samples[k])[0])
                k += 1
        forget(T)
        now = kink
        if i == 0:
            release(dde, now)
    angles += [state_at(late)[0] for late in times[k:]]  # an end that rounding put beyond the last step
    return angles


def measure(problem):
    warnings.simplefilter("ignore", UserWarning)  # integrate() to a sample that its last step has passed already
    began = sum(os.times()[:4])  # the compiler's time too
    dde = compiled(problem)
    compile_s = sum(os.times()[:4]) - began
    kinks, times = breakpoints(problem), np.array(problem["times"])

    def row(use, setting, solve, *extra):
        angles = solve(dde, problem, *extra)
        error = stopwatch.angle_error(problem, angles)
        timing = stopwatch.timed(lambda: solve(dde, problem, *extra))
        return {"use": use, "setting": setting, "setup_s": compile_s, "error": error, **timing}

    for exponent in range(2, 12):
        yield row("as documented", f"rtol 1e-{exponent}", documented, 10.0**-exponent)
    for n in (1, 2, 3, 4, 6, 8, 12, 16, 24):
        yield row("tuned", f"{n} steps a pulse", tuned_few, kinks, n, times)
    for n in (16, 24, 32, 48, 64, 96, 128, 192, 256, 384, 512):
        yield row("tuned", f"{n} steps a pulse", tuned_many, kinks, n)


if __name__ == "__main__":
    stopwatch.main("jitcdde", measure)
