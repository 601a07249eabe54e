"""The yaw loop: a body with flapping counter-torque, and a fly that feeds its heading back after a delay."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from flycontrol.delay.margins import Margins, margins
from flycontrol.delay.pade import to_statespace
from flycontrol.delay.spectrum import rightmost_roots
from flycontrol.delay.system import ComplexArray, DelayLTI, delay_lti
from flycontrol.errors import InvalidParameterError

if TYPE_CHECKING:
    import casadi as ca
    import control

    from flycontrol.model.symbolic import SymbolicDelaySystem


@dataclass(frozen=True, slots=True, kw_only=True)
class YawPlant:
    """I psi'' = -beta psi' + N.  Review, Eq. 7."""

    inertia: float  #: I about the vertical axis [kg m^2]
    damping: float  #: beta, flapping counter-torque [N m s]

    def __post_init__(self) -> None:
        if not (self.inertia > 0 and np.isfinite(self.inertia)):
            raise InvalidParameterError(f"YawPlant.inertia must be > 0 kg m^2, got {self.inertia!r}.")
        if not (self.damping >= 0 and np.isfinite(self.damping)):
            raise InvalidParameterError(f"YawPlant.damping must be >= 0 N m s, got {self.damping!r}.")

    @property
    def damping_rate(self) -> float:
        """b = beta / I [1/s]."""
        return self.damping / self.inertia


@dataclass(frozen=True, slots=True, kw_only=True)
class PDController:
    """N_fly(t) = -(K_P psi + K_D psi')(t - T), on the yaw angle.  Review, Eq. 6, with restoring gains positive.

    The review writes the sum without the minus sign; its restoring gains would be negative.
    """

    proportional: float  #: K_P [N m/rad]
    derivative: float = 0.0  #: K_D [N m s/rad]

    def __post_init__(self) -> None:
        for name, value in (("proportional", self.proportional), ("derivative", self.derivative)):
            if not np.isfinite(value):
                raise InvalidParameterError(f"PDController.{name} must be a finite number, got {value!r}.")


@dataclass(frozen=True, slots=True, kw_only=True)
class PIDController:
    """N_fly(t) = -(K_P psi + K_I z + K_D psi')(t - T), z' = psi, on the yaw angle; restoring gains positive."""

    proportional: float  #: K_P [N m/rad]
    integral: float  #: K_I [N m/(rad s)]
    derivative: float = 0.0  #: K_D [N m s/rad]

    def __post_init__(self) -> None:
        for name in ("proportional", "integral", "derivative"):
            value = getattr(self, name)
            if not np.isfinite(value):
                raise InvalidParameterError(f"PIDController.{name} must be a finite number, got {value!r}.")


@dataclass(frozen=True, slots=True, kw_only=True)
class YawLoop:
    """I psi'' = -beta psi' - K_P psi(t - T) - K_D psi'(t - T) + N_ext.  Review, Eq. 7 and 8.

    A `PIDController` adds -K_I z(t - T) with z' = psi.
    """

    plant: YawPlant
    controller: PDController | PIDController
    delay: float  #: T, reaction delay of the whole loop [s]

    def __post_init__(self) -> None:
        if not (self.delay >= 0 and np.isfinite(self.delay)):
            raise InvalidParameterError(f"YawLoop.delay must be >= 0 s, got {self.delay!r}.")

    @classmethod
    def from_rates(
        cls, *, b: float, kp: float, kd: float, delay: float, inertia: float = 1.0, ki: float = 0.0
    ) -> YawLoop:
        """From ratios to the inertia: b = beta/I [1/s], kp = K_P/I [1/s^2], kd = K_D/I [1/s], ki = K_I/I [1/s^3]."""
        P, D = kp * inertia, kd * inertia
        controller = (
            PIDController(proportional=P, integral=ki * inertia, derivative=D)
            if ki
            else PDController(proportional=P, derivative=D)
        )
        return cls(plant=YawPlant(inertia=inertia, damping=b * inertia), controller=controller, delay=delay)

    @property
    def kp(self) -> float:
        """K_P / I [1/s^2]."""
        return self.controller.proportional / self.plant.inertia

    @property
    def kd(self) -> float:
        """K_D / I [1/s]."""
        return self.controller.derivative / self.plant.inertia

    @property
    def ki(self) -> float:
        """K_I / I [1/s^3], 0 for a `PDController`."""
        return self._integral / self.plant.inertia

    @property
    def _integral(self) -> float:
        return self.controller.integral if isinstance(self.controller, PIDController) else 0.0

    def closed_loop(self) -> DelayLTI:
        """From N_ext [N m] to psi [rad], psi' [rad/s] and N_fly [N m]; the delay is exact."""
        if self.delay == 0:
            return _without_delay(self)
        from flycontrol.model.symbolic import linearised

        return linearised(_yaw_linearisation(self._integrates), self._parameters())

    def open_loop(self) -> DelayLTI:
        """L(s) = (K_D s + K_P + K_I / s) exp(-s T) / (I s^2 + beta s), cut at the fly's torque; -1 closes it."""
        A, B = [[0.0, 1.0], [0.0, -self.plant.damping_rate]], [[0.0], [1.0 / self.plant.inertia]]
        reading = [[self.controller.proportional, self.controller.derivative]]
        if self._integrates:
            A, B = [[*A[0], 0.0], [*A[1], 0.0], [1.0, 0.0, 0.0]], [*B, [0.0]]
            reading = [[*reading[0], self._integral]]
        if self.delay == 0:
            return delay_lti(A=A, B1=B, C1=reading)
        return delay_lti(A=A, B1=B, C1=np.zeros((1, len(A))), C2=reading, D12=[[1.0]], tau=[self.delay])

    def pade(self, order: int) -> control.StateSpace:
        """The closed loop with an [order/order] Pade approximation of the delay: N_ext to psi, psi' and N_fly."""
        return to_statespace(self.pade_closed_loop(order))

    def pade_closed_loop(self, order: int) -> DelayLTI:
        """The same as `pade`, as a delay-free `DelayLTI`, linearised from the symbolic augmentation."""
        if self.delay == 0:
            return _without_delay(self)
        from flycontrol.model.symbolic import linearised

        return linearised(_yaw_pade_linearisation(order, self._integrates), self._parameters())

    def poles(self, count: int = 10) -> ComplexArray:
        """The rightmost exact poles of the closed loop [1/s]."""
        return rightmost_roots(self.closed_loop(), count).roots

    def margins(self) -> Margins:
        """Margins of `open_loop`; they mean robustness only if the loop is stable."""
        return margins(self.open_loop())

    def _parameters(self) -> list[float]:
        gains = [self.controller.proportional, self.controller.derivative]
        return [self.plant.inertia, self.plant.damping, *gains, self.delay, *([self._integral] * self._integrates)]

    @property
    def _integrates(self) -> bool:
        return isinstance(self.controller, PIDController)


