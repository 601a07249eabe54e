"""Fly files: their tables, the ones that the package ships, and a user's file laid over the default one."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Any

from pydantic import Field

from flycontrol.errors import InvalidInputError
from flycontrol.io.entries import Entry, QuantityEntry
from flycontrol.io.text_files import text_file
from flycontrol.io.toml_files import Table, TomlFile, parse_toml, read_toml_file, structured

DEFAULT = "fly"
_SECTIONS = ("fly", "controller", "pulse", "damping_range")  #: those that a user's file need not complete


class _Fly(Table):
    name: str = Field(min_length=1, max_length=100)
    inertia: QuantityEntry
    damping: QuantityEntry
    wingbeat_frequency: QuantityEntry


class _Controller(Table):
    proportional_gain: QuantityEntry
    derivative_gain: QuantityEntry
    delay: QuantityEntry


class _Pulse(Table):
    duration: QuantityEntry
    peak: QuantityEntry
    tolerance: QuantityEntry
    deadline: QuantityEntry


class _DampingRange(Table):
    low: QuantityEntry
    high: QuantityEntry


class _Morphology(Table):
    mass: QuantityEntry
    wing_length: QuantityEntry
    wing_length_over_mean_chord: QuantityEntry
    second_moment_radius: QuantityEntry | None = None
    right_hinge: QuantityEntry | None = None
    stroke_plane_angle: QuantityEntry | None = None
    stroke_plane_inertia_over_mgr_per_f2: QuantityEntry | None = None


class FlyFile(Table):
    """A complete fly file."""

    fly: _Fly
    controller: _Controller
    pulse: _Pulse
    damping_range: _DampingRange
    morphology: _Morphology


@dataclass(frozen=True, slots=True)
class LayeredFile:
    """A fly file laid over the default one: the merged tables, and the keys that the default had to fill."""

    user: TomlFile
    tables: FlyFile
    defaulted: tuple[str, ...]  #: as "controller.delay"

    def where(self, key: str) -> str:
        """File and line of a key such as "controller.delay"."""
        return (shipped_file(DEFAULT) if key in self.defaulted else self.user).where(*key.split("."))

    def entry(self, key: str) -> Entry:
        """Look up the quantity of a key such as "controller.delay"."""
        section, name = key.split(".")
        return getattr(getattr(self.tables, section), name)


def read_fly_file(path: Path | str | None) -> LayeredFile:
    """Read a fly file (None: the default; a name such as "drosophila_hydei": a shipped one), check its structure."""
    toml = _toml(path)
    default = shipped_file(DEFAULT).data
    merged: dict[str, Any] = {key: value for key, value in toml.data.items() if key not in _SECTIONS}
    defaulted: list[str] = []
    for section in _SECTIONS:
        given = toml.data.get(section, {})
        if not isinstance(given, dict):
            raise InvalidInputError(f"{toml.where(section)}: {section} is {given!r}; a table [{section}] is needed.")
        merged[section] = default[section] | given
        defaulted += [f"{section}.{key}" for key in default[section] if key not in given]
    if "morphology" not in merged:  # one wing's numbers fit no other body, so the section is taken whole
        merged["morphology"] = default["morphology"]
        defaulted.append("morphology")
    return LayeredFile(toml, structured(FlyFile, merged, toml), tuple(defaulted))


def shipped_parameters() -> tuple[str, ...]:
    """Names of the parameter files that the package ships; the first is the default."""
    names = {path.name.removesuffix(".toml") for path in _data().iterdir() if path.name.endswith(".toml")}
    return (DEFAULT, *sorted(names - {DEFAULT}))


def parameter_text(name: str = DEFAULT) -> str:
    """Text of a shipped parameter file; InvalidInputError if there is none of that name."""
    if name not in shipped_parameters():
        raise InvalidInputError(f"No parameters of {name!r} are shipped; there are {', '.join(shipped_parameters())}.")
    return shipped_file(name).file.text


@cache
def shipped_file(name: str) -> TomlFile:
    """Parse a shipped parameter file."""
    return parse_toml(text_file(f"{name}.toml", _data().joinpath(f"{name}.toml").read_bytes()))


def _toml(path: Path | str | None) -> TomlFile:
    if path is None:
        return shipped_file(DEFAULT)
    if str(path) in shipped_parameters() and not Path(path).exists():
        return shipped_file(str(path))
    if Path(path).name == str(path) and not Path(path).exists():
        raise InvalidInputError(
            f"{path}: there is no such file, and no parameters of that name are shipped; shipped are "
            f"{', '.join(shipped_parameters())}."
        )
    return read_toml_file(Path(path))


def _data() -> Traversable:
    return files("flycontrol.model").joinpath("data")
