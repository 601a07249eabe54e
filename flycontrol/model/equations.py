"""The review's equations as plain arithmetic: they take numbers, arrays and CasADi symbols alike."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

Quantity = Any  #: float, NumPy array or CasADi symbol


def stroke_averaged_torque(
    drag: Callable[[Quantity], Quantity], alpha0: Quantity, wing_speed: Quantity, yaw_rate: Quantity, d_alpha: Quantity
) -> Quantity:
    """N_aero ~ -C_D(alpha_L) (omega + psi')^2 + C_D(alpha_R) (omega - psi')^2.  Review, Eq. 2, before its expansion.

    Parameters
    ----------
    drag
        C_D as a function of the attack angle [rad].
    alpha0, d_alpha
        Mean attack angle and paddling angle [rad]: alpha_R = alpha0 + d_alpha, alpha_L = alpha0 - d_alpha.
    wing_speed, yaw_rate
        omega and psi' [rad/s].

    Returns
    -------
    Torque in units of the aerodynamic scale factor that the review leaves out [rad^2/s^2 times C_D].
    """
    left = drag(alpha0 - d_alpha) * (wing_speed + yaw_rate) ** 2
    right = drag(alpha0 + d_alpha) * (wing_speed - yaw_rate) ** 2
    return right - left


def paddling_torque(
    gamma: Quantity, d_alpha: Quantity, yaw_rate: Quantity = 0.0, wing_speed: Quantity | None = None
) -> Quantity:
    """gamma d_alpha (1 + (psi' / omega)^2): Eq. 2 with linear C_D; without omega, Eq. 3's gamma d_alpha."""
    if wing_speed is None:
        return gamma * d_alpha
    return gamma * d_alpha * (1.0 + (yaw_rate / wing_speed) ** 2)


def turn_acceleration(inertia: Quantity, damping: Quantity, yaw_rate: Quantity, torque: Quantity) -> Quantity:
    """psi'' = (-beta psi' + N) / I.  Review, Eq. 3 and 7."""
    return (-damping * yaw_rate + torque) / inertia


def hinge_torque(
    stiffness: Quantity, damping: Quantity, pitch: Quantity, rest_angle: Quantity, pitch_rate: Quantity
) -> Quantity:
    """tau = -kappa (eta - eta0) - C eta'.  Review, section 5."""
    return -stiffness * (pitch - rest_angle) - damping * pitch_rate


def hinge_transmission(mu: Quantity, bias: Quantity) -> Quantity:
    """d_alpha = mu d_eta0.  Review, section 5; mu = 0.6 in its text."""
    return mu * bias


def corrective_demand(proportional: Quantity, derivative: Quantity, yaw: Quantity, yaw_rate: Quantity) -> Quantity:
    """K_P psi + K_D psi', the torque demanded against a deflection.

    The fly exerts N_fly(t) = -(K_P psi + K_D psi')(t - T): restoring gains are positive here, where the review's Eq. 6
    writes the sum with its own sign.
    """
    return proportional * yaw + derivative * yaw_rate
