"""A quantity as a file writes it: plainly, or in a table with where it comes from and how certain it is."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import BeforeValidator

from flycontrol.io.toml_files import Table
from flycontrol.model.parameters import WrittenCertainty


class Entry(Table):
    """A quantity as a file writes it: `delay = "12 ms"`, or a table with its source, certainty and note."""

    value: Any
    source: str = ""
    certainty: WrittenCertainty = "user"
    note: str = ""


def _as_entry(written: object) -> object:
    return written if isinstance(written, dict) else {"value": written}


QuantityEntry = Annotated[Entry, BeforeValidator(_as_entry)]
