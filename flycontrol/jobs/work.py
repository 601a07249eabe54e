"""results[i] = task(items[i], generator_i): what is to be done, whoever does it and in whatever order."""

from __future__ import annotations

import operator
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from flycontrol.errors import InvalidParameterError
from flycontrol.jobs.packed import Packing, Result

Task = Callable[[Any, np.random.Generator], Result]
_PARTS, _LARGEST_CHUNK = 64, 256


@dataclass(frozen=True, slots=True, kw_only=True)
class Work:
    """results[i] = task(items[i], Generator(PCG64(SeedSequence(seed, spawn_key=(i,))))).

    A result depends on its item, its place and the seed alone: not on the workers, not on the chunks, and not on what
    the same worker did before. The task keeps it so by changing neither its item nor anything global.

    Raises
    ------
    InvalidParameterError
        If the seed is not an integer >= 0 or the chunk not an integer > 0.
    """

    task: Task  #: called with an item and its generator; a function at the top level of a module, or a partial of one
    items: Sequence[Any]  #: anything with a length and slices, `range(1000)` for instance; must pickle
    seed: int
    chunk: int = 0  #: items that are done, sent and saved together; 0 makes 64 chunks of at most 256 items
    name: str = "items"  #: what the items are, for progress and messages: "bootstrap fits"

    def __post_init__(self) -> None:
        _require_count("seed", self.seed)
        _require_count("chunk", self.chunk)

    @property
    def chunk_size(self) -> int:
        """Items in every chunk but the last; it depends on the number of items, never on the workers."""
        return self.chunk or min(max(1, -(-len(self.items) // _PARTS)), _LARGEST_CHUNK)

    @property
    def chunks(self) -> int:
        """Number of chunks."""
        return -(-len(self.items) // self.chunk_size)

    def items_of(self, chunk: int) -> Sequence[Any]:
        """Return the items of one chunk."""
        return self.items[self.start_of(chunk) : self.start_of(chunk + 1)]

    def start_of(self, chunk: int) -> int:
        """Return the place of the chunk's first item."""
        return chunk * self.chunk_size


def packed_results(task: Task, items: Sequence[Any], start: int, seed: int) -> bytes:
    """Do one chunk, in whichever process this is.

    Parameters
    ----------
    task, items, seed
        As in `Work`, the items of this chunk only.
    start
        Place of the first of them.

    Returns
    -------
    bytes
        The results, as `packed.unpacked` reads them.

    Raises
    ------
    InvalidParameterError
        If a result cannot be packed; and whatever the task raises.
    """
    packing = Packing()
    for i, item in enumerate(items, start):
        packing.add(task(item, generator(seed, i)), f"the result of item {i}")
    return packing.to_bytes()


def generator(seed: int, i: int) -> np.random.Generator:
    """Return the generator of item i: child i of SeedSequence(seed)."""
    return np.random.Generator(np.random.PCG64(np.random.SeedSequence(seed, spawn_key=(i,))))


def _require_count(name: str, value: object) -> None:
    try:
        fine = not isinstance(value, bool) and operator.index(value) >= 0  # type: ignore[arg-type]
    except TypeError:
        fine = False
    if not fine:
        raise InvalidParameterError(f"{name} must be an integer >= 0, got {value!r}.")
