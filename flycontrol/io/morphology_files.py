"""Morphology files in TOML: body, wings, hinges and inertia of a fly, each number with its unit, source and certainty.

`read_morphology(path_or_name)` reads a file of its own; `morphology_in(toml, "morphology")` reads the table of that
name in a larger file, such as an experiment's. A table may start from another fly and say only what differs:
`fly = "drosophila_melanogaster"`, or the path of a morphology file beside it.
"""

from __future__ import annotations

import os
import tomllib
from pathlib import Path
from typing import Any, cast

import numpy as np

from flycontrol.errors import FlycontrolError, InvalidInputError
from flycontrol.io.entries import Entry
from flycontrol.io.morphology_tables import CHORD_KEYS, MorphologyTable, PlanformTable, WingTable
from flycontrol.io.morphology_text import morphology_text
from flycontrol.io.planform_files import read_planform
from flycontrol.io.published_flies import PUBLISHED, published_morphology
from flycontrol.io.quantities import ANGLE, AREA, INERTIA, LENGTH, MASS, NUMBER, unit_factor
from flycontrol.io.quantity_reader import QuantityReader
from flycontrol.io.table_at import folder_of, table_at
from flycontrol.io.toml_files import TomlFile, read_toml_file, structured
from flycontrol.model.morphology import Matrix, Morphology, Vector, pitch_rotation
from flycontrol.model.planform import ChordTable
from flycontrol.model.provenance import SourcedMorphology
from flycontrol.model.wing_body import WingBody
from flycontrol.model.wing_outline import WingShape

_HINGE, _LONGEST_ARM = 2.0, 10.0  # largest plausible hinge offset and radius of gyration, in wing lengths
_SHORTEST_ARM = 0.01
_LONGEST_CHAIN = 20  # of files that start from one another


def read_morphology(path: Path | str) -> SourcedMorphology:
    """Read a morphology file, or a published fly by its name.

    Parameters
    ----------
    path
        A TOML file with the keys of docs/morphology.md at its top; or "drosophila_melanogaster", "drosophila_hydei".

    Raises
    ------
    InvalidInputError
        For anything that cannot be meant: an unknown key, a number without a unit, a fly that cannot be.
    """
    if str(path) in PUBLISHED and not Path(path).exists():
        return published_morphology(str(path))
    if Path(path).name == str(path) and not Path(path).suffix and not Path(path).exists():
        raise InvalidInputError(f"{path}: no fly of that name is published here; there are {', '.join(PUBLISHED)}.")
    return _read_from(Path(path), ())


def morphology_in(toml: TomlFile, within: str = "", folder: Path | None = None) -> SourcedMorphology:
    """Read the morphology that a table of a TOML file describes.

    Parameters
    ----------
    toml
        The parsed file.
    within
        Dotted name of the table, "morphology"; empty: the whole file.
    folder
        Where files that the table names are looked for; None: beside the TOML file.

    Raises
    ------
    InvalidInputError
        As `read_morphology`, with file and line.
    """
    return _described(toml, within, folder_of(toml, folder), ())


def _read_from(path: Path, begun: tuple[Path, ...]) -> SourcedMorphology:
    """Read a file that the files in `begun` start from."""
    return _described(read_toml_file(path), "", path.parent, (*begun, path))


def _described(toml: TomlFile, within: str, folder: Path, begun: tuple[Path, ...]) -> SourcedMorphology:
    read = QuantityReader(toml, within)
    table = structured(MorphologyTable, _completed(table_at(toml, within), read, folder, begun), toml, within)
    return SourcedMorphology(
        morphology=_morphology(table, read, folder),
        provenance=read.provenance,
        file=toml.file.name,
        sha256=toml.file.sha256,
    )


def _completed(given: dict[str, Any], read: QuantityReader, folder: Path, begun: tuple[Path, ...]) -> dict[str, Any]:
    """Lay a table over that of the fly it starts from."""
    if "fly" not in given:
        return given
    fly = given["fly"]
    if not isinstance(fly, str):
        raise read.refusal("fly", f"is {fly!r}; the name of a published fly or of a morphology file is needed")
    if folder / fly in begun or len(begun) > _LONGEST_CHAIN:
        raise read.refusal("fly", f"is {fly!r}, which starts from this file; flies must not start from one another")
    if fly not in PUBLISHED and not Path(fly).suffix and not os.path.exists(folder / fly):  # noqa: PTH110 a name may be no path
        raise read.refusal("fly", f"is {fly!r}: there is no such file, and published here are {', '.join(PUBLISHED)}")
    start = published_morphology(fly) if fly in PUBLISHED else _read_from(folder / fly, begun)
    base = tomllib.loads(morphology_text(start))
    changes = {key: value for key, value in given.items() if key != "fly"}
    both = {"right_hinge", "inertia"} <= set(changes)
    if changes.get("frame") == "body" and not both:
        raise read.refusal("frame", "is that of right_hinge and inertia: give both, or leave those of the stroke plane")
    planform = changes.get("planform")
    own_chord = isinstance(planform, dict) and "file" in planform
    replaced = set(CHORD_KEYS) if own_chord or set(changes) & set(CHORD_KEYS) else set[str]()
    replaced |= {"second_moment_radius"} if "planform" in changes else set()
    return {key: value for key, value in base.items() if key not in replaced} | changes


