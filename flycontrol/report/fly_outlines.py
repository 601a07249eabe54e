"""Outlines of body and wings as they are seen from a direction: what an animation draws."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from flycontrol.model.morphology import Morphology, pitch_rotation
from flycontrol.model.stroke import Side, wing_axes
from flycontrol.model.trajectory import Trajectory, rotation_matrices

FloatArray = NDArray[np.float64]

_ROUND = 48  #: points of an ellipse
_ALONG = 24  #: of a wing's edge
_WIDEST = 2.5  #: mean chords, where a beta distribution has no bound


class View(NamedTuple):
    """A direction to look from: what points to the right, upward and to the viewer, world axes."""

    name: str
    across: tuple[float, float, float]
    up: tuple[float, float, float]
    near: tuple[float, float, float]


#: The world's y points to the left of a fly that looks along x.
VIEWS = (
    View("from above", (1, 0, 0), (0, 1, 0), (0, 0, 1)),
    View("from its right", (1, 0, 0), (0, 0, 1), (0, -1, 0)),
    View("from behind", (0, -1, 0), (0, 0, 1), (-1, 0, 0)),
)


@dataclass(frozen=True, slots=True)
class FlyOutlines:
    """Wings as shapes in space, body and head as ellipsoids, about the body's centre of mass."""

    body: FloatArray  #: (N, 3, 3) squared semi-axes as a matrix, world axes [m^2]
    head: FloatArray  #: (N, 3) its middle [m]
    head_radius: float  #: [m]
    wings: dict[Side, FloatArray]  #: (N, M, 3) closed edge, leading edge first [m]

    def body_seen(self, k: int, view: View) -> FloatArray:
        """Outline of the body in a view, (M, 2) [m]: x = sqrt(P A P^T) (cos, sin)."""
        across = np.array([view.across, view.up])
        values, vectors = np.linalg.eigh(across @ self.body[k] @ across.T)
        turn = np.linspace(0, 2 * np.pi, _ROUND)
        return np.stack([np.cos(turn), np.sin(turn)], axis=1) @ (vectors * np.sqrt(values)).T

    def wing_seen(self, k: int, side: Side, view: View) -> FloatArray:
        """Edge of a wing in a view, (M, 2) [m]."""
        return self.wings[side][k] @ np.array([view.across, view.up]).T

    def head_seen(self, k: int, view: View) -> FloatArray:
        """Middle of the head in a view, (2,) [m]."""
        return np.array([view.across, view.up]) @ self.head[k]

    def far_to_near(self, k: int, view: View) -> list[str]:
        """Names of the parts, farthest from the viewer first."""
        near = np.array(view.near)
        depth = {"body": 0.0, "head": float(near @ self.head[k])}
        depth |= {side: float(near @ self.wings[side][k].mean(axis=0)) for side in self.wings}
        return sorted(depth, key=lambda part: depth[part])


def fly_outlines(morphology: Morphology, flight: Trajectory) -> FlyOutlines:
    """The fly at each instant of a flight.

    The body is the even ellipsoid that has its mass and inertia: A = 5 / m (tr I / 2 - I).
    """
    to_world = rotation_matrices(flight.q_WS)
    inertia = morphology.inertia_S
    mass = morphology.mass - 2 * morphology.wing_body.mass
    squares = 5 / mass * (np.trace(inertia) / 2 * np.eye(3) - inertia)
    ahead = pitch_rotation(morphology.stroke_plane_angle) @ np.array([1.0, 0.0, 0.0])
    long, narrow = (float(np.sqrt(value)) for value in np.linalg.eigvalsh(squares)[[-1, 0]])
    wings: dict[Side, FloatArray] = {
        "left": _wing(morphology, flight, "left", to_world),
        "right": _wing(morphology, flight, "right", to_world),
    }
    return FlyOutlines(
        body=to_world @ squares @ np.swapaxes(to_world, 1, 2),
        head=to_world @ (0.85 * long * ahead),
        head_radius=0.75 * narrow,
        wings=wings,
    )


def _wing(morphology: Morphology, flight: Trajectory, side: Side, to_world: FloatArray) -> FloatArray:
    axes = wing_axes(flight.wing(side), side)
    hinge = np.array(morphology.right_hinge) * (1.0, 1.0 if side == "right" else -1.0, 1.0)
    x = (1 - np.cos(np.linspace(0.05, np.pi - 0.05, _ALONG))) / 2
    chord = np.minimum(morphology.planform.chord(x), _WIDEST * morphology.mean_chord)
    along = np.concatenate([x, x[::-1]]) * morphology.wing_length
    across = np.concatenate([morphology.pitch_axis * chord, -(1 - morphology.pitch_axis) * chord[::-1]])
    edge = hinge + along[:, None] * axes.span[:, None] + across[:, None] * axes.chord[:, None]
    return np.einsum("nij,nmj->nmi", to_world, edge)
