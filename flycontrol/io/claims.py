"""What an analysis states about claims of the review: the `claims` of its JSON, read and checked."""

from __future__ import annotations

import json
import re
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, Literal, get_args

from flycontrol.errors import InvalidInputError
from flycontrol.io.text_files import read_text_file

#: First words of every agreement: the published number or sentence holds; nearly; does not; cannot be decided with what
#: there is; or the review does not say it and the package shows it.
Verdict = Literal["agrees", "roughly", "fails", "cannot be told", "shown here"]
#: What our number was made from.
Basis = Literal["simulated", "real data", "simulated and real data", ""]

_VERDICT = re.compile(rf"({'|'.join(get_args(Verdict))})\b")
_NEEDED = ("claim", "published", "ours", "agreement")


@dataclass(frozen=True, slots=True, kw_only=True)
class Claim:
    """One claim of the review and what becomes of it."""

    claim: str
    published: str  #: its number, or where it stands
    ours: str
    agreement: str  #: begins with a `Verdict`
    where: str = ""  #: in the review: "section 4, Fig. 4c"
    basis: Basis = ""

    @property
    def verdict(self) -> Verdict:
        """First words of the agreement."""
        return next(word for word in get_args(Verdict) if self.agreement.startswith(word))


def read_claims(path: Path) -> tuple[Claim, ...] | None:
    """Read the `claims` of an analysis's JSON file; None if there is no file or no such list in it.

    Raises
    ------
    InvalidInputError
        If the file is no JSON, or a claim lacks a field, has an unknown one, or agrees in words that nobody knows.
    """
    if not path.exists():
        return None
    try:
        found: Any = json.loads(read_text_file(path).text)
    except ValueError as error:
        raise InvalidInputError(f"{path.name} is not valid JSON: {error}.") from error
    if not isinstance(found, dict) or "claims" not in found:
        return None
    if not isinstance(found["claims"], list):
        raise InvalidInputError(f"{path.name}: claims must be a list, got {_shown(found['claims'])}.")
    return tuple(_claim(entry, f"{path.name}, claim {number}") for number, entry in enumerate(found["claims"], start=1))


def refuse_misplaced_claims(folder: Path, name: str) -> None:
    """Claims in a JSON file of another name than its analysis would be lost without a word.

    Raises
    ------
    InvalidInputError
        If there are some.
    """
    for path in sorted(folder.rglob("*.json")):
        if path != folder / f"{name}.json" and read_claims(path) is not None:
            place = path.relative_to(folder).as_posix()
            raise InvalidInputError(f"{place} holds claims, which are read from {name}.json alone; write them there.")


def _claim(entry: object, where: str) -> Claim:
    known = [field.name for field in fields(Claim)]
    if not isinstance(entry, dict):
        raise InvalidInputError(f"{where} must be an object of texts, got {_shown(entry)}.")
    for name, value in entry.items():
        if not isinstance(value, str):
            raise InvalidInputError(f"{where}: {name} must be a text, got {_shown(value)}; write it in quotes.")
    missing = [name for name in _NEEDED if not entry.get(name, "").strip()]
    unknown = [name for name in entry if name not in known]
    if missing or unknown:
        fault = f"lacks {missing[0]}" if missing else f"has the unknown field {unknown[0]}"
        raise InvalidInputError(f"{where} {fault}; the fields are {', '.join(known)}.")
    if not _VERDICT.match(entry["agreement"]):
        verdicts = ", ".join(get_args(Verdict))
        raise InvalidInputError(f"{where}: agreement begins with one of {verdicts}, got '{entry['agreement']}'.")
    if entry.get("basis", "") not in get_args(Basis):
        raise InvalidInputError(f"{where}: basis is one of {', '.join(get_args(Basis))[:-2]}, got '{entry['basis']}'.")
    return Claim(**entry)


def _shown(value: object) -> str:
    """As the file has it, cut where it is long."""
    text = json.dumps(value, ensure_ascii=False)
    return text if len(text) <= 60 else f"{text[:50]} ..."
