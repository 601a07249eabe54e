"""Stroke kinematics in TOML: a family's parameters, Fourier series or measured samples; modulations and ramps.

`stroke_in(toml, "stroke")` reads the table of that name in a larger file, such as an experiment's; `read_stroke(path)`
reads a file of its own. docs/morphology.md shows the keys.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, cast

import numpy as np

from flycontrol.errors import FlycontrolError, InvalidInputError
from flycontrol.io.entries import Entry
from flycontrol.io.quantities import ANGLE, FREQUENCY, NUMBER, unit_factor
from flycontrol.io.quantity_reader import QuantityReader
from flycontrol.io.series_conventions import CONVENTIONS, AngleSeries, SeriesConvention
from flycontrol.io.series_files import read_series_file
from flycontrol.io.stroke_samples import read_stroke_samples
from flycontrol.io.stroke_tables import (
    AngleConventionTable,
    BermanWangTable,
    ConventionTable,
    FourierFileTable,
    FourierTable,
    ModulationTable,
    SamplesTable,
    SeriesTable,
    StrokeTable,
)
from flycontrol.io.table_at import folder_of, table_at
from flycontrol.io.toml_files import Table, TomlFile, read_toml_file, structured
from flycontrol.model.steering import Steering
from flycontrol.model.stroke import Side
from flycontrol.model.stroke_kinematics import StrokeKinematics
from flycontrol.model.wing_stroke import (
    BermanWangStroke,
    FourierStroke,
    Modulation,
    WingStroke,
    paddling,
)

_KINDS: dict[str, type[Table]] = {
    "Berman and Wang": BermanWangTable,
    "Fourier": FourierTable,
    "Fourier file": FourierFileTable,
    "samples": SamplesTable,
}
_SIDES: tuple[Side, Side] = ("left", "right")
_WIDE = ("-180 deg", "180 deg")


def read_stroke(path: Path | str, *, periodic: bool = False) -> StrokeKinematics:
    """Read a file of stroke kinematics, with the keys of `stroke_in` at its top; refused like `stroke_in`."""
    return stroke_in(read_toml_file(Path(path)), periodic=periodic)


def stroke_in(
    toml: TomlFile, within: str = "", folder: Path | None = None, *, periodic: bool = False
) -> StrokeKinematics:
    """Read the stroke of both wings that a table of a TOML file describes.

    Parameters
    ----------
    toml
        The parsed file.
    within
        Dotted name of the table, "stroke"; empty: the whole file.
    folder
        Where files that the table names are looked for; None: beside the TOML file.
    periodic
        Whether every wingbeat must be like the first, as a trim needs it.

    Raises
    ------
    InvalidInputError
        For anything that cannot be meant, with file and line.
    """
    read = QuantityReader(toml, within)
    table = structured(StrokeTable, table_at(toml, within), toml, within)
    frequency = read.number(table.frequency, FREQUENCY, "frequency", ("1 Hz", "2000 Hz"))
    if table.both is not None and not (table.left is None and table.right is None):
        raise read.refusal("both", "is given beside left or right; give both alone, or left and right")
    if (table.both is None) == (table.left is None and table.right is None) or (table.left is None) != (
        table.right is None
    ):
        raise read.refusal("both", "is needed, a table for both wings, or else left and right")
    source = _StrokeSource(toml, within, folder_of(toml, folder), frequency)
    if table.both is not None:
        left = right = source.stroke(table.both, "both")
    else:
        left, right = source.stroke(table.left or {}, "left"), source.stroke(table.right or {}, "right")
    kinematics = StrokeKinematics(frequency=frequency, left=left, right=right)
    for steering in _steering(table.modulation, read):
        kinematics = steering.applied(kinematics)
    if periodic:
        refuse_aperiodic(kinematics, read.where("both" if table.both is not None else "left"))
    return kinematics


def refuse_aperiodic(kinematics: StrokeKinematics, name: str) -> None:
    """Refuse a stroke whose wingbeats differ where a periodic one is needed; `name` says whose, a file and line."""
    differing = [side for side in _SIDES if not kinematics.wing(side).periodic]
    if differing:
        raise InvalidInputError(
            f"{name}: the {' and the '.join(differing)} wing's stroke is not the same in every wingbeat, as is needed "
            "here; make samples periodic (periodic = true, or harmonics) and modulate without a ramp."
        )


@dataclass(frozen=True, slots=True)
class _StrokeSource:
    """Reads the tables `both`, `left` and `right` of one table of stroke kinematics."""

    toml: TomlFile
    within: str
    folder: Path
    frequency: float  #: [1/s]

    def stroke(self, written: dict[str, Any], key: str) -> WingStroke:
        """Read the stroke of one wing, or of both."""
        path = ".".join(filter(None, (self.within, key)))
        read = QuantityReader(self.toml, path)
        kind = written.get("kind")
        if not isinstance(kind, str) or kind not in _KINDS:
            raise read.refusal("kind", f"is {kind!r}; one of {_listed(_KINDS)} is needed")
        table = structured(_KINDS[kind], written, self.toml, path)
        try:
            return self._made(table, read)
        except InvalidInputError:
            raise
        except FlycontrolError as error:
            raise InvalidInputError(f"{read.where('kind')}: {error}") from error

    def _made(self, table: Table, read: QuantityReader) -> WingStroke:
        if isinstance(table, BermanWangTable):
            return _berman_wang(table, read)
        if isinstance(table, FourierTable):
            return _fourier(table, read)
        if isinstance(table, FourierFileTable):
            return read_series_file(self.folder / table.file, _convention(table.convention, read))
        return read_stroke_samples(cast("SamplesTable", table), self.frequency, self.folder, read)


def _berman_wang(table: BermanWangTable, read: QuantityReader) -> BermanWangStroke:
    given: dict[str, float] = {}
    for field in fields(BermanWangStroke):
        entry = getattr(table, field.name)
        if isinstance(entry, Entry):
            shape = field.name.endswith("_shape")
            plausible = ("0", "1000") if shape else _WIDE
            given[field.name] = read.number(entry, NUMBER if shape else ANGLE, field.name, plausible)
    return BermanWangStroke(**given, deviation_order=table.deviation_order)


def _fourier(table: FourierTable, read: QuantityReader) -> FourierStroke:
    count = max(max(len(one.cosine), len(one.sine)) for one in (table.stroke, table.deviation, table.pitch))
    rows = [_series(getattr(table, key), count, key, read) for key in ("stroke", "deviation", "pitch")]
    return FourierStroke(cosine=np.array([row[0] for row in rows]), sine=np.array([row[1] for row in rows]))


def _series(table: SeriesTable, count: int, key: str, read: QuantityReader) -> tuple[list[float], list[float]]:
    def value(entry: object, part: str) -> float:
        return read.number(Entry(value=entry), ANGLE, f"{key}.{part}", ("-360 deg", "360 deg"))

    cosine = [value(entry, "cosine") for entry in table.cosine]
    sine = [value(entry, "sine") for entry in table.sine]
    a = [value(table.mean, "mean"), *cosine, *[0.0] * (count - len(cosine))]
    return a, [0.0, *sine, *[0.0] * (count - len(sine))]


def _convention(written: object, read: QuantityReader) -> SeriesConvention:
    if isinstance(written, str) and written in CONVENTIONS:
        return CONVENTIONS[written]
    if not isinstance(written, dict):
        raise read.refusal("convention", f"is {written!r}; one of {_listed(CONVENTIONS)}, or a table, is needed")
    path = f"{read.within}.convention"
    table = structured(ConventionTable, cast("dict[str, Any]", written), read.toml, path)
    inner = QuantityReader(read.toml, path)
    return SeriesConvention(
        unit=unit_factor(table.unit, ANGLE, key=f"{path}.unit", where=inner.where("unit")),
        constant=table.constant,
        stroke=_angle(table.stroke, inner, "stroke"),
        deviation=None if table.deviation is None else _angle(table.deviation, inner, "deviation"),
        pitch=_angle(table.pitch, inner, "pitch"),
    )


def _angle(table: AngleConventionTable, read: QuantityReader, key: str) -> AngleSeries:
    if not (table.cosine or table.sine):
        raise read.refusal(key, "names neither a list of cosine nor one of sine coefficients")
    return AngleSeries(
        cosine=table.cosine,
        sine=table.sine,
        constant=table.constant,
        sign=table.sign,
        offset=read.number(Entry(value=table.offset), ANGLE, f"{key}.offset", _WIDE),
        advance=table.advance,
        scale=table.scale,
    )


def modulations_in(toml: TomlFile, within: str = "") -> tuple[Steering, ...]:
    """Read the modulations of a table of stroke kinematics alone, for a stroke that is trimmed before it is steered."""
    table = structured(StrokeTable, table_at(toml, within), toml, within)
    return _steering(table.modulation, QuantityReader(toml, within))


def _steering(tables: list[ModulationTable], read: QuantityReader) -> tuple[Steering, ...]:
    """One modulation after the other, in the order of the file."""
    found: list[Steering] = []
    for number, table in enumerate(tables):
        one = QuantityReader(read.toml, read.full(f"modulation.{number}"))
        left, right = _modulations(table, one)
        try:
            ramp = None if table.ramp is None else (table.ramp[0], table.ramp[1])
            found.append(Steering(left=left, right=right, ramp=ramp))
        except FlycontrolError as error:
            raise InvalidInputError(f"{one.where('ramp')}: {error}") from error
    return tuple(found)


def _modulations(table: ModulationTable, read: QuantityReader) -> tuple[Modulation, Modulation]:
    """Changes of the left and of the right wing."""
    angle = {
        key: read.number(Entry(value=getattr(table, key)), ANGLE, key, ("-90 deg", "90 deg"))
        for key in ("stroke_offset", "deviation_offset", "pitch_offset")
    }
    change = Modulation(stroke_gain=table.stroke_gain, **angle)
    if table.paddling is not None:
        if table.wing is not None or change != Modulation():
            raise read.refusal("paddling", "moves the pitch of both wings and stands alone; write two modulations")
        return paddling(read.number(Entry(value=table.paddling), ANGLE, "paddling", ("-90 deg", "90 deg")))
    if table.wing is None:
        raise read.refusal("wing", 'is missing; "left", "right" or "both" is needed')
    still = Modulation()
    return still if table.wing == "right" else change, still if table.wing == "left" else change


def _listed(names: Iterable[str]) -> str:
    return ", ".join(map(repr, names))
