"""A table of a TOML file by its dotted name, and where the files that it names lie."""

from __future__ import annotations

from pathlib import Path
from typing import Any, cast

from flycontrol.errors import InvalidInputError
from flycontrol.io.toml_files import TomlFile


def table_at(toml: TomlFile, within: str) -> dict[str, Any]:
    """Find the table `within` of a file, "morphology"; empty: the whole file; InvalidInputError if it is no table."""
    found: Any = toml.data
    for key in filter(None, within.split(".")):
        found = found.get(key, {}) if isinstance(found, dict) else found
    if not isinstance(found, dict):
        raise InvalidInputError(f"{toml.where(*within.split('.'))}: {within} is {found!r}; a table is needed.")
    return cast("dict[str, Any]", found)


def folder_of(toml: TomlFile, folder: Path | None) -> Path:
    """Where the files that a TOML file names are looked for: the folder given, or that of the TOML file."""
    return Path(toml.file.name).parent if folder is None else folder
