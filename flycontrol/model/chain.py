"""The loop as a chain of named transfer functions: halteres, neural controller, hinge, paddling, body (Fig. 8)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from flycontrol.delay.system import ComplexArray
from flycontrol.errors import InvalidParameterError
from flycontrol.model.yaw import YawLoop, require_pd


@dataclass(frozen=True, slots=True, kw_only=True)
class Link:
    """One element of the chain: numerator(s) / denominator(s) * exp(-s delay), coefficients by falling powers of s."""

    name: str
    reads: str  #: the signal that enters, with its unit
    gives: str  #: the signal that leaves, with its unit
    numerator: tuple[float, ...]
    denominator: tuple[float, ...] = (1.0,)
    delay: float = 0.0  #: [s]

    def __call__(self, s: ArrayLike) -> ComplexArray:
        """Value at complex frequencies s [1/s]."""
        points = np.asarray(s, dtype=np.complex128)
        ratio = np.polyval(self.numerator, points) / np.polyval(self.denominator, points)
        return ratio * np.exp(-points * self.delay)


@dataclass(frozen=True, slots=True, kw_only=True)
class Chain:
    """Links around the loop, the sign of the feedback left out; their product is L(s) of `YawLoop.open_loop`."""

    links: tuple[Link, ...]

    def __call__(self, s: ArrayLike) -> ComplexArray:
        """Product of all links at s [1/s]."""
        return np.prod([link(s) for link in self.links], axis=0)

    def phase_budget(self, omega: float) -> dict[str, float]:
        """Phase of each link at a frequency [rad/s], in rad, each in (-pi, pi] with the delay counted in full."""
        point = 1j * omega
        return {
            link.name: float(np.angle(link(point) * np.exp(point * link.delay)) - omega * link.delay)
            for link in self.links
        }


def yaw_chain(loop: YawLoop, gamma: float, mu: float) -> Chain:
    """S -> C -> M -> A -> body for a yaw loop.  Review, Fig. 8 and Eq. 8.

    Eq. 8: gamma d_alpha = gamma mu d_eta0 = K_P psi + K_D psi'.

    The halteres sense psi', so PD on the angle is PI on the rate, its integrator started at the heading error. Only the
    product of the neural gains with gamma and mu is fixed by the loop; the whole delay stands at the controller.

    Parameters
    ----------
    gamma
        Paddling torque a paddling angle [N m/rad], > 0.
    mu
        Paddling angle a hinge bias, > 0 (0.6 in the review's text).
    """
    if not (gamma > 0 and mu > 0):
        raise InvalidParameterError(f"The chain needs gamma > 0 N m/rad and mu > 0, got {gamma!r} and {mu!r}.")
    require_pd(loop)
    K_P, K_D = loop.controller.proportional, loop.controller.derivative
    halteres = Link(name="S halteres", reads="yaw angle [rad]", gives="yaw rate [rad/s]", numerator=(1.0, 0.0))
    neural = Link(
        name="C neural controller (PI on the rate, whole delay)", reads="yaw rate [rad/s]", gives="hinge bias [rad]",
        numerator=(K_D / (gamma * mu), K_P / (gamma * mu)), denominator=(1.0, 0.0), delay=loop.delay,
    )  # fmt: skip
    hinge = Link(name="M muscle and hinge", reads="hinge bias [rad]", gives="paddling angle [rad]", numerator=(mu,))
    paddling = Link(
        name="A paddling aerodynamics", reads="paddling angle [rad]", gives="torque [N m]", numerator=(gamma,)
    )
    body = Link(
        name="body", reads="torque [N m]", gives="yaw angle [rad]",
        numerator=(1.0,), denominator=(loop.plant.inertia, loop.plant.damping, 0.0),
    )  # fmt: skip
    return Chain(links=(halteres, neural, hinge, paddling, body))
