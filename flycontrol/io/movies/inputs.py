"""What the paths that a user names are: which files belong to which camera."""

from __future__ import annotations

import glob
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from flycontrol.errors import InvalidInputError
from flycontrol.io.movies.natural_order import natural_key, numbers, words
from flycontrol.io.movies.picture import FORMATS
from flycontrol.io.movies.tiff_pages import page_count

Kind = Literal["stills", "tiff", "npy", "npz", "mat", "video"]

VIDEOS = (".avi", ".mp4", ".mov", ".mkv", ".cine", ".m4v", ".wmv", ".webm")
READ_HERE = (
    "stills (.png, .tif, .bmp, .jpg) in a folder for each camera, .tif of many pages, .npy, .npz, sparse movies (.mat) "
    "and video (.avi, .mp4, .mov, .mkv, .cine)"
)
_KINDS: dict[str, Kind] = {".npy": "npy", ".npz": "npz", ".mat": "mat", **dict.fromkeys(VIDEOS, "video")}
_TIFF = (".tif", ".tiff")
_MOST_CAMERAS = 16


@dataclass(frozen=True, slots=True)
class CameraFiles:
    """Files of one kind: the stills of one camera, or a single file of one camera or more."""

    name: str
    kind: Kind
    files: tuple[Path, ...]


def camera_files(inputs: Sequence[Path | str]) -> tuple[CameraFiles, ...]:
    """Sort out folders, files and patterns, in the order in which they are named.

    Raises
    ------
    InvalidInputError
        If something is not there, is of no known kind, or is named twice; if a folder has no images.
    """
    if not inputs:
        raise InvalidInputError(f"No film is named; there may be {READ_HERE}.")
    named = [_named(Path(given)) for given in inputs]
    alone = named[0].folder if len(named) == 1 else None
    found = _several(named) if alone is None else _all_in(alone)
    _refuse_twice(found)
    return tuple(found)


@dataclass(frozen=True, slots=True)
class _Named:
    """What one path stands for: a folder, files that a pattern matches, or a file."""

    title: str
    folder: Path | None = None
    files: tuple[Path, ...] = ()
    pattern: bool = False


def _named(path: Path) -> _Named:
    text = str(path)
    if "\0" in text:
        raise InvalidInputError(f"{text!r} is no name of a file.")
    try:
        if path.is_dir():
            return _Named(path.name or path.resolve().name, folder=path)
        if path.is_file():
            return _Named(path.stem, files=(path,))
        there = path.exists()
    except OSError as error:
        raise InvalidInputError(f"{text[:100]!r} cannot be read: {error.strerror or error}.") from error
    if there:
        raise InvalidInputError(f"{path} is no regular file; save the film in one.")
    if not glob.has_magic(text):
        raise InvalidInputError(f"{path}: there is no such file or folder.")
    matched = [Path(name) for name in glob.glob(text, recursive=True)]  # noqa: PTH207 (a pattern may be absolute)
    files = sorted((file for file in matched if file.is_file() and _is_read(file)), key=_in_order)
    if not files:
        raise InvalidInputError(f"No image and no film matches {text!r}; check the folder and the pattern.")
    return _Named(path.name, files=tuple(files), pattern=True)


def _several(named: Sequence[_Named]) -> list[CameraFiles]:
    """A camera for each folder and pattern; stills that are named one by one are sorted into cameras together."""
    loose = {file for item in named if not item.pattern for file in item.files if _is_still(file)}
    found: list[CameraFiles] = []
    for item in named:
        if item.folder is not None:
            found.append(_camera_in(item.folder))
        elif item.pattern:
            found += _matched(item)
        elif item.files[0] not in loose:
            found.append(_movie(item.files[0]))
    return found + _sorted_out(sorted(loose, key=_in_order))


def _all_in(folder: Path) -> list[CameraFiles]:
    """The cameras in a folder: its sub-folders, else its films, else its stills by their names."""
    inner = [path for path in _listed(folder) if path.is_dir()]
    cameras = [path for path in inner if any(_is_read(file) for file in _listed(path) if file.is_file())]
    if cameras:
        return [_camera_in(path) for path in cameras]
    files = [file for file in _listed(folder) if file.is_file() and _is_read(file)]
    movies = _movies(files)
    if movies:
        return [_movie(file) for file in movies]
    if not files:
        raise InvalidInputError(f"{folder} holds no images and no films; there may be {READ_HERE}.")
    return _sorted_out(files)


def _camera_in(folder: Path) -> CameraFiles:
    """The one camera in a folder: all its stills, or one film."""
    files = [file for file in _listed(folder) if file.is_file() and _is_read(file)]
    movies = _movies(files)
    if len(movies) == 1:
        return _movie(movies[0])
    if movies:
        raise InvalidInputError(
            f"{folder} holds {len(movies)} films, {movies[0].name} and others, where one camera is expected; name the "
            "files, or this folder alone."
        )
    if not files:
        raise InvalidInputError(f"{folder} holds no images; there may be {READ_HERE}.")
    return CameraFiles(folder.name or folder.resolve().name, "stills", tuple(files))