def _morphology(table: MorphologyTable, read: QuantityReader, folder: Path) -> Morphology:
    length = read.number(table.wing_length, LENGTH, "wing_length", ("0.1 mm", "200 mm"))
    shape = None if table.planform is None else _shape(table.planform, length, folder, read)
    try:
        angle = read.number(table.stroke_plane_angle, ANGLE, "stroke_plane_angle", ("-180 deg", "180 deg"))
        hinge, inertia = _in_stroke_plane(table, angle, read)
        fly = Morphology(
            species=table.species,
            mass=read.number(table.mass, MASS, "mass", ("1 ug", "100 g")),
            wing_length=length,
            mean_chord=_mean_chord(table, length, shape, read),
            second_moment_radius=_second_moment_radius(table, shape, read),
            pitch_axis=read.number(table.pitch_axis, NUMBER, "pitch_axis"),
            stroke_plane_angle=angle,
            right_hinge=hinge,
            inertia=inertia,
            chord_table=None if shape is None else shape.table,
            wing=None if table.wing is None else _wing(table.wing, read),
        )
    except InvalidInputError:
        raise
    except FlycontrolError as error:
        raise InvalidInputError(f"{read.toml.where(*filter(None, read.within.split('.')))}: {error}") from error
    _refuse_implausible(fly, read)
    return fly


def _in_stroke_plane(table: MorphologyTable, angle: float, read: QuantityReader) -> tuple[Vector, Matrix]:
    """v_S = R v_B and I_S = R I_B R^T for what is given in body axes."""
    hinge = cast("Vector", read.vector(table.right_hinge, LENGTH, "right_hinge"))
    inertia = cast("Matrix", read.matrix(table.inertia, INERTIA, "inertia"))
    if table.frame == "stroke plane":
        return hinge, inertia
    R = pitch_rotation(angle)
    turned = R @ np.array(inertia) @ R.T
    symmetric = (turned + turned.T) / 2
    return cast("Vector", tuple((R @ hinge).tolist())), cast("Matrix", tuple(tuple(row) for row in symmetric.tolist()))


def _mean_chord(table: MorphologyTable, length: float, shape: WingShape | None, read: QuantityReader) -> float:
    given = {key: entry for key in CHORD_KEYS if (entry := getattr(table, key)) is not None}
    if not given and shape is not None and shape.mean_chord is not None:
        return shape.mean_chord * length
    if len(given) != 1:
        found = f"has {' and '.join(given)}" if given else "has none of them"
        raise InvalidInputError(
            f"{read.where(next(iter(given), 'wing_length'))}: exactly one of {', '.join(CHORD_KEYS)} is needed; the "
            f"table {found}."
        )
    key, entry = next(iter(given.items()))
    if key == "mean_chord":
        chord = read.number(entry, LENGTH, key)
    elif key == "wing_area":
        chord = read.number(entry, AREA, key) / length
    else:
        chord = length / read.number(entry, NUMBER, key, ("0.5", "30"))
    if not 0.5 <= length / max(chord, 1e-300) <= 30:
        raise read.refusal(
            key,
            f"makes the wing {length / max(chord, 1e-300):.3g} mean chords long, outside the plausible 0.5 to 30; "
            "check the number and its unit",
        )
    return chord


def _second_moment_radius(table: MorphologyTable, shape: WingShape | None, read: QuantityReader) -> float:
    if table.second_moment_radius is not None:
        return read.number(table.second_moment_radius, NUMBER, "second_moment_radius")
    if shape is None:
        raise read.refusal("second_moment_radius", "is missing; it, or a planform, is needed")
    return shape.second_moment_radius


def _shape(table: PlanformTable, length: float, folder: Path, read: QuantityReader) -> WingShape:
    read.account(Entry(value=None, source=table.source, certainty=table.certainty, note=table.note), "planform")
    given = [key for key in ("span", "chord", "file", "format") if getattr(table, key) is not None]
    if given not in (["span", "chord"], ["file", "format"]):
        raise read.refusal("planform", "needs either span and chord, two lists of equal length, or file and format")
    if table.file is not None and table.format is not None:
        size = 1.0
        if table.unit is not None:
            where = read.where("planform.unit")
            size = length / unit_factor(table.unit, LENGTH, key=read.full("planform.unit"), where=where)
        return read_planform(folder / table.file, table.format, length=size, constant=table.constant)
    try:
        chords = ChordTable(span=tuple(table.span or ()), chord=tuple(table.chord or ()))
    except FlycontrolError as error:
        raise InvalidInputError(f"{read.where('planform')}: {error}") from error
    return WingShape(table=chords, mean_chord=None)


def _wing(table: WingTable, read: QuantityReader) -> WingBody:
    mass = read.number(table.mass, MASS, "wing.mass")
    centre = read.vector(table.centre, LENGTH, "wing.centre", 2)
    moments = {
        key: read.number(getattr(table, key), INERTIA, f"wing.{key}")
        for key in ("span_inertia", "chord_inertia", "normal_inertia", "product")
    }
    return WingBody(mass=mass, centre=(centre[0], centre[1]), **moments)


def _refuse_implausible(fly: Morphology, read: QuantityReader) -> None:
    farthest = float(np.linalg.norm(fly.right_hinge))
    if not fly.right_hinge[1] > 0:
        raise read.refusal("right_hinge", "must lie to the right of the centre of mass: its second value must be > 0")
    if farthest > _HINGE * fly.wing_length:
        raise read.refusal(
            "right_hinge",
            f"lies {farthest:.3g} m from the centre of mass, over {_HINGE:g} wing lengths; check its unit",
        )
    largest = float(np.sqrt(np.linalg.eigvalsh(fly.inertia_S)[-1] / fly.mass)) / fly.wing_length
    if not _SHORTEST_ARM <= largest <= _LONGEST_ARM:
        raise read.refusal(
            "inertia",
            f"has a radius of gyration of {largest:.3g} wing lengths, outside the plausible {_SHORTEST_ARM:g} to "
            f"{_LONGEST_ARM:g}; check its unit and that of the mass",
        )
