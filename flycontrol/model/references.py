"""The papers and data that numbers come from, by key, as references.bib prints them."""

from __future__ import annotations

import re
from dataclasses import dataclass
from difflib import get_close_matches
from functools import cache
from importlib.resources import files

from flycontrol.errors import InvalidParameterError

_ENTRY = re.compile(r"^@(?P<type>article|misc)\{(?P<key>[a-z0-9]+),\n(?P<body>.*?)^\}", re.MULTILINE | re.DOTALL)
_FIELD = re.compile(r"(\w+) = \{([^{}]*)\}")


@dataclass(frozen=True, slots=True, kw_only=True)
class Reference:
    """One entry of references.bib; what its source did not print is empty."""

    key: str
    author: str = ""  #: "Ristroph, L and Berman, GJ and ..."
    title: str = ""
    journal: str = ""
    volume: str = ""
    pages: str = ""
    year: str = ""
    howpublished: str = ""
    note: str = ""

    @property
    def label(self) -> str:
        """Short form for a table: "Ristroph et al. 2010"; the title's beginning where no author is printed."""
        names = [name.partition(",")[0] for name in self.author.split(" and ")]
        if not self.author:
            return self.title
        short = f"{names[0]} et al." if len(names) > 2 else " & ".join(names)
        return f"{short} {self.year}"

    def __str__(self) -> str:
        """Long form for a list of references."""
        authors = ", ".join(name.replace(",", "") for name in self.author.split(" and "))
        who = f"{authors} ({self.year})" if self.author else ""
        volume = f" {self.volume}" + (f":{self.pages.replace('--', '–')}" if self.pages else "") if self.volume else ""
        where = self.journal + volume
        return ". ".join(part for part in (who, self.title, where, self.howpublished, self.note) if part) + "."


def cite(key: str) -> Reference:
    """Look up a key of references.bib.

    Raises
    ------
    InvalidParameterError
        If there is no such key; the nearest one is suggested.
    """
    known = references()
    if key not in known:
        near = get_close_matches(key, known, n=1)
        hint = f"the nearest is {near[0]!r}." if near else f"known keys: {', '.join(known)}."
        raise InvalidParameterError(f"{key!r} is no reference of references.bib; {hint}")
    return known[key]


@cache
def references() -> dict[str, Reference]:
    """All entries of references.bib, by key."""
    text = files("flycontrol.model").joinpath("references.bib").read_text(encoding="utf-8")
    return {
        entry["key"]: Reference(key=entry["key"], **dict(_FIELD.findall(entry["body"])))
        for entry in _ENTRY.finditer(text)
    }
