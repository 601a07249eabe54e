"""The keys of a morphology file, as TOML holds them."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from flycontrol.io.entries import QuantityEntry
from flycontrol.io.planform_files import PlanformFormat
from flycontrol.io.series_conventions import Constant
from flycontrol.io.toml_files import Table
from flycontrol.model.parameters import WrittenCertainty

CHORD_KEYS = ("mean_chord", "wing_length_over_mean_chord", "wing_area")  #: one of them is needed


class PlanformTable(Table):
    """Chords along the span, in place of the beta distribution: written out, or in a file."""

    file: str | None = Field(default=None, min_length=1, max_length=1000)
    format: PlanformFormat | None = None
    unit: str | None = None  #: of an outline's points; None: wing lengths
    constant: Constant | None = None  #: what a0 of a Fourier outline is, where the file does not state it
    span: list[float] | None = None  #: fractions of the wing length, rising from 0 to 1
    chord: list[float] | None = None  #: in any one unit: mean_chord sets the size
    source: str = ""
    certainty: WrittenCertainty = "user"
    note: str = ""


class WingTable(Table):
    """Mass and inertia of one wing about its hinge, in place of a plate of even thickness."""

    mass: QuantityEntry
    centre: QuantityEntry
    span_inertia: QuantityEntry
    chord_inertia: QuantityEntry
    normal_inertia: QuantityEntry
    product: QuantityEntry


class MorphologyTable(Table):
    """A fly as `flycontrol.model.morphology.Morphology` holds it."""

    species: str = Field(min_length=1, max_length=100)
    mass: QuantityEntry
    wing_length: QuantityEntry
    mean_chord: QuantityEntry | None = None
    wing_length_over_mean_chord: QuantityEntry | None = None
    wing_area: QuantityEntry | None = None
    second_moment_radius: QuantityEntry | None = None
    pitch_axis: QuantityEntry
    frame: Literal["stroke plane", "body"]
    stroke_plane_angle: QuantityEntry
    right_hinge: QuantityEntry
    inertia: QuantityEntry
    planform: PlanformTable | None = None
    wing: WingTable | None = None