def _matched(item: _Named) -> list[CameraFiles]:
    """What a pattern names: one camera of stills for each folder, or films."""
    movies = _movies(list(item.files))
    if movies:
        return [_movie(file) for file in movies]
    folders = sorted({file.parent for file in item.files}, key=natural_key)
    return [
        CameraFiles(
            item.title if len(folders) == 1 else folder.name,
            "stills",
            tuple(file for file in item.files if file.parent == folder),
        )
        for folder in folders
    ]


def _sorted_out(stills: Iterable[Path]) -> list[CameraFiles]:
    """Sort stills into cameras by their folders, by the words in their names, and by a number that takes few values."""
    groups: dict[tuple[Path, tuple[str, ...]], list[Path]] = {}
    for file in stills:
        groups.setdefault((file.parent, words(file)), []).append(file)
    found: list[CameraFiles] = []
    for (folder, _), files in sorted(groups.items(), key=lambda item: (natural_key(item[0][0]), item[0][1])):
        column = _camera_number(files)
        if column is None:
            alone = len({key[0] for key in groups}) == len(groups)
            title = folder.resolve().name if alone else _title(files, None)
            found.append(CameraFiles(title, "stills", tuple(files)))
            continue
        for camera in sorted({numbers(file)[column] for file in files}):
            own = tuple(file for file in files if numbers(file)[column] == camera)
            found.append(CameraFiles(_title(own, column), "stills", own))
    if len(found) > _MOST_CAMERAS:
        folder = found[0].files[0].parent
        raise InvalidInputError(
            f"{folder}: the names of the stills do not tell which belong to one camera, {found[0].files[0].name} and "
            f"{found[1].files[0].name}; put each camera's in a folder of its own, or name a pattern for each."
        )
    return found


def _camera_number(files: Sequence[Path]) -> int | None:
    """Which of the numbers in names such as cam2_0041 is the camera's; None if only one of them varies."""
    values = [set(column) for column in zip(*map(numbers, files), strict=True)]
    varying = [k for k, found in enumerate(values) if len(found) > 1]
    if len(varying) < 2:
        return None
    counter = max(varying, key=lambda k: (len(values[k]), k))
    if len(values[counter]) == len(files):  # it counts all of them: beside it stands a clock, no camera
        return None
    few = [k for k in varying if k != counter and len(values[k]) <= _MOST_CAMERAS]
    return few[0] if len(few) == 1 and len(varying) == 2 else None


def _title(files: Sequence[Path], column: int | None) -> str:
    """What the names of one camera's stills have in common: "cam2" of cam2_0041 and cam2_0042."""
    if column is not None:
        word = words(files[0])[column].strip(" _-.") or "camera "
        return f"{word}{numbers(files[0])[column]}"
    return words(files[0])[0].strip(" _-.") or files[0].resolve().parent.name


def _movies(files: Sequence[Path]) -> list[Path]:
    """The films among files: of .mat files those named sparse, if any is, since calibrations lie beside them."""
    movies = [file for file in files if not _is_picture(file)]
    sparse = [file for file in movies if file.suffix.lower() == ".mat" and "sparse" in file.stem.lower()]
    movies = [file for file in movies if not sparse or file.suffix.lower() != ".mat" or file in sparse]
    first = next((file for file in files if file.suffix.lower() in _TIFF), None)
    if first is not None and page_count(first) > 1:
        movies += [file for file in files if file.suffix.lower() in _TIFF]
    return sorted(movies, key=_in_order)


def _movie(file: Path) -> CameraFiles:
    kind = _KINDS.get(file.suffix.lower()) or ("tiff" if file.suffix.lower() in _TIFF else None)
    if kind is None:
        raise InvalidInputError(f"{file}: films are {READ_HERE}, not {file.suffix or 'files without ending'}.")
    return CameraFiles(file.stem, kind, (file,))


def _listed(folder: Path) -> list[Path]:
    try:
        found = [path for path in folder.iterdir() if not path.name.startswith(".")]
    except OSError as error:
        raise InvalidInputError(f"{folder} cannot be read: {error.strerror or error}.") from error
    return sorted(found, key=_in_order)


def _in_order(path: Path) -> tuple[tuple[tuple[int, str | int], ...], ...]:
    return tuple(natural_key(Path(part)) for part in path.parts)


def _is_picture(file: Path) -> bool:
    return file.suffix.lower() in FORMATS


def _is_still(file: Path) -> bool:
    return _is_picture(file) and not (file.suffix.lower() in _TIFF and page_count(file) > 1)


def _is_read(file: Path) -> bool:
    return _is_picture(file) or file.suffix.lower() in _KINDS


def _refuse_twice(found: Sequence[CameraFiles]) -> None:
    seen: set[Path] = set()
    for file in (file for camera in found for file in camera.files):
        real = file.resolve()
        if real in seen:
            raise InvalidInputError(f"{file} is named twice; each camera's film counts once.")
        seen.add(real)
