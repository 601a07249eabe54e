"""Whether the same cameras in another order would fit the silhouettes."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations, permutations

from flycontrol.model.camera import Camera
from flycontrol.vision.checks.calibration_check import check_calibration
from flycontrol.vision.views import BoolArray

_ALL = 4  #: cameras up to which all orders are tried, 24; of more cameras two are exchanged
_BETTER = 4.0  #: times by which another order must fit better to be told (C)


@dataclass(frozen=True, slots=True, kw_only=True)
class OtherOrder:
    """An order that fits much better than the one given."""

    order: tuple[int, ...]  #: numbers of the cameras, from 0, in the order of the films
    residual: float  #: of the worst pair, median over frames [px]

    def __str__(self) -> str:
        """As in "in the order 2, 1, 3 they would fit to 0.2 px"."""
        numbers = ", ".join(str(number + 1) for number in self.order)
        return f"in the order {numbers} they would fit to {self.residual:.2g} px"


def fitting_order(
    frames: Sequence[Sequence[BoolArray]], cameras: Sequence[Camera], residual: float
) -> OtherOrder | None:
    """The order of the cameras that fits best, if it fits at least four times better than the one given.

    Parameters
    ----------
    frames : frames of C boolean images (rows, columns)
    cameras : C cameras as given
    residual : of the worst pair as given [px]
    """
    others = [
        OtherOrder(
            order=order,
            residual=max(pair.median for pair in check_calibration(frames, [cameras[k] for k in order]).pairs),
        )
        for order in _orders(len(cameras))
        if all(cameras[k].shape == camera.shape for k, camera in zip(order, cameras, strict=True))
    ]
    best = min(others, key=lambda other: other.residual, default=None)
    return best if best is not None and _BETTER * best.residual <= residual else None


def _orders(count: int) -> Iterator[tuple[int, ...]]:
    """All orders but the one given."""
    if count <= _ALL:
        yield from list(permutations(range(count)))[1:]
        return
    for a, b in combinations(range(count), 2):
        order = list(range(count))
        order[a], order[b] = b, a
        yield tuple(order)
