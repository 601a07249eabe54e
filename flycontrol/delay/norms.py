"""Norms of stable systems with delay, under one name as in python-control."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flycontrol.delay.h2 import H2Norm, h2_norm
from flycontrol.delay.peak_gain import PeakGain, hinf_norm, linfnorm
from flycontrol.errors import InvalidParameterError

if TYPE_CHECKING:
    from flycontrol.delay.convert import Operand

__all__ = ["H2Norm", "PeakGain", "h2_norm", "hinf_norm", "linfnorm", "system_norm"]


def system_norm(system: Operand, p: float | str = 2, tol: float = 1e-6) -> float:
    """The H2 norm (p = 2) or the H-infinity norm (p = "inf" or numpy.inf), to a relative accuracy.

    The H2 norm is infinite with any feedthrough, delayed included. For bounds and frequency see `h2_norm`, `hinf_norm`.

    Raises
    ------
    InvalidParameterError
        If there is no such norm, or the accuracy cannot be reached.
    UnstableSystemError
        If the system is not stable.
    """
    if p == 2:
        h2 = h2_norm(system, tol)
        if h2.status.startswith("bounded"):
            raise InvalidParameterError(f"The H2 norm to {tol:g} is beyond reach ({h2.status}); ask for less.")
        return h2.value
    if p in ("inf", np.inf):
        peak = hinf_norm(system, tol)
        if peak.status != "certified":
            raise InvalidParameterError(f"The H-infinity norm to {tol:g} is beyond reach ({peak.status}).")
        return peak.lower
    raise InvalidParameterError(f'A norm is that of p = 2 or p = "inf", got {p!r}.')
