"""A folder of analyses: one Python file a question, and validation.toml that says which are left out, and why."""

from __future__ import annotations

import ast
from dataclasses import dataclass
from pathlib import Path

from pydantic import Field

from flycontrol.errors import InvalidInputError
from flycontrol.io.text_files import read_text_file
from flycontrol.io.toml_files import Table, read_toml_file, structured

SETTINGS = "validation.toml"


class _Settings(Table):
    data: str = ""
    first: list[str] = Field(default_factory=list)
    left_out: dict[str, str] = Field(default_factory=dict)


@dataclass(frozen=True, slots=True, kw_only=True)
class Analysis:
    """One question."""

    name: str
    question: str  #: first line of the file
    path: Path
    sources: tuple[Path, ...]  #: the file, those beside it that it imports, directly or not, and files of other kinds


@dataclass(frozen=True, slots=True, kw_only=True)
class Analyses:
    """What a folder of analyses holds."""

    folder: Path
    data: Path | None  #: where its settings say that real measurements lie, whether they are there or not
    analyses: tuple[Analysis, ...]  #: in the order in which they should start
    left_out: dict[str, str]  #: why, by name


def read_analyses(folder: Path) -> Analyses:
    """Find the analyses of a folder.

    Raises
    ------
    InvalidInputError
        If there is no such folder, if it holds no analysis, or settings with a fault.
    """
    if not folder.is_dir():
        raise InvalidInputError(
            f"{folder}: there is no such folder of analyses; run the command where the folder analyses is, or name it "
            "by --analyses."
        )
    settings = _settings(folder)
    names = sorted(path.stem for path in folder.glob("*.py") if not path.stem.startswith("_"))
    missing = [name for name in dict.fromkeys([*settings.first, *settings.left_out]) if name not in names]
    if missing:
        what = f"no {missing[0]}.py" if len(missing) == 1 else f"no Python files of these {len(missing)} names"
        raise InvalidInputError(
            f"{folder / SETTINGS} names {', '.join(missing)}, but {folder} holds {what}; put them there, or take the "
            "names out."
        )
    wanted = [name for name in dict.fromkeys([*settings.first, *names]) if name not in settings.left_out]
    if not wanted:
        raise InvalidInputError(f"{folder} holds no analysis; name another folder by --analyses.")
    return Analyses(
        folder=folder,
        data=(folder / settings.data).resolve() if settings.data else None,
        analyses=tuple(_analysis(folder, name) for name in wanted),
        left_out=settings.left_out,
    )


def _settings(folder: Path) -> _Settings:
    path = folder / SETTINGS
    if not path.exists():
        return _Settings()
    toml = read_toml_file(path)
    return structured(_Settings, toml.data, toml)


def _analysis(folder: Path, name: str) -> Analysis:
    path = folder / f"{name}.py"
    said = (ast.get_docstring(_parsed(path)) or name.replace("_", " ")).splitlines()
    return Analysis(name=name, question=said[0], path=path, sources=_sources(folder, name))


def _sources(folder: Path, name: str) -> tuple[Path, ...]:
    """The file, its neighbours that it imports, and data beside it: their change changes what it finds."""
    found: list[Path] = []
    wanted = [name]
    while wanted:
        path = folder / f"{wanted.pop()}.py"
        if path.exists() and path not in found:
            found.append(path)
            wanted += _imported(path)
    beside = [path for path in folder.iterdir() if path.is_file() and path.suffix not in (".py", ".toml")]
    return tuple(sorted([*found, *(path for path in beside if not path.name.startswith("."))]))


def _imported(path: Path) -> list[str]:
    """First names of the modules that a file imports."""
    names: list[str] = []
    for node in ast.walk(_parsed(path)):
        if isinstance(node, ast.Import):
            names += [alias.name.partition(".")[0] for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and node.module:
            names.append(node.module.partition(".")[0])
    return names


def _parsed(path: Path) -> ast.Module:
    """A file that is no Python is found out when it is run."""
    try:
        return ast.parse(read_text_file(path).text)
    except SyntaxError:
        return ast.Module(body=[], type_ignores=[])
