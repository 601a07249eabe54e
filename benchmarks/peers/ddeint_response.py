"""ddeint on one recovery: its grid is the samples with the pulse's end added, the coarsest that it can be asked for."""

import numpy as np
import stopwatch
from ddeint import ddeint


def solve(problem, grid, asked):
    b, kp, kd, T = (problem["loop"][name] for name in ("b", "kp", "kd", "T"))
    a, pulse = problem["acceleration"], problem["pulse"]
    rest = np.zeros(2)

    def rate(state, t):
        now, past = state(t), state(t - T)
        return np.array([now[1], (a if t < pulse else 0.0) - b * now[1] - kp * past[0] - kd * past[1]])

    return ddeint(rate, lambda t: rest, grid)[asked, 0]


def measure(problem):
    times = np.array(problem["times"])
    grid = np.union1d(times, [problem["pulse"]])
    asked = np.searchsorted(grid, times)
    error = stopwatch.angle_error(problem, solve(problem, grid, asked))
    timing = stopwatch.timed(lambda: solve(problem, grid, asked))
    yield {"use": "as documented", "setting": "samples and pulse end", "setup_s": 0.0, "error": error, **timing}


if __name__ == "__main__":
    stopwatch.main("ddeint", measure)
