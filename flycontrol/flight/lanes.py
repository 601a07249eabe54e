"""Flies and strokes laid out lane by lane, for the march of many flights at once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flycontrol.errors import InvalidParameterError
from flycontrol.flight.flapping_fly import FlappingFly
from flycontrol.flight.kernels.lanes import LANE_DRIVE, LANES
from flycontrol.flight.multibody.constants import constants_of
from flycontrol.flight.multibody.freedoms import Prescribed
from flycontrol.model.stroke_kinematics import StrokeKinematics

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class LaneConstants:
    """Arrays for `kernels.lanes`, flies fastest."""

    free: FloatArray  #: (6,)
    gravity: FloatArray  #: (3,)
    body: FloatArray  #: (10 * LANES,)
    wings: FloatArray  #: (2 * 20 * LANES,)
    blades: FloatArray  #: (2 * nodes * 4 * LANES,)
    polynomials: FloatArray  #: (5, k)

    @property
    def arguments(self) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray, FloatArray, FloatArray]:
        """In the kernel's order."""
        return (self.free, self.gravity, self.body, self.wings, self.blades, self.polynomials)


def lane_constants(flies: Sequence[FlappingFly], strokes: Sequence[StrokeKinematics]) -> LaneConstants:
    """Constants of LANES flies; InvalidParameterError where they differ in what lanes must share."""
    each = [constants_of(fly, stroke.frequency) for fly, stroke in zip(flies, strokes, strict=True)]
    nodes = flies[0].air.nodes
    _refuse_free_wings(flies)
    alike = all(
        fly.body == flies[0].body
        and fly.gravity_W == flies[0].gravity_W
        and fly.air.nodes == nodes
        and np.array_equal(own.polynomials, each[0].polynomials)
        for fly, own in zip(flies, each, strict=True)
    )
    if not alike:
        raise InvalidParameterError(
            "Flies that are simulated together must share body freedoms, gravity, coefficients, centre of pressure and "
            "the number of blades; simulate the others apart."
        )
    return LaneConstants(
        free=each[0].free,
        gravity=each[0].gravity,
        body=in_lanes([own.body for own in each]),
        wings=in_lanes([own.wings for own in each]),
        blades=in_lanes([own.blades[:, :, :nodes].transpose(0, 2, 1) for own in each]),
        polynomials=each[0].polynomials,
    )


def in_lanes(arrays: Sequence[FloatArray]) -> FloatArray:
    """Flatten LANES arrays of one shape, lanes fastest."""
    return np.ascontiguousarray(np.stack([array.ravel() for array in arrays], axis=-1)).ravel()


def drive_in_lanes(drives: Sequence[FloatArray]) -> FloatArray:
    """(2 n + 1, 18 * LANES) from LANES drive tables (2 n + 1, 2, 12)."""
    rows = len(drives[0])
    wings = [drive[:, :, :LANE_DRIVE].reshape(rows, -1) for drive in drives]
    return np.ascontiguousarray(np.stack(wings, axis=-1)).reshape(rows, -1)


def filled_up(items: Sequence, count: int = LANES) -> list:
    """The items, the last one repeated until there are LANES."""
    return [*items, *[items[-1]] * (count - len(items))]


def _refuse_free_wings(flies: Sequence[FlappingFly]) -> None:
    joints = [joint for fly in flies for hinge in (fly.left, fly.right) for joint in hinge.joints]
    if not all(isinstance(joint, Prescribed) for joint in joints):
        raise InvalidParameterError(
            "Flies are simulated together with prescribed wings only; use simulate_flight for driven or sprung hinges."
        )
