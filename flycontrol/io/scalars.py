"""Single numbers and words that belong to a whole trial: the onset of its pulse, the name of its fly."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from flycontrol.errors import InvalidInputError
from flycontrol.io.places import Label, Place, Scalar
from flycontrol.io.samples import LARGEST, index_of
from flycontrol.io.table_files import Table
from flycontrol.io.variable_table import VariableTable


def read_scalar(table: Table, scalar: Scalar) -> float:
    """SI value = factor * number, of an attribute or of a channel that holds one number throughout.

    Raises
    ------
    InvalidInputError
        If there is no number, if it is not finite, or if there are several.
    """
    number = _attribute_number(table, scalar) if scalar.place is None else _constant(table, scalar, scalar.place)
    return scalar.factor * number


def read_label(table: Table, label: Label) -> str:
    """Return a word for the trial; InvalidInputError if there is none, or if there are several."""
    if label.text:
        return label.text
    pattern, text = label.file_name, Path(table.file.name).name
    if label.path is not None:
        pattern, text = label.path, Path(table.file.name).as_posix()
    if pattern is not None:
        found = pattern.search(text)
        if found is None or not found[1]:
            raise _refusal(table, label, f"finds nothing by '{pattern.pattern}' in {text!r}")
        return found[1]
    words = [_attribute_text(table, label)] if label.attribute else sorted(set(_words(table, label)))
    if len(words) != 1 or not words[0]:
        what = "is empty" if words in ([], [""]) else f"differs within the trial ({', '.join(map(repr, words[:3]))})"
        raise _refusal(table, label, f"{what}; one word is needed")
    return words[0]


def read_words(table: Table, place: Place, key: str, where: str) -> list[str]:
    """Return the text of every sample at a place."""
    if isinstance(table, VariableTable):
        return table.words(place)
    return table.words(index_of(table, place, key, where))


def _words(table: Table, label: Label) -> list[str]:
    return [] if label.place is None else read_words(table, label.place, label.key, label.where)


def _attribute_number(table: Table, scalar: Scalar) -> float:
    value = table.attributes[scalar.attribute] if isinstance(table, VariableTable) else ""
    if isinstance(value, str) or not abs(value) < LARGEST:
        raise _refusal(table, scalar, f"is {value!r}; a number is needed")
    return value


def _attribute_text(table: Table, label: Label) -> str:
    value = table.attributes[label.attribute] if isinstance(table, VariableTable) else ""
    return value if isinstance(value, str) else f"{value:.10g}"


def _constant(table: Table, scalar: Scalar, place: Place) -> float:
    index = index_of(table, place, scalar.key, scalar.where)
    numbers = table.numbers[index]
    given = numbers[~np.isnan(numbers)]
    if given.size == 0:
        text = table.text(index, 0) if len(numbers) else ""
        raise _refusal(table, scalar, f'is missing ("{text[:60]}"); one number is needed')
    if np.any(given != given[0]):
        other = int(np.flatnonzero(~np.isnan(numbers) & (numbers != given[0]))[0])
        raise _refusal(
            table,
            scalar,
            f"is {given[0]:.10g} and, at {table.place(index, other)}, {numbers[other]:.10g}; one number is needed for "
            "a trial",
        )
    if not abs(given[0]) < LARGEST:
        raise _refusal(table, scalar, f"is {given[0]:g}; a finite number is needed")
    return float(given[0])


def _refusal(table: Table, item: Scalar | Label, what: str) -> InvalidInputError:
    return InvalidInputError(f"{table.file.name}: {item.key} {what} ({item.where}).")
