"""Films of all cameras, from whatever files they lie in."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from flycontrol.errors import InvalidInputError
from flycontrol.io.movies.inputs import CameraFiles, camera_files
from flycontrol.io.movies.numpy_films import npy_films, npz_films
from flycontrol.io.movies.recorded import Recorded
from flycontrol.io.movies.recorded_film import film_of
from flycontrol.io.movies.sparse_movies import SparseMovie, open_sparse_movie
from flycontrol.io.movies.stills import stills_of
from flycontrol.io.movies.tiff_pages import TiffPages
from flycontrol.io.movies.together import distinct_names, one_rate, shared_spans
from flycontrol.io.movies.video import Video
from flycontrol.model.film import Film

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class OpenedFilms:
    """Films of C cameras and of equal length."""

    films: tuple[Film, ...]
    frame_rate: float | None  #: [1/s], where the files say it
    backgrounds: tuple[FloatArray | None, ...]  #: (rows, columns) of each camera whose file has one
    notes: tuple[str, ...] = ()  #: sentences about what was decided in reading


@dataclass(frozen=True, slots=True)
class _Found:
    recorded: tuple[Recorded, ...]
    frame_rate: float | None = None
    notes: tuple[str, ...] = field(default=())


def open_films(
    inputs: Sequence[Path | str],
    *,
    binary: bool | None = None,
    packed: bool | None = None,
    variable: str | None = None,
) -> OpenedFilms:
    """Open the films that paths name; frames are read when they are asked for.

    Parameters
    ----------
    inputs
        A folder with a sub-folder of stills for each camera, or with a file for each; or for each camera a folder, a
        pattern or a file; or one .npy or .npz file of all cameras. `docs/films.md` has examples.
    binary
        Whether the frames are silhouettes; by default those are that are boolean, packed, or have two values only.
    packed
        Whether arrays are masks packed into bits; by default those are whose names end with "packed".
    variable
        The array of a .npz file that is the film, where several could be.

    Raises
    ------
    InvalidInputError
        If a path is no film, if a variable is named where no file has any, if a file is damaged at its beginning, or if
        the cameras' films differ in length. Frames that are damaged raise when they are asked for.
    """
    named = camera_files(inputs)
    if variable is not None and all(files.kind != "npz" for files in named):
        raise InvalidInputError(
            f"--film-variable {variable} names an array of a .npz file, but {named[0].files[0].name} is none; leave it "
            "out."
        )
    found = [_read(files, packed, variable) for files in named]
    recorded = [camera for item in found for camera in item.recorded]
    notes = [note for item in found for note in item.notes]
    spans, begun = shared_spans(recorded)
    names = distinct_names([camera.name for camera in recorded])
    films = [film_of(*each, binary) for each in zip(names, recorded, spans, strict=True)]
    notes += begun + [note for film in films if (note := film.note)]
    return OpenedFilms(
        films=tuple(films),
        frame_rate=one_rate([(camera.name, item.frame_rate) for item in found for camera in item.recorded]),
        backgrounds=tuple(
            _background(camera) if film.rule is None else None for camera, film in zip(recorded, films, strict=True)
        ),
        notes=tuple(notes),
    )


def _background(camera: Recorded) -> FloatArray | None:
    known = camera.background if isinstance(camera, SparseMovie) else None
    return None if known is None else known.astype(np.float64)


def _read(camera: CameraFiles, packed: bool | None, variable: str | None) -> _Found:
    path = camera.files[0]
    if camera.kind == "stills":
        return _Found((stills_of(camera.name, camera.files),))
    if camera.kind == "tiff":
        return _Found((TiffPages(camera.name, path),))
    if camera.kind == "npy":
        films = npy_films(path, packed=packed)
        return _Found(films.cameras, films.frame_rate)
    if camera.kind == "npz":
        films = npz_films(path, packed=packed, variable=variable)
        return _Found(films.cameras, films.frame_rate)
    if camera.kind == "mat":
        movie = open_sparse_movie(path)
        return _Found((movie,), movie.frame_rate, movie.notes)
    video = Video(path)
    return _Found((video,), video.frame_rate, video.notes)
