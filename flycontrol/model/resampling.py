"""Which wingbeats a moving-block bootstrap draws: neighbours stay together, since wingbeats remember one another."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def wrapped_blocks(n: int, block: int, draws: int, rng: np.random.Generator) -> NDArray[np.intp]:
    """(draws, n) indices of blocks that wrap round at the end, so that every wingbeat is drawn equally often.

    Parameters
    ----------
    n : wingbeats
    block : wingbeats kept together
    draws : how often n wingbeats are drawn
    rng : where starts of blocks come from
    """
    length = min(block, n)
    starts = rng.integers(0, n, size=(draws, -(-n // length)))
    return ((starts[..., None] + np.arange(length)) % n).reshape(draws, -1)[:, :n]
