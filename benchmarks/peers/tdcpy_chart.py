"""tdcpy on a stability chart: is there a root right of the axis? By its own discretisation and by given ones."""

import numpy as np
import stopwatch
import tdcpy


def verdicts(b, gains, T, options):
    fixed = np.array([[0, 1], [0, -b]])
    systems = (tdcpy.RDDE(A=[fixed, np.array([[0, 0], [-kp, -kd]])], hA=[0.0, T]) for kp, kd in gains)
    return [len(tdcpy.roots(system, r=0.0, **options)[0]) == 0 for system in systems]


def measure(problem):
    gains = [(kp, kd) for kd in problem["kd"] for kp in problem["kp"]]
    cases = [("default", "default", {})]
    cases += [("tuned", f"{n} nodes", {"discretization": n}) for n in (4, 5, 6, 8, 10, 12)]
    for use, setting, options in cases:
        call = (problem["b"], gains, problem["T"], options)
        error = stopwatch.wrong_verdicts(problem, verdicts(*call))
        timing = stopwatch.timed(lambda call=call: verdicts(*call), fewest=3)
        yield {"use": use, "setting": setting, "setup_s": 0.0, "error": error, **timing}
        if use == "tuned" and not error:
            break


if __name__ == "__main__":
    stopwatch.main("tdcpy", measure)
