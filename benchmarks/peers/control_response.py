"""python-control on one recovery: state space, Padé approximant of the delay in the feedback path, forced_response.

Padé-4 in seconds, as most would write it, and every order with time in units of the delay, which keeps the companion
form of the approximant well conditioned. The pulse ends off the grid: the response is put together from four calls
that meet at the edge, the last of them without input, which is python-control's fastest path. One call with the
pulse's end spread over a sample is measured beside it.
"""

import time

import control
import numpy as np
import stopwatch


def closed_loop(loop, order, unit):
    """The loop from torque to (psi, psi'), time in the given unit [s]."""
    b, kp, kd, T = loop["b"] * unit, loop["kp"] * unit**2, loop["kd"] * unit, loop["T"] / unit
    plant = control.ss([[0, 1], [0, -b]], [[0], [1]], np.eye(2), np.zeros((2, 1)))
    delay = control.ss(control.tf(*control.pade(T, order)))
    return control.feedback(plant, delay * control.ss([], [], [], [[kp, kd]]))


def in_segments(system, problem, unit):
    t, edge, a = np.array(problem["times"]) / unit, problem["pulse"] / unit, problem["acceleration"] * unit**2
    k = int(np.searchsorted(t, edge)) - 1
    pushed = control.forced_response(system, t[: k + 1], np.full(k + 1, a))
    to_edge = control.forced_response(system, [t[k], edge], [a, a], pushed.states[:, -1])
    from_edge = control.forced_response(system, [edge, t[k + 1]], initial_state=to_edge.states[:, -1])
    free = control.forced_response(system, t[k + 1 :], initial_state=from_edge.states[:, -1])
    return np.concatenate([pushed.states[0], free.states[0]])


def on_the_grid(system, problem, unit):
    t, edge, a = np.array(problem["times"]) / unit, problem["pulse"] / unit, problem["acceleration"] * unit**2
    push = a * np.clip((edge - t) / (t[1] - t[0]) + 0.5, 0.0, 1.0)  # the same impulse, its end spread over a sample
    return control.forced_response(system, t, push).states[0]


def measure(problem):
    loop = problem["loop"]

    def row(use, order, unit, solve):
        system = closed_loop(loop, order, unit)
        began = time.process_time()
        system = closed_loop(loop, order, unit)
        setup_s = time.process_time() - began
        error = stopwatch.angle_error(problem, solve(system, problem, unit))
        timing = stopwatch.timed(lambda: solve(system, problem, unit))
        return {"use": use, "setting": f"Padé-{order}, {solve.__name__}", "setup_s": setup_s, "error": error, **timing}

    yield row("Padé-4", 4, 1.0, in_segments)
    yield row("Padé-4", 4, 1.0, on_the_grid)
    for order in range(1, 14):
        yield row("any order, time in delays", order, loop["T"], in_segments)


if __name__ == "__main__":
    stopwatch.main("control", measure)
