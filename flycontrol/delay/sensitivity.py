"""Sensitivity functions of a loop with delay: what references, disturbances and noise do to it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from flycontrol.delay.convert import as_delay_lti
from flycontrol.delay.interconnect import append, connect, feedback
from flycontrol.delay.peak_gain import PeakGain, hinf_norm
from flycontrol.delay.system import DelayLTI
from flycontrol.errors import InvalidParameterError

if TYPE_CHECKING:
    from flycontrol.delay.convert import Operand
    from flycontrol.delay.plots.style import AxesArray


@dataclass(frozen=True, slots=True, kw_only=True)
class SensitivityPeaks:
    """H-infinity norms of the four sensitivity functions."""

    S: PeakGain
    T: PeakGain
    CS: PeakGain
    PS: PeakGain


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class GangOfFour:
    """The loop e = r - y, u = C e, y = P (u + d), with a plant of p outputs and m inputs."""

    S: DelayLTI  #: (I + P C)^-1, from the reference r to the error e, shape (p, p)
    T: DelayLTI  #: (I + P C)^-1 P C, from r to the output y, shape (p, p)
    CS: DelayLTI  #: C (I + P C)^-1, from r to the control u, shape (m, p)
    PS: DelayLTI  #: (I + P C)^-1 P, from the load disturbance d to y, shape (p, m)

    def peaks(self, tol: float = 1e-6) -> SensitivityPeaks:
        """H-infinity norms to a relative accuracy; that of S is 1 / modulus margin.

        Raises
        ------
        UnstableSystemError
            If the loop is unstable.
        """
        return SensitivityPeaks(
            S=hinf_norm(self.S, tol), T=hinf_norm(self.T, tol), CS=hinf_norm(self.CS, tol), PS=hinf_norm(self.PS, tol)
        )

    def plot(self, **options: Any) -> AxesArray:
        """Draw it; options and return value as in `gangof4_plot`."""
        from flycontrol.delay.plots import gangof4_plot

        return gangof4_plot(self, **options)


def gangof4(P: Operand, C: Operand) -> GangOfFour:
    """The four sensitivity functions of a plant and a controller under negative feedback.

    Raises
    ------
    InvalidParameterError
        If the two do not fit into a loop.
    AlgebraicLoopError
        If the undelayed direct path around the loop has no unique solution.
    """
    plant, controller = as_delay_lti(P), as_delay_lti(C)
    p, m = plant.n_outputs, plant.n_inputs
    if (controller.n_outputs, controller.n_inputs) != (m, p):
        raise InvalidParameterError(
            f"A plant of shape (outputs, inputs) = {(p, m)} needs a controller of shape {(m, p)}, got "
            f"{(controller.n_outputs, controller.n_inputs)}."
        )
    both = append(plant, controller)  # inputs u + d (m) and e (p), outputs y (p) and u (m)
    F = np.block([[np.zeros((m, p)), np.eye(m)], [-np.eye(p), np.zeros((p, m))]])
    from_d, from_r = np.eye(m + p)[:, :m], np.eye(m + p)[:, m:]
    to_y, to_u = np.eye(p + m)[:p], np.eye(p + m)[p:]
    T = connect(both, F, from_r, to_y)
    return GangOfFour(S=_complement(T), T=T, CS=connect(both, F, from_r, to_u), PS=connect(both, F, from_d, to_y))


def sensitivity(loop: Operand) -> DelayLTI:
    """S = (I + L)^-1 of a loop closed by negative unit feedback.

    Raises
    ------
    InvalidParameterError
        If the loop is not square.
    """
    return _complement(feedback(loop))


def complementary_sensitivity(loop: Operand) -> DelayLTI:
    """T = (I + L)^-1 L of a loop closed by negative unit feedback.

    Raises
    ------
    InvalidParameterError
        If the loop is not square.
    """
    return feedback(loop)


def _complement(T: DelayLTI) -> DelayLTI:
    """I - T, with the states of T."""
    return replace(T, C1=-T.C1, D11=np.eye(T.n_outputs) - T.D11, D12=-T.D12)
