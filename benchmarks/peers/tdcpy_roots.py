"""tdcpy on the rightmost roots: right half-plane by its own discretisation and by given ones, and a rectangle.

The rectangle reaches one unit below the real axis: real roots come out of its Newton steps with an imaginary part of
the size of rounding and would fall out of a box that starts at zero.
"""

import numpy as np
import stopwatch
import tdcpy


def solve(loop, region, **options):
    b, kp, kd, T = (loop[name] for name in ("b", "kp", "kd", "T"))
    system = tdcpy.RDDE(A=[np.array([[0, 1], [0, -b]]), np.array([[0, 0], [-kp, -kd]])], hA=[0.0, T])
    return tdcpy.roots(system, r=region, **options)[0]


def measure(problem):
    loop, (left, right, _, top) = problem["loop"], problem["box"]
    cases = [
        ("half-plane, default", left, {}),
        ("rectangle", [left, right, -1.0, top], {}),
        *[(f"half-plane, {n} nodes", left, {"discretization": n}) for n in (6, 8, 10, 12, 15)],
    ]
    for setting, region, options in cases:
        error = stopwatch.root_error(problem, solve(loop, region, **options))
        timing = stopwatch.timed(lambda region=region, options=options: solve(loop, region, **options))
        use = "default" if "default" in setting else "tuned"
        yield {"use": use, "setting": setting, "setup_s": 0.0, "error": error, **timing}


if __name__ == "__main__":
    stopwatch.main("tdcpy", measure)
