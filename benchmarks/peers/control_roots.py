"""python-control on the rightmost roots: poles of the loop with a Padé approximant of the delay, building included."""

import control
import numpy as np
import stopwatch


def poles(loop, order, unit):
    """Poles [1/s] of the loop, built with time in the given unit [s]."""
    b, kp, kd, T = loop["b"] * unit, loop["kp"] * unit**2, loop["kd"] * unit, loop["T"] / unit
    plant = control.ss([[0, 1], [0, -b]], [[0], [1]], np.eye(2), np.zeros((2, 1)))
    delay = control.ss(control.tf(*control.pade(T, order)))
    return control.feedback(plant, delay * control.ss([], [], [], [[kp, kd]])).poles() / unit


def rational_poles(loop, order, unit):
    """The same by transfer functions and the roots of the closed loop's denominator."""
    b, kp, kd, T = loop["b"] * unit, loop["kp"] * unit**2, loop["kd"] * unit, loop["T"] / unit
    back = control.tf([kd, kp], [1]) * control.tf(*control.pade(T, order))
    return control.feedback(control.tf([1], [1, b, 0]), back).poles() / unit


def measure(problem):
    loop = problem["loop"]

    def row(use, solve, order, unit):
        error = stopwatch.root_error(problem, solve(loop, order, unit))
        timing = stopwatch.timed(lambda: solve(loop, order, unit))
        return {"use": use, "setting": f"Padé-{order}, {solve.__name__}", "setup_s": 0.0, "error": error, **timing}

    yield row("Padé-4", poles, 4, 1.0)
    yield row("Padé-4", rational_poles, 4, 1.0)
    for order in range(2, 15):
        yield row("any order, time in delays", poles, order, loop["T"])


if __name__ == "__main__":
    stopwatch.main("control", measure)
