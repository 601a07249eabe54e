"""Memory does not grow with the length of a film."""

import tracemalloc

import film_files as written_as
import numpy as np
import pytest

from flycontrol.io.movies.open_films import open_films

ROWS, COLUMNS, SHORT, LONG = 160, 200, 60, 300
KNOWN = 4000  #: bytes that are kept of each frame, its name or its place, however many pixels it has
FORMS = {
    "png": lambda to, film: written_as.write_stills(to, film, ".png"),
    "pages": written_as.write_pages,
    "npy": written_as.write_npy,
    "npz": written_as.write_npz,
    "sparse 7.3": lambda to, film: written_as.write_sparse_film(to, film, film[0, 0] * 0, "7.3"),
}


def bright_spots(count):
    """(count, 1, 160, 200)."""
    film = np.zeros((count, 1, ROWS, COLUMNS), dtype=np.uint8)
    for k in range(count):
        film[k, 0, k % 50 : k % 50 + 8, k % 70 : k % 70 + 9] = 50 + k % 200
    return film


def most_memory(inputs):
    """Bytes that Python and NumPy held at most while a film was read from end to end."""
    tracemalloc.start()
    try:
        opened = open_films(inputs)
        for k in range(len(opened.films[0])):
            opened.films[0].image(k)
        return tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()


@pytest.mark.parametrize("form", FORMS)
def test_a_film_five_times_as_long_takes_no_more_memory_to_read(tmp_path, form):
    """But for what is known of each frame; one whole frame a frame would be 32,000 bytes."""
    write = FORMS[form]
    open_films(write(tmp_path / "first", bright_spots(20)))  # what is imported and started once
    short = most_memory(write(tmp_path / "short", bright_spots(SHORT)))
    long = most_memory(write(tmp_path / "long", bright_spots(LONG)))
    assert long - short < KNOWN * (LONG - SHORT)
