"""A tracker's results and memory as plain lists, records and arrays, bit for bit, and back."""

from __future__ import annotations

from collections import deque
from dataclasses import fields, is_dataclass
from typing import Any, cast

import numpy as np

from flycontrol.errors import InvalidParameterError
from flycontrol.jobs.packed import Result
from flycontrol.vision.fly_shape import FlyShape
from flycontrol.vision.fly_size import SizedFly
from flycontrol.vision.follower import Fly, Follower
from flycontrol.vision.silhouette_fit import Agreement, SilhouetteFit
from flycontrol.vision.size_fit import Sizes
from flycontrol.vision.stance import Stance
from flycontrol.vision.tracked_frame import TrackedFrame

_IS = "is"
_KINDS = {
    kind.__name__: kind for kind in (Agreement, Fly, FlyShape, SilhouetteFit, SizedFly, Sizes, Stance, TrackedFrame)
}
_GIVEN = ("cameras", "fly", "refine")  #: what a follower is told, not what it remembers


def kept(value: Any) -> Result:
    """A value as what `flycontrol.jobs.packed` keeps; InvalidParameterError for a kind that is not known here."""
    if is_dataclass(value) and type(value).__name__ in _KINDS:
        return {_IS: type(value).__name__} | {f.name: kept(getattr(value, f.name)) for f in fields(value)}
    if isinstance(value, list | tuple | deque):
        return [kept(part) for part in cast("list[Any]", value)]
    if value is None or isinstance(value, bool | int | float | str | np.ndarray | np.generic):
        return value
    raise InvalidParameterError(f"A tracker's memory holds a {type(value).__name__}, which is not kept here.")


def restored(tree: Any) -> Any:
    """The value that `kept` was given, tuples in place of lists."""
    if isinstance(tree, list):
        return tuple(restored(part) for part in cast("list[Any]", tree))
    if isinstance(tree, dict):
        named = cast("dict[str, Any]", tree)
        return _KINDS[named[_IS]](**{name: restored(part) for name, part in named.items() if name != _IS})
    return tree


def memory_of(follower: Follower) -> Result:
    """All that a follower remembers."""
    return {f.name: kept(getattr(follower, f.name)) for f in fields(follower) if f.name not in _GIVEN}


def remind(follower: Follower, memory: dict[str, Any]) -> None:
    """Give a follower what another one remembered."""
    for name, tree in memory.items():
        value, now = restored(tree), getattr(follower, name)
        setattr(follower, name, deque(value, maxlen=now.maxlen) if isinstance(now, deque) else value)
