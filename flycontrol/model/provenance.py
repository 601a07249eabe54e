"""Where a number comes from and how certain it is; a morphology whose every number says so."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import get_args

from flycontrol.errors import InvalidParameterError
from flycontrol.model.morphology import Morphology
from flycontrol.model.parameters import WrittenCertainty
from flycontrol.model.references import cite


@dataclass(frozen=True, slots=True, kw_only=True)
class Provenance:
    """Source, certainty and note of one quantity."""

    source: str = ""  #: a key of references.bib; empty for a user's own value
    certainty: WrittenCertainty = "user"
    note: str = ""

    def __post_init__(self) -> None:
        if self.certainty not in get_args(WrittenCertainty):
            raise InvalidParameterError(
                f"Certainty must be one of {', '.join(get_args(WrittenCertainty))}, got {self.certainty!r}."
            )
        if self.source:
            cite(self.source)


@dataclass(frozen=True, slots=True, kw_only=True)
class SourcedMorphology:
    """A morphology, and for every quantity where it comes from."""

    morphology: Morphology
    provenance: Mapping[str, Provenance] = field(default_factory=dict)  #: by the file's keys: "mass", "wing.centre"
    file: str = ""  #: name of the file read
    sha256: str = ""  #: hash of its bytes
