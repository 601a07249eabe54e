"""The variables of one trial of a binary file, as a table that knows where each sample stands."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from flycontrol.errors import InvalidInputError
from flycontrol.io.formats import BinaryFile
from flycontrol.io.places import Orientation, Place, VariablePlace

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


@dataclass(frozen=True, slots=True, kw_only=True)
class VariableTable:
    """Series of numbers by the places that a mapping names; all but a trace with its own clock have one length."""

    file: BinaryFile
    orientation: Orientation  #: "columns" for Parquet, else "variables"
    group: str  #: path of the trial in the file; empty: the file is the trial
    places: dict[Place, int]  #: which of `numbers` stands at a place
    numbers: tuple[FloatArray, ...]
    texts: Mapping[Place, list[str]] = field(default_factory=dict[Place, list[str]])
    attributes: Mapping[str, float | str] = field(default_factory=dict[str, float | str])
    rows: IntArray | None = None  #: which samples of the file these are; None: all

    @property
    def kind(self) -> str:
        """What a channel is here: "variable" or "column"."""
        return self.orientation.removesuffix("s")

    def place(self, channel: int, sample: int) -> str:
        """Where a sample stands: "trials.mat, trial.yaw(14)", counted from 1 as in MATLAB, else "run.h5, yaw[13]"."""
        at = next(place for place, index in self.places.items() if index == channel)
        row = int(self.rows[sample]) if self.rows is not None and sample < len(self.rows) else sample
        path = str(at) if isinstance(at, VariablePlace) else repr(at)
        inside = f"{self.group}, " if self.group else ""
        one_based = self.file.layout in ("matlab 5", "matlab 7.3")
        return f"{self.file.name}, {inside}{path}, sample {row + one_based} (from {int(one_based)})"

    def text(self, channel: int, sample: int) -> str:
        """Write a sample."""
        return f"{self.numbers[channel][sample]:.10g}"

    def index_of(self, place: Place, key: str) -> int:
        """Which of `numbers` is at a place; it was asked for when the file was read."""
        if place not in self.places:
            raise InvalidInputError(f"{self.file.name}: {key} was not read.")
        return self.places[place]

    def words(self, place: Place) -> list[str]:
        """Texts at a place: one for the trial, or one for each sample."""
        words = self.texts[place]
        return words if self.rows is None or len(words) == 1 else [words[row] for row in self.rows]

    def subset(self, rows: IntArray) -> VariableTable:
        """Return the table of some samples; series of another length, such as single numbers, stay whole."""
        length = len(self.numbers[0])  # of a clock or of yaw, which come first
        chosen = tuple(numbers[rows] if len(numbers) == length > 1 else numbers for numbers in self.numbers)
        return replace(self, numbers=chosen, rows=rows)
