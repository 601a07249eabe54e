"""SciPy's method of steps on one recovery: solve_ivp from breakpoint to breakpoint.

Dense output: the past is read from the dense output of the segment one delay earlier. Stacked: all delay intervals so
far run side by side in local time as one larger system without delay, so that no interpolant is called while stepping.
"""

from itertools import pairwise

import numpy as np
import stopwatch
from scipy.integrate import solve_ivp

SCALE = np.array([0.3, 30.0])  # of psi [rad] and psi' [rad/s], for the absolute tolerances


def dense_output(problem, kinks, times, method, rtol):
    b, kp, kd, T = (problem["loop"][name] for name in ("b", "kp", "kd", "T"))
    solutions, x, angles = [], np.zeros(2), np.empty(len(times))
    for i, (left, right) in enumerate(pairwise(kinks)):
        torque = problem["acceleration"] if i == 0 else 0.0
        past = solutions[i - 2] if i >= 2 else None

        def rate(t, x, torque=torque, past=past):
            if past is None:
                return x[1], torque - b * x[1]
            psi, psi_rate = past(t - T).tolist()
            return x[1], torque - b * x[1] - kp * psi - kd * psi_rate

        part = solve_ivp(
            rate, (left, right), x, method, rtol=rtol, atol=rtol * SCALE, dense_output=True, first_step=right - left
        )
        one_step = len(part.sol.interpolants) == 1
        solutions.append(part.sol.interpolants[0] if one_step else part.sol)  # spares OdeSolution's search
        x = part.y[:, -1]
        here = slice(*np.searchsorted(times, (left, right)))
        angles[here] = part.sol(times[here])[0]
    angles[times >= kinks[-1]] = x[0]
    return angles


def stacked(problem, kinks, times, method, rtol):
    b, kp, kd, T = (problem["loop"][name] for name in ("b", "kp", "kd", "T"))
    intervals = (len(kinks) + 1) // 2
    whole = np.kron(np.eye(intervals), [[0, 1], [0, -b]]) + np.kron(np.eye(intervals, k=-1), [[0, 0], [-kp, -kd]])
    initial, angles, x = np.zeros(2 * intervals), np.empty(len(times)), np.zeros(2)
    for k in range(intervals):
        n = 2 * (k + 1)
        initial[n - 2 : n] = x
        state, matrix = initial[:n], whole[:n, :n]
        for i in (2 * k, 2 * k + 1):
            if i + 1 >= len(kinks):
                break
            push = np.zeros(n)
            push[1] = problem["acceleration"] if i % 2 == 0 else 0.0
            span = (kinks[i] - k * T, kinks[i + 1] - k * T)
            part = solve_ivp(
                lambda t, y, matrix=matrix, push=push: matrix @ y + push, span, state, method, rtol=rtol,
                atol=rtol * np.tile(SCALE, k + 1), dense_output=True, first_step=span[1] - span[0],
            )  # fmt: skip
            state = part.y[:, -1]
            here = slice(*np.searchsorted(times, (kinks[i], kinks[i + 1])))
            angles[here] = part.sol(times[here] - k * T)[n - 2]
        x = state[-2:]
    angles[times >= kinks[-1]] = x[0]
    return angles


def measure(problem):
    T, pulse, end = problem["loop"]["T"], problem["pulse"], problem["end"]
    times = np.array(problem["times"])
    periods = range(int(end / T) + 1)
    kinks = sorted([k * T for k in periods] + [k * T + pulse for k in periods])
    kinks = [kink for kink in kinks if kink < end - 1e-9] + [end]
    for method, tolerances in (("RK45", (1e-3, 1e-6, 1e-8)), ("DOP853", (1e-3, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12))):
        for solve in (dense_output, stacked):
            for rtol in tolerances:
                call = (problem, kinks, times, method, rtol)
                error = stopwatch.angle_error(problem, solve(*call))
                timing = stopwatch.timed(lambda solve=solve, call=call: solve(*call))
                use = solve.__name__.replace("_", " ")
                yield {"use": use, "setting": f"{method}, rtol {rtol:g}", "setup_s": 0.0, "error": error, **timing}


if __name__ == "__main__":
    stopwatch.main("scipy", measure)
