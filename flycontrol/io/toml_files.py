"""TOML files and their structure: a fault is refused with file, line and the nearest valid key."""

from __future__ import annotations

import re
import tomllib
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from difflib import get_close_matches
from pathlib import Path
from typing import Any, TypeVar, get_args

from pydantic import BaseModel, ConfigDict, ValidationError
from pydantic_core import ErrorDetails

from flycontrol.errors import InvalidInputError
from flycontrol.io.text_files import TextFile, read_text_file

_ASSIGNMENT = re.compile(r"\s*(?:(?P<brackets>\[+)\s*(?P<table>[^\]#]+?)\s*\]|(?P<key>[\w.\"' -]+?)\s*=)")


class Table(BaseModel):
    """A TOML table whose keys are all known and whose values are taken as they are, never coerced."""

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)


Model = TypeVar("Model", bound=Table)


@dataclass(frozen=True, slots=True)
class TomlFile:
    """A parsed TOML file that knows on which line a key stands."""

    file: TextFile
    data: dict[str, Any]

    def where(self, *keys: str) -> str:
        """Name of the file and, if it is there, the line of a key given by its path of table names."""
        lines = [line for line, path in self._key_lines() if path and path == keys[: len(path)]]
        return f"{self.file.name}, line {lines[-1]}" if lines else self.file.name

    def _key_lines(self) -> Iterator[tuple[int, tuple[str, ...]]]:
        table: tuple[str, ...] = ()
        counts: Counter[tuple[str, ...]] = Counter()
        for number, line in enumerate(self.file.text.splitlines(), start=1):
            found = _ASSIGNMENT.match(line)
            if found and found["table"]:
                table = _path(found["table"])
                yield number, table
                if len(found["brackets"]) == 2:  # one of an array of tables: its keys are under its number
                    counts[table] += 1
                    table = (*table, str(counts[table] - 1))
                    yield number, table
            elif found:
                yield number, table + _path(found["key"])


def read_toml_file(path: Path) -> TomlFile:
    """Read and parse a TOML file; InvalidInputError in one sentence if that fails."""
    return parse_toml(read_text_file(path))


def parse_toml(file: TextFile) -> TomlFile:
    """Parse a TOML text; InvalidInputError with line and column if it is not TOML."""
    try:
        return TomlFile(file, tomllib.loads(file.text))
    except (tomllib.TOMLDecodeError, RecursionError) as error:
        raise InvalidInputError(f"{file.name} is not valid TOML: {error}.") from error
    except ValueError as error:  # Python converts no integer of thousands of digits
        raise InvalidInputError(f"{file.name} holds a number of thousands of digits; write it shorter.") from error


def structured(model: type[Model], data: dict[str, Any], toml: TomlFile, within: str = "") -> Model:
    """Check the tables and keys of a file, or of its table named by `within`, against a model.

    Raises
    ------
    InvalidInputError
        For the first unknown or missing key or value of a wrong type, with file, line and what would be right.
    """
    try:
        return model.model_validate(data)
    except ValidationError as error:
        faults = error.errors(include_url=False)
        fault = next((one for one in faults if one["type"] == "extra_forbidden"), faults[0])  # it may be a missing one
        keys = tuple(str(part) for part in fault["loc"])
        whole = (*filter(None, within.split(".")), *keys)
        raise InvalidInputError(f"{toml.where(*whole)}: {_sentence(fault, keys, model, within)}.") from error


def _sentence(fault: ErrorDetails, keys: tuple[str, ...], model: type[Table], within: str) -> str:
    key = ".".join((*filter(None, [within]), *keys))
    if fault["type"] == "extra_forbidden":
        return f"{key} is not a key known here; {nearest('.'.join(keys), list(dotted_names(model)))}"
    if fault["type"] == "missing":
        return f"{key} is missing"
    if fault["type"] in {"model_type", "model_attributes_type"}:
        return f"{key} is {fault['input']!r}; a table is needed"
    return f"{key} is {fault['input']!r}; {fault['msg'][0].lower()}{fault['msg'][1:]}"


def nearest(name: str, valid: list[str]) -> str:
    """Name the valid key that a wrong one most likely means: the same in another table, or a similar one in this."""
    table, _, last = name.rpartition(".")
    same = [key for key in valid if key.rpartition(".")[2] == last]
    here = {key.rpartition(".")[2]: key for key in valid if key.rpartition(".")[0] == table}
    similar = [here[match] for match in get_close_matches(last, here, n=1, cutoff=0.5)]
    if same or similar:
        return f"the nearest known key is {(same + similar)[0]}"
    return f"known here: {', '.join(here)}"


def dotted_names(model: type[Table]) -> Iterator[str]:
    """All keys of a model and of the tables in it, as "controller.delay"."""
    for name, field in model.model_fields.items():
        yield name
        for table in _tables_in(field.annotation):
            yield from (f"{name}.{inner}" for inner in dotted_names(table))


def _tables_in(annotation: object) -> Iterator[type[Table]]:
    if isinstance(annotation, type) and issubclass(annotation, Table):
        yield annotation
    for part in get_args(annotation):
        yield from _tables_in(part)


def _path(dotted: str) -> tuple[str, ...]:
    return tuple(part.strip(" \"'") for part in dotted.split("."))