def require_pd(loop: YawLoop) -> None:
    """Refuse a loop that closed forms are not for: InvalidParameterError where it has an integral term."""
    if isinstance(loop.controller, PIDController):
        raise InvalidParameterError(
            f"This holds for P or PD control of the yaw angle only; the loop has an integral gain, "
            f"K_I/I = {loop.ki:g} 1/s^3."
        )


def yaw_system(*, saturated: bool = False, quadratic: bool = False, integral: bool = False) -> SymbolicDelaySystem:
    """The yaw loop in CasADi: states psi, psi'; parameters I, beta, K_P, K_D, T and those of the variants.

    With an integral term a third state z' = psi and the parameter K_I follow.

    The fly answers a demand by paddling, N_fly = gamma d_alpha, so gamma cancels until paddling saturates (adds the
    parameter N_max, the largest torque [N m], smoothly as tanh) or Eq. 2's psi'^2 is kept (adds omega, the mean angular
    speed of the wings [rad/s]).
    """
    import casadi as ca

    from flycontrol.model import equations
    from flycontrol.model.symbolic import SymbolicDelaySystem

    yaw, rate, delayed, external = (ca.SX.sym(name) for name in ("psi", "psi_dot", "w", "N_ext"))
    inertia, damping, proportional, derivative, delay = (ca.SX.sym(name) for name in ("I", "beta", "K_P", "K_D", "T"))
    parameters = [inertia, damping, proportional, derivative, delay]
    torque, wing_speed = -delayed, None
    demand, states, rates = equations.corrective_demand(proportional, derivative, yaw, rate), [yaw, rate], []
    if integral:
        gain, sum_of_yaw = ca.SX.sym("K_I"), ca.SX.sym("z")
        parameters.append(gain)
        demand, states, rates = demand + gain * sum_of_yaw, [yaw, rate, sum_of_yaw], [yaw]
    if saturated:
        limit = ca.SX.sym("N_max")
        parameters.append(limit)
        torque = limit * ca.tanh(torque / limit)
    if quadratic:
        wing_speed = ca.SX.sym("omega")
        parameters.append(wing_speed)
    fly = equations.paddling_torque(1.0, torque, rate, wing_speed)
    return SymbolicDelaySystem(
        states=ca.vertcat(*states),
        delayed=delayed,
        inputs=external,
        parameters=ca.vertcat(*parameters),
        derivative=ca.vertcat(rate, equations.turn_acceleration(inertia, damping, rate, fly + external), *rates),
        outputs=ca.vertcat(yaw, rate, fly),
        delayed_signals=demand,
        delays=delay,
    )


@lru_cache(maxsize=2)
def _yaw_linearisation(integral: bool) -> ca.Function:
    from flycontrol.model.symbolic import linearisation

    return linearisation(yaw_system(integral=integral))


@lru_cache(maxsize=32)
def _yaw_pade_linearisation(order: int, integral: bool) -> ca.Function:
    from flycontrol.model.symbolic import linearisation, pade_augmented

    return linearisation(pade_augmented(yaw_system(integral=integral), order))


def _without_delay(loop: YawLoop) -> DelayLTI:
    K_P, K_D, inertia = loop.controller.proportional, loop.controller.derivative, loop.plant.inertia
    A = np.array([[0.0, 1.0], [-K_P / inertia, -(loop.plant.damping + K_D) / inertia]])
    C = np.array([[1.0, 0.0], [0.0, 1.0], [-K_P, -K_D]])
    B = np.array([[0.0], [1.0 / inertia]])
    if isinstance(loop.controller, PIDController):
        K_I = loop.controller.integral
        A = np.block([[A, np.array([[0.0], [-K_I / inertia]])], [np.array([[1.0, 0.0, 0.0]])]])
        B, C = np.vstack([B, [[0.0]]]), np.hstack([C, [[0.0], [0.0], [-K_I]]])
    return delay_lti(A=A, B1=B, C1=C)
