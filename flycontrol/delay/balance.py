"""States scaled to each other, and how far from the origin roots can lie."""

from __future__ import annotations

import numpy as np
import scipy.linalg

from flycontrol.delay.system import DelayLTI


def balance(system: DelayLTI) -> DelayLTI:
    """The same system with states scaled so that rows and columns of |A| + |B2| |C2| are of equal size."""
    if system.n_states == 0:
        return system
    weight = np.abs(system.A) + np.abs(system.B2) @ np.abs(system.C2)
    _, (scale, _) = scipy.linalg.matrix_balance(weight, permute=False, separate=True)
    s = np.asarray(scale, dtype=np.float64)
    x = system
    entry = np.abs(x.B2 / s[:, None]).max(axis=0, initial=0.0)
    reading = np.abs(x.C2 * s).max(axis=1, initial=0.0)
    both = (entry > 0) & (reading > 0)
    # delayed signals in units that make entry and exit of a channel alike; a link in a chain of delays keeps its own
    c = np.sqrt(np.divide(reading, entry, out=np.ones_like(entry), where=both))
    return DelayLTI(
        x.A * s / s[:, None], x.B1 / s[:, None], x.B2 * c / s[:, None], x.C1 * s, x.C2 * s / c[:, None],
        x.D11, x.D12 * c, x.D21 / c[:, None], x.D22 * c / c[:, None], x.tau,
    )  # fmt: skip


def root_bound(system: DelayLTI, line: float) -> float:
    """A bound on |s| for every root with Re s >= line: ||A|| + ||B2|| ||E|| ||(I - D22 E)^-1|| ||C2|| [1/s]."""
    growth = np.exp(-line * system.tau)
    chain = np.linalg.inv(np.eye(system.n_delays) - growth[:, None] * np.abs(system.D22))
    delayed = np.abs(system.B2) @ chain @ (growth[:, None] * np.abs(system.C2))
    return float(np.linalg.norm(np.abs(system.A) + delayed, np.inf))
