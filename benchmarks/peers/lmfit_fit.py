"""lmfit around ddeint, defaults throughout: kp, kd and the delay of one recording. Run once, since it takes seconds."""

import time

import lmfit
import numpy as np
import stopwatch
from ddeint_response import solve


def residuals(parameters, problem, grid, asked):
    problem["loop"] = {"b": problem["b"]} | parameters.valuesdict()
    return solve(problem, grid, asked) - np.array(problem["yaw"])


def measure(problem):
    times = np.array(problem["times"])
    grid = np.union1d(times, [problem["pulse"]])
    parameters = lmfit.Parameters()
    for name, value in zip(("kp", "kd", "T"), problem["start"], strict=True):
        parameters.add(name, value=value, min=0.002 if name == "T" else 0.0)
    began = time.process_time()
    found = lmfit.minimize(residuals, parameters, args=(problem, grid, np.searchsorted(grid, times)))
    run_s = time.process_time() - began
    x = [found.params[name].value for name in ("kp", "kd", "T")]
    reported = found.params["kp"].stderr
    said = f"success {found.success}, kp {x[0]:.0f} +- {reported or 0:.1g}"
    error = stopwatch.estimate_error(problem, x)
    yield {"use": "defaults", "setting": said, "setup_s": 0.0, "error": error, "run_s": run_s, "best_s": run_s}


if __name__ == "__main__":
    stopwatch.main("lmfit", measure)
