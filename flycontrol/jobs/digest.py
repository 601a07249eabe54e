"""One hash of many files: names and bytes."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from pathlib import Path


def digest_of(files: Mapping[str, Path]) -> str:
    """SHA-256 over names and contents of files, whatever their order and where they lie; OSError as it comes."""
    total = hashlib.sha256()
    for name, path in sorted(files.items()):
        total.update(f"{name}\0{hashlib.sha256(path.read_bytes()).hexdigest()}\n".encode())
    return total.hexdigest()


def files_below(folder: Path, *, besides: tuple[str, ...] = ("__pycache__",)) -> dict[str, Path]:
    """All files of a folder by their paths in it; those in folders of the given names and hidden ones left out."""
    found: dict[str, Path] = {}
    for path in folder.rglob("*"):
        parts = path.relative_to(folder).parts
        if path.is_file() and not any(part in besides or part.startswith(".") for part in parts):
            found["/".join(parts)] = path
    return found


def stamp_of(paths: Sequence[Path]) -> str:
    """SHA-256 over sizes and times of change of files, or of all files in folders: quick, however large they are."""
    total = hashlib.sha256()
    for path in paths:
        for file in sorted(path.rglob("*")) if path.is_dir() else [path]:
            if file.is_file():
                told = file.stat()
                total.update(f"{file.name} {told.st_size} {told.st_mtime_ns}\n".encode())
    return total.hexdigest()
