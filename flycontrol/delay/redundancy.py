"""Delay channels that carry the same signal, or none that is used: one system, fewer channels, nothing approximated."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from flycontrol.delay.system import DelayLTI, FloatArray


def merge_delays(system: DelayLTI) -> DelayLTI:
    """The same system with fewer delay channels, where equality to the last bit shows that they are redundant.

    Channels of equal delay become one if they are fed by the same signal, or if only their sum is used; channels that
    are fed nothing or read by nothing go. States and characteristic roots stay.
    """
    while system.n_delays:
        fewer = _transposed(_fed_alike(_transposed(_fed_alike(_without_idle(system)))))
        if fewer.n_delays == system.n_delays:
            break
        system = fewer
    return system


def _transposed(system: DelayLTI) -> DelayLTI:
    """The system with the transposed transfer matrix: what is read becomes what is fed."""
    x = system
    return DelayLTI(x.A.T, x.C1.T, x.C2.T, x.B1.T, x.B2.T, x.D11.T, x.D21.T, x.D12.T, x.D22.T, x.tau)


def _without_idle(system: DelayLTI) -> DelayLTI:
    x = system
    fed = np.column_stack([x.C2, x.D21, x.D22]).any(axis=1)
    read = np.vstack([x.B2, x.D12, x.D22]).any(axis=0)
    used = np.flatnonzero(fed & read)
    return _regrouped(system, used, np.eye(x.n_delays)[:, used])


def _fed_alike(system: DelayLTI) -> DelayLTI:
    """z_i = z_j and tau_i = tau_j make w_i = w_j: the first of such channels stands for all."""
    x = system
    fed: dict[bytes, int] = {}
    # adding zero makes -0.0 equal to 0.0
    rows = [row.tobytes() for row in np.column_stack([x.tau, x.C2, x.D21, x.D22]) + 0.0]
    group = [fed.setdefault(row, len(fed)) for row in rows]
    first = np.array([group.index(k) for k in range(len(fed))], dtype=np.intp)
    return _regrouped(system, first, np.eye(len(fed))[group])


def _regrouped(system: DelayLTI, kept: np.ndarray, spread: FloatArray) -> DelayLTI:
    """Channels `kept` alone, w = spread (q, kept) times theirs."""
    x = system
    if len(kept) == x.n_delays:
        return system
    return replace(
        x, B2=x.B2 @ spread, C2=x.C2[kept], D12=x.D12 @ spread, D21=x.D21[kept], D22=x.D22[kept] @ spread,
        tau=x.tau[kept],
    )  # fmt: skip
