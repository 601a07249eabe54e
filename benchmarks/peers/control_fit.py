"""python-control and scipy.optimize.curve_fit: kp, kd and the delay of one recording, a Padé approximant in the loop.

Padé-4 in seconds, as most would write it, and higher orders with time in units of the delay; the pulse's end off the
grid, as in `control_response`.
"""

import numpy as np
import stopwatch
from control_response import closed_loop, in_segments
from scipy.optimize import curve_fit


def fit(problem, order, in_delays):
    measured = np.array(problem["yaw"])

    def predicted(_, kp, kd, T):
        loop, unit = {"b": problem["b"], "kp": kp, "kd": kd, "T": T}, T if in_delays else 1.0
        return in_segments(closed_loop(loop, order, unit), problem, unit)

    return curve_fit(predicted, np.array(problem["times"]), measured, p0=problem["start"])[0]


def measure(problem):
    cases = [("Padé-4", 4, False), *[("any order, time in delays", order, True) for order in (4, 6, 8, 10, 12)]]
    for use, order, in_delays in cases:
        error = stopwatch.estimate_error(problem, fit(problem, order, in_delays))
        timing = stopwatch.timed(lambda order=order, in_delays=in_delays: fit(problem, order, in_delays), fewest=5)
        yield {"use": use, "setting": f"Padé-{order}", "setup_s": 0.0, "error": error, **timing}


if __name__ == "__main__":
    stopwatch.main("control", measure)
