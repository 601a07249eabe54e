"""flycontrol's side of the two jobs, from the same plain values that the peers get."""

import numpy as np

from flycontrol.delay.response import response
from flycontrol.delay.spectrum import rightmost_roots
from flycontrol.delay.system import delay_lti


def closed_loop(loop):
    """psi'' = -b psi' - kp psi(t - T) - kd psi'(t - T) + u."""
    b, kp, kd, T = (loop[name] for name in ("b", "kp", "kd", "T"))
    return delay_lti(A=[[0, 1], [0, -b]], B1=[[0], [1]], B2=[[0], [-1]], C1=[[1, 0]], C2=[[kp, kd]], tau=[T])


def recover(problem, system=None, times=None):
    system = closed_loop(problem["loop"]) if system is None else system
    times = np.array(problem["times"]) if times is None else times
    pushed = response(system, problem["end"], (0.0, problem["pulse"]), [[problem["acceleration"]], [0.0]])
    return pushed(times)[0]


def roots(loop, count):
    return rightmost_roots(closed_loop(loop), count).roots
