"""qpmr on the rightmost roots: its own region (about 100 roots), and a box that is told to it, over grid steps."""

import numpy as np
import qpmr
import stopwatch


def solve(loop, **options):
    b, kp, kd, T = (loop[name] for name in ("b", "kp", "kd", "T"))
    coefficients = np.array([[0.0, b, 1.0], [kp, kd, 0.0]])
    return qpmr.qpmr(coefficients, np.array([0.0, T]), **options)[0]


def measure(problem):
    box = tuple(problem["box"])
    cases = [("own region", {}), ("box", {"region": box})]
    cases += [(f"box, grid step {ds:g}", {"region": box, "ds": ds}) for ds in (5.0, 10.0, 15.0, 20.0, 30.0, 40.0)]
    for setting, options in cases:
        error = stopwatch.root_error(problem, solve(problem["loop"], **options))
        timing = stopwatch.timed(lambda options=options: solve(problem["loop"], **options))
        use = "default" if setting == "own region" else "told where to look"
        yield {"use": use, "setting": setting, "setup_s": 0.0, "error": error, **timing}


if __name__ == "__main__":
    stopwatch.main("qpmr", measure)
