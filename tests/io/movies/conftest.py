"""A tiny film of a dark rectangle that wanders over a bright, uneven background, and its silhouettes."""

import numpy as np
import pytest

FRAMES, CAMERAS, ROWS, COLUMNS = 12, 3, 24, 32


@pytest.fixture(scope="session")
def masks():
    """(12, 3, 24, 32); no two frames are alike."""
    v, u = np.mgrid[:ROWS, :COLUMNS]
    k, c = np.mgrid[:FRAMES, :CAMERAS][..., None, None]
    return (np.abs(v - 6 - c - k % 5) < 3 + c) & (np.abs(u - 5 - 2 * k) < 4)


@pytest.fixture(scope="session")
def background():
    """(24, 32), without a 0."""
    v, u = np.mgrid[:ROWS, :COLUMNS]
    return (180 + 2 * (v % 7) + u % 11).astype(np.uint8)


@pytest.fixture(scope="session")
def film(masks, background):
    """(12, 3, 24, 32), grey."""
    k = np.arange(FRAMES, dtype=np.uint8)[:, None, None, None]
    return np.where(masks, 20 + k, background).astype(np.uint8)
