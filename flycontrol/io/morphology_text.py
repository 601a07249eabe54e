"""Morphologies as TOML text; what is written reads back equal, to the last bit."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from pathlib import Path

from flycontrol.io.quantities import ANGLE, INERTIA, LENGTH, MASS
from flycontrol.io.quantity_text import quantity_text
from flycontrol.jobs.files import write_files_atomically
from flycontrol.model.morphology import Morphology
from flycontrol.model.planform import ChordTable
from flycontrol.model.provenance import Provenance, SourcedMorphology
from flycontrol.model.wing_body import WingBody

_HEAD = """\
# A fly as the wing-level simulator takes it. The frame of hinge and inertia is the stroke plane's (x forward, y right,
# z down; v_S = Ry(stroke_plane_angle) v_B) or the body's. The inertia is that of the body without wings about its
# centre of mass. Certainty: S = read in the source; S2 = second hand; C = our own calibration.
"""


def write_morphology(fly: SourcedMorphology | Morphology, path: Path | str) -> Path:
    """Write a morphology file, whole or not at all; OutputError if that fails."""
    target = Path(path)
    return write_files_atomically(target.parent, {target.name: morphology_text(fly)})[0]


def morphology_text(fly: SourcedMorphology | Morphology) -> str:
    """Text of a morphology file, from which `read_morphology` makes an equal morphology with equal provenance."""
    sourced = fly if isinstance(fly, SourcedMorphology) else SourcedMorphology(morphology=fly)
    body, known = sourced.morphology, sourced.provenance
    lines = [_HEAD, f"species = {toml_string(body.species)}", *_body(body, known)]
    if body.chord_table is not None:
        lines += ["", *_planform(body.chord_table, known.get("planform", Provenance()))]
    lines += ["", *(_plate(body.wing_body) if body.wing is None else _wing(body.wing, known))]
    return "\n".join(lines) + "\n"


def toml_string(text: str) -> str:
    """Text as a basic string of TOML."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def _body(fly: Morphology, known: Mapping[str, Provenance]) -> Iterator[str]:
    def line(key: str, value: str) -> str:
        return _line(key, value, known.get(key, Provenance()))

    yield line("mass", _quoted(quantity_text(fly.mass, MASS, "mg")))
    yield line("wing_length", _quoted(quantity_text(fly.wing_length, LENGTH, "mm")))
    yield line("mean_chord", _quoted(quantity_text(fly.mean_chord, LENGTH, "mm")))
    yield line("second_moment_radius", repr(float(fly.second_moment_radius)))
    yield line("pitch_axis", repr(float(fly.pitch_axis)))
    yield 'frame = "stroke plane"'
    yield line("stroke_plane_angle", _quoted(quantity_text(fly.stroke_plane_angle, ANGLE, "deg")))
    yield line("right_hinge", _listed(_quoted(quantity_text(value, LENGTH, "mm")) for value in fly.right_hinge))
    rows = (_listed(_quoted(quantity_text(value, INERTIA, "kg m^2")) for value in row) for row in fly.inertia)
    yield line("inertia", _listed(rows))


def _planform(table: ChordTable, known: Provenance) -> Iterator[str]:
    yield "[planform]"
    yield f"span = {_listed(repr(float(value)) for value in table.span)}"
    yield f"chord = {_listed(repr(float(value)) for value in table.chord)}"
    yield from _provenance_lines(known)


def _wing(wing: WingBody, known: Mapping[str, Provenance]) -> Iterator[str]:
    def line(key: str, value: str) -> str:
        return _line(key, value, known.get(f"wing.{key}", Provenance()))

    yield "[wing]"
    yield line("mass", _quoted(quantity_text(wing.mass, MASS, "ug")))
    yield line("centre", _listed(_quoted(quantity_text(value, LENGTH, "mm")) for value in wing.centre))
    for key in ("span_inertia", "chord_inertia", "normal_inertia", "product"):
        yield line(key, _quoted(quantity_text(getattr(wing, key), INERTIA, "kg m^2")))


def _plate(wing: WingBody) -> Iterator[str]:
    """Say in comments what stands in for a [wing] that is left out."""
    yield "# Without a table [wing] each wing is a plate of even thickness with the published share of the body's mass,"
    yield f"# here {wing.mass:.3g} kg with {wing.span_inertia:.3g} kg m^2 about the pitch axis and, through the hinge,"
    yield f"# {wing.chord_inertia:.3g} about the chord and {wing.normal_inertia:.3g} about the normal."


def _line(key: str, value: str, known: Provenance) -> str:
    if known == Provenance():
        return f"{key} = {value}"
    return f"{key} = {{ value = {value}, {', '.join(_provenance_lines(known))} }}"


def _provenance_lines(known: Provenance) -> Iterator[str]:
    if known.source:
        yield f"source = {toml_string(known.source)}"
    if known.certainty != "user":
        yield f"certainty = {toml_string(known.certainty)}"
    if known.note:
        yield f"note = {toml_string(known.note)}"


def _quoted(text: str) -> str:
    return f'"{text}"'


def _listed(parts: Iterator[str]) -> str:
    return f"[{', '.join(parts)}]"
