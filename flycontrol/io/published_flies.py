"""The published flies, complete: what their parameter files say of mass, wings and inertia, and what is made of it."""

from __future__ import annotations

from dataclasses import replace

from flycontrol.errors import InvalidInputError
from flycontrol.io.fly_files import read_fly_file
from flycontrol.io.morphology import read_morphology_table
from flycontrol.io.parameters import read_parameters
from flycontrol.model.morphology import morphology_from_table
from flycontrol.model.provenance import Provenance, SourcedMorphology

PUBLISHED = {"drosophila_melanogaster": "fly", "drosophila_hydei": "drosophila_hydei"}  #: and their parameter files

_MADE = {  #: what no parameter file need say, as `flycontrol.model.morphology.morphology_from_table` makes it
    "second_moment_radius": Provenance(
        source="flycontrol", certainty="C", note="r2/R, within the published 0.575 to 0.595"
    ),
    "pitch_axis": Provenance(source="flycontrol", certainty="C", note="behind the leading edge, in chords"),
    "stroke_plane_angle": Provenance(source="flycontrol", certainty="C", note="that of D. hydei"),
    "right_hinge": Provenance(
        source="flycontrol",
        certainty="C",
        note="that of D. melanogaster, scaled with wing length: uncertain by some 0.3 mm",
    ),
    "inertia": Provenance(
        source="cheng2009", certainty="S", note="5.06e-13 kg m^2 across and 1.145e-13 kg m^2 along the body"
    ),
}


def published_morphology(name: str) -> SourcedMorphology:
    """Look up a published fly: "drosophila_melanogaster" or "drosophila_hydei"; InvalidInputError for another name."""
    if name not in PUBLISHED:
        raise InvalidInputError(f"{name!r} is no published fly; there are {', '.join(PUBLISHED)}.")
    file = PUBLISHED[name]
    parameters = read_parameters(file)
    table = read_morphology_table(file)
    return SourcedMorphology(
        morphology=morphology_from_table(table, parameters.name, parameters.wingbeat_frequency.value),
        provenance=_provenance(file),
        file=parameters.file,
        sha256=parameters.sha256,
    )


def _provenance(file: str) -> dict[str, Provenance]:
    section = read_fly_file(file).tables.morphology
    said = {
        key: Provenance(source=entry.source, certainty=entry.certainty, note=entry.note)
        for key in type(section).model_fields
        if (entry := getattr(section, key)) is not None
    }
    chord = said.pop("wing_length_over_mean_chord")
    moments = said.pop("stroke_plane_inertia_over_mgr_per_f2", None)
    known = _MADE | said | {"mean_chord": chord}
    if moments is not None:
        note = "0.64, 1.07, 0.57 m g R / f^2 about x, y, z; the product of inertia is that of a body of revolution"
        known["inertia"] = Provenance(source=moments.source, certainty=moments.certainty, note=note)
    in_body_axes = ("right_hinge",) if moments is not None else ("right_hinge", "inertia")
    return known | {key: _turned(known[key]) for key in in_body_axes}


def _turned(known: Provenance) -> Provenance:
    return replace(known, note=f"{known.note}; here turned into the stroke plane")
