"""Reads the quantities of one table of a TOML file: numbers, vectors and matrices with units, and their provenance."""

from __future__ import annotations

from dataclasses import dataclass, field

from flycontrol.errors import FlycontrolError, InvalidInputError
from flycontrol.io.entries import Entry
from flycontrol.io.quantities import NUMBER, Kind, read_quantity
from flycontrol.io.toml_files import TomlFile
from flycontrol.model.provenance import Provenance

_LARGEST = 1e300


@dataclass(frozen=True, slots=True)
class QuantityReader:
    """Reads entries of the table `within` of a file; what it read, it can account for."""

    toml: TomlFile
    within: str = ""  #: dotted path of the table, "morphology"
    provenance: dict[str, Provenance] = field(default_factory=dict[str, Provenance])

    def where(self, key: str) -> str:
        """File and line of a key of the table."""
        return self.toml.where(*self.full(key).split("."))

    def refusal(self, key: str, what: str) -> InvalidInputError:
        """Return an error that names file, line and key."""
        return InvalidInputError(f"{self.where(key)}: {self.full(key)} {what}.")

    def number(self, entry: Entry, kind: Kind, key: str, plausible: tuple[str, str] | None = None) -> float:
        """Read a quantity [SI unit of its kind], which must lie within the plausible where that is known."""
        self.account(entry, key)
        return self._value(entry.value, kind, key, plausible)

    def vector(self, entry: Entry, kind: Kind, key: str, count: int = 3) -> tuple[float, ...]:
        """Read a list of quantities."""
        self.account(entry, key)
        return self._values(entry.value, kind, key, count)

    def matrix(self, entry: Entry, kind: Kind, key: str) -> tuple[tuple[float, ...], ...]:
        """Read three rows of three, or the three on the diagonal."""
        self.account(entry, key)
        rows = entry.value
        if isinstance(rows, list) and len(rows) == 3 and not any(isinstance(row, list) for row in rows):
            x, y, z = self._values(rows, kind, key, 3)
            return ((x, 0.0, 0.0), (0.0, y, 0.0), (0.0, 0.0, z))
        if not (isinstance(rows, list) and len(rows) == 3):
            raise self.refusal(key, f"is {rows!r}; three moments, or three rows of three values, are needed")
        return tuple(self._values(row, kind, key, 3) for row in rows)

    def _values(self, written: object, kind: Kind, key: str, count: int) -> tuple[float, ...]:
        if not isinstance(written, list) or len(written) != count:
            raise self.refusal(key, f"is {written!r}; a list of {count} values is needed")
        return tuple(self._value(value, kind, key, None) for value in written)

    def _value(self, written: object, kind: Kind, key: str, plausible: tuple[str, str] | None) -> float:
        value = self._si(written, kind, key)
        if plausible is not None:
            low, high = (
                float(bound) if kind is NUMBER else read_quantity(bound, kind, key=key).value for bound in plausible
            )
            if not low <= value <= high:
                raise self.refusal(
                    key,
                    f"is {written!r}, outside the plausible {plausible[0]} to {plausible[1]}; "
                    "check the number and its unit",
                )
        return value

    def _si(self, written: object, kind: Kind, key: str) -> float:
        if kind is not NUMBER:
            return read_quantity(written, kind, key=self.full(key), where=self.where(key)).value
        if isinstance(written, bool) or not isinstance(written, int | float) or not abs(written) < _LARGEST:
            raise self.refusal(key, f"is {written!r}; a finite number without unit such as {kind.example} is needed")
        return float(written)

    def account(self, entry: Entry, key: str) -> None:
        """Keep where an entry comes from."""
        try:
            self.provenance[key] = Provenance(source=entry.source, certainty=entry.certainty, note=entry.note)
        except FlycontrolError as error:
            raise self.refusal(key, f"has a source that is unknown: {str(error).removesuffix('.')}") from error

    def full(self, key: str) -> str:
        """Dotted name of a key of the table."""
        return f"{self.within}.{key}" if self.within else key
