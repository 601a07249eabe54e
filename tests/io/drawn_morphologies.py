"""Flies that can be: masses, wings and inertias drawn so that some body has them."""

import numpy as np
from hypothesis import strategies as st

from flycontrol.model.morphology import Morphology
from flycontrol.model.planform import ChordTable, Planform
from flycontrol.model.provenance import Provenance
from flycontrol.model.references import references
from flycontrol.model.wing_body import thin_plate

fractions = st.floats(0.05, 0.95)


@st.composite
def chord_tables(draw):
    inner = sorted(draw(st.sets(fractions, max_size=5)))
    span = (0.0, *inner, 1.0)
    chord = draw(st.lists(st.floats(0.05, 1.0), min_size=len(span), max_size=len(span)))
    return ChordTable(span=span, chord=tuple(chord))


@st.composite
def inertias(draw, mass, length):
    """Six equal masses somewhere within a wing length: I = sum of m (r^2 1 - r r^T)."""
    flat = draw(st.lists(st.floats(-1.0, 1.0), min_size=18, max_size=18))
    points = length * (np.array(flat).reshape(6, 3) / 4 + np.vstack([np.eye(3), -np.eye(3)]))
    total = sum(mass / 6 * (p @ p * np.eye(3) - np.outer(p, p)) for p in points)
    return tuple(tuple(row) for row in ((total + total.T) / 2).tolist())


@st.composite
def morphologies(draw):
    mass, length = 10 ** draw(st.floats(-8.5, -1.5)), 10 ** draw(st.floats(-3.5, -0.75))
    mean_chord, axis = length / draw(st.floats(1.0, 20.0)), draw(st.floats(0.0, 1.0))
    r2, table = draw(st.floats(0.45, 0.7)), draw(st.none() | chord_tables())
    plan = Planform(length=length, mean_chord=mean_chord, second_moment_radius=r2, table=table)
    return Morphology(
        species=draw(st.text(min_size=1, max_size=30)),
        mass=mass,
        wing_length=length,
        mean_chord=mean_chord,
        second_moment_radius=r2,
        right_hinge=(
            length * draw(st.floats(-1, 1)),
            length * draw(st.floats(1e-3, 1)),
            length * draw(st.floats(-1, 1)),
        ),
        inertia=draw(inertias(mass, length)),
        stroke_plane_angle=draw(st.floats(-3.0, 3.0)),
        pitch_axis=axis,
        chord_table=table,
        wing=thin_plate(plan, mass * draw(st.floats(1e-4, 0.4)), axis) if draw(st.booleans()) else None,
    )


provenances = st.builds(
    Provenance,
    source=st.sampled_from(["", *references()]),
    certainty=st.sampled_from(["S", "S2", "C", "user"]),
    note=st.text(max_size=30),
)
