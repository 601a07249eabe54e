"""python-control on a stability chart: are all poles of the loop with a Padé approximant left of the axis?

Three ways of python-control, time in units of the delay: the product of transfer functions as on paper, the closed
loop's denominator put together by polynomials, feedback of a state space. Padé approximants are computed once. By hand,
with python-control for the approximant alone: the closed loops' matrices as one batch to NumPy's eigenvalues.
"""

import control
import numpy as np
import stopwatch


def transfer_functions(problem, b, gains, unit, order):
    plant, lag = control.tf([1], [1, b, 0]), control.tf(*control.pade(1.0, order))
    return [
        control.feedback(plant * lag * control.tf([kd * unit, kp * unit**2], [1])).poles().real.max() < 0
        for kp, kd in gains
    ]


def polynomials(problem, b, gains, unit, order):
    up, down = control.pade(1.0, order)
    open_loop = np.polymul(down, [1, b, 0])
    return [
        control.tf([1], np.polyadd(open_loop, np.polymul(up, [kd * unit, kp * unit**2]))).poles().real.max() < 0
        for kp, kd in gains
    ]


def chain(b, order):
    """From the delayed torque to (psi, psi'), in states of psi and of the approximant."""
    plant = control.ss([[0, 1], [0, -b]], [[0], [1]], np.eye(2), np.zeros((2, 1)))
    return plant * control.ss(control.tf(*control.pade(1.0, order)))


def state_space(problem, b, gains, unit, order):
    system = chain(b, order)
    return [control.feedback(system, np.array([[kp * unit**2, kd * unit]])).poles().real.max() < 0 for kp, kd in gains]


def batch_of_matrices(problem, b, gains, unit, order):
    system = chain(b, order)
    feedback = np.array(gains) * [unit**2, unit] @ system.C
    return np.linalg.eigvals(system.A - system.B * feedback[:, None, :]).real.max(axis=1) < 0


def measure(problem):
    unit, gains = problem["T"], [(kp, kd) for kd in problem["kd"] for kp in problem["kp"]]
    for solve in (transfer_functions, polynomials, state_space, batch_of_matrices):
        for order in range(2, 13):
            call = (problem, problem["b"] * unit, gains, unit, order)
            error = stopwatch.wrong_verdicts(problem, solve(*call))
            if error:
                continue
            timing = stopwatch.timed(lambda solve=solve, call=call: solve(*call))
            use = solve.__name__.replace("_", " ")
            use = f"by hand, {use}" if solve is batch_of_matrices else use
            yield {"use": use, "setting": f"Padé-{order}", "setup_s": 0.0, "error": error, **timing}
            break


if __name__ == "__main__":
    stopwatch.main("control", measure)
