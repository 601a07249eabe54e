"""Files that appear whole or not at all: temporary names, fsync, then rename."""

from __future__ import annotations

import contextlib
import os
import re
import secrets
import shutil
from collections.abc import Generator, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

from flycontrol.errors import OutputError

_TEMPORARY = re.compile(r"\.(.+)\.[0-9a-f]{8}\.part")  #: as `_sibling` names them


@dataclass(frozen=True, slots=True)
class _Write:
    """One file on its way: complete under `temporary`, its earlier version kept under `earlier` if there was one."""

    target: Path
    temporary: Path
    earlier: Path | None


def require_writable_folder(path: Path) -> None:
    """Refuse an output folder that could not be written, before the work whose results it shall hold.

    The folder need not exist yet, and this function does not create it: nothing is left behind if the work fails.

    Parameters
    ----------
    path
        The folder that results will be written to.

    Raises
    ------
    OutputError
        If the path or one of its parents is no folder, or if no file can be created there.
    """
    parent = path.absolute()
    while not os.path.lexists(parent):
        parent = parent.parent
    if not parent.is_dir():
        below = "" if parent == path.absolute() else f"{path}: "
        raise OutputError(f"{below}{parent} is not a folder; choose another output folder.")
    probe = _sibling(parent / "probe")
    try:
        probe.touch(exist_ok=False)
        probe.unlink()
    except OSError as error:
        raise OutputError(f"{path}: no file can be created in {parent} ({_reason(error)}).") from error


@contextlib.contextmanager
def temporary_file(folder: Path, name: str) -> Generator[Path]:
    """Name a hidden file in a folder for what is too long for memory; `write_files_atomically` takes it over.

    The folder is created; at the end the file is removed, unless it was taken over, and folders that are empty again.

    Raises
    ------
    OutputError
        If the folder cannot be created.
    """
    created = _create_folder(folder)
    path = _sibling(folder / name)
    try:
        yield path
    finally:
        with contextlib.suppress(OSError):
            path.unlink(missing_ok=True)
        for empty in created:
            with contextlib.suppress(OSError):
                empty.rmdir()


def discard_torn(folder: Path, names: Iterable[str]) -> None:
    """Remove what killed processes left in a folder under temporary names.

    Parameters
    ----------
    folder
        Where nobody else writes now; it need not exist.
    names
        Of the files that were on their way.
    """
    names = set(names)
    for path in folder.glob(".*.part"):
        torn = _TEMPORARY.fullmatch(path.name)
        if torn is not None and torn[1] in names:
            with contextlib.suppress(OSError):
                path.unlink()


def write_files_atomically(folder: Path, files: Mapping[str, str | bytes | Path]) -> tuple[Path, ...]:
    """Write all files or none: on any failure earlier versions stay as they were and no temporary file remains.

    All contents are written and flushed to the disk under temporary names in the same folder; only then the files are
    renamed one after another, and a failing rename restores the versions that earlier ones replaced.

    Parameters
    ----------
    folder
        Where the files go; created with its parents if it does not exist.
    files
        File names, with folders inside of the folder where they have any, and their contents; text is written as
        UTF-8, and a path is a finished file in the same folder, which takes the name.

    Returns
    -------
    tuple of Path
        The files written, in the order given.

    Raises
    ------
    OutputError
        If anything could not be written: which file, and why.
    """
    created: list[Path] = []
    try:
        for parent in dict.fromkeys([folder, *((folder / name).parent for name in files)]):
            created = _create_folder(parent) + created
        _write_all([(folder / name, content) for name, content in files.items()])
    except BaseException:
        for empty in created:
            with contextlib.suppress(OSError):
                empty.rmdir()
        raise
    return tuple(folder / name for name in files)


def _create_folder(folder: Path) -> list[Path]:
    """Create the folder; return those that did not exist before, innermost first."""
    missing = [path for path in (folder, *folder.parents) if not os.path.lexists(path)]
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        for path in missing:
            with contextlib.suppress(OSError):
                path.rmdir()
        raise OutputError(f"{folder} cannot be created as an output folder ({_reason(error)}).") from error
    return missing


def _write_all(contents: list[tuple[Path, str | bytes | Path]]) -> None:
    writes = [
        _Write(
            path,
            content if isinstance(content, Path) else _sibling(path),
            _sibling(path) if os.path.lexists(path) else None,
        )
        for path, content in contents
    ]
    begun: list[_Write] = []
    stuck: list[_Write] = []
    current = Path()
    try:
        for write, (_, content) in zip(writes, contents, strict=True):
            current = write.target
            _prepare(write, content)
        for write in writes:
            current = write.target
            begun.append(write)
            write.temporary.replace(current)
    except BaseException as error:
        stuck = _restore(begun)
        if isinstance(error, OSError):
            raise OutputError(f"{current} could not be written: {_reason(error)}; {_what_remains(stuck)}.") from error
        raise
    finally:
        _discard(writes, stuck)
    _flush_folders({write.target.parent for write in writes})


def _prepare(write: _Write, content: str | bytes | Path) -> None:
    """Put the content on the disk under the temporary name, and a second name on what it will replace."""
    if not isinstance(content, Path):
        with write.temporary.open("xb") as file:
            file.write(content.encode() if isinstance(content, str) else content)
            file.flush()
            os.fsync(file.fileno())
    if write.earlier is not None:
        try:
            write.earlier.hardlink_to(write.target)
        except OSError:  # a file system without hard links
            shutil.copy2(write.target, write.earlier)


def _restore(begun: list[_Write]) -> list[_Write]:
    """Undo the renames that happened, last first; return those that could not be undone."""
    stuck: list[_Write] = []
    for write in reversed(begun):
        if write.temporary.exists():
            continue  # the rename that failed
        try:
            if write.earlier is None:
                write.target.unlink()
            else:
                write.earlier.replace(write.target)
        except OSError:
            stuck.append(write)
    return stuck


def _what_remains(stuck: list[_Write]) -> str:
    if not stuck:
        return "earlier results are unchanged"
    kept = [f"{write.target.name} (earlier version: {write.earlier or 'none'})" for write in stuck]
    return f"these files are new and could not be put back: {', '.join(kept)}"


def _discard(writes: list[_Write], stuck: list[_Write]) -> None:
    for write in writes:
        leftovers = (write.temporary,) if write in stuck else (write.temporary, write.earlier)
        for path in leftovers:
            if path is not None:
                with contextlib.suppress(OSError):
                    path.unlink(missing_ok=True)


def _flush_folders(folders: set[Path]) -> None:
    """Make the renames durable where the system can flush a folder; the files are complete either way."""
    for folder in folders:
        with contextlib.suppress(OSError):
            descriptor = os.open(folder, os.O_RDONLY)
            try:
                os.fsync(descriptor)
            finally:
                os.close(descriptor)


def _sibling(path: Path) -> Path:
    """Name a hidden file in the same folder, hence on the same file system: only there a rename is atomic."""
    return path.with_name(f".{path.name}.{secrets.token_hex(4)}.part")


def _reason(error: OSError) -> str:
    return error.strerror or str(error)
