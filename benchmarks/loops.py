"""flycontrol's side of the jobs, from the same plain values that the peers get."""

import numpy as np

from flycontrol.delay.certificate import stability_certificate
from flycontrol.delay.characteristic import CharacteristicBlocks
from flycontrol.delay.chart import Axis, stability_chart
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


def roots(loop, count, *, certify):
    return rightmost_roots(closed_loop(loop), count, certify=certify)


def proof(loop, order):
    return stability_certificate(closed_loop(loop), order)


def chart(problem, system_at, **options):
    """Whether the loop is stable at each gain, row by row in kd."""
    kp, kd = (Axis(name, unit, problem[name]) for name, unit in (("kp", "1/s^2"), ("kd", "1/s")))
    return stability_chart(system_at(problem["b"], problem["T"]), kp, kd, **options).stable.ravel()


def as_systems(b, T):
    return lambda kp, kd: closed_loop({"b": b, "kp": kp, "kd": kd, "T": T})


def as_blocks(b, T):
    """Blocks of one loop, or of many where kp and kd are arrays."""
    A, B2, D22, tau = np.array([[0.0, 1.0], [0.0, -b]]), np.array([[0.0], [-1.0]]), np.zeros((1, 1)), np.array([T])
    return lambda kp, kd: CharacteristicBlocks(A, B2, np.stack([kp, kd], axis=-1)[..., None, :], D22, tau)
