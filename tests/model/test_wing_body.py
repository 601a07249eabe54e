from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import dblquad, quad

from flycontrol.errors import InvalidParameterError
from flycontrol.model.morphology import drosophila_hydei
from flycontrol.model.planform import ChordTable, Planform, beta_chord
from flycontrol.model.wing_body import WingBody, thin_plate

PLAN = Planform(length=2.4e-3, mean_chord=0.7e-3, second_moment_radius=0.585)
TABLE = ChordTable(span=(0.0, 0.3, 1.0), chord=(0.0, 2.0, 0.5))


def test_moments_of_the_beta_distribution_are_its_integrals():
    for m, n in ((1, 0), (1, 2), (2, 1), (3, 0), (4, 0)):
        integral = quad(lambda x, m=m, n=n: beta_chord(x, 0.585) ** m * x**n, 0.0, 1.0, epsabs=1e-13, epsrel=1e-12)[0]
        assert PLAN.moment(m, n) == pytest.approx(integral * 0.7e-3**m * 2.4e-3 ** (n + 1), rel=1e-7)
    assert np.sqrt(PLAN.moment(1, 2) / PLAN.moment(1)) / 2.4e-3 == pytest.approx(0.585, rel=1e-7)


def test_moments_of_a_chord_table_are_exact():
    plan = replace(PLAN, table=TABLE)
    area = 0.5 * 0.3 * 2.0 + 0.7 * (2.0 + 0.5) / 2
    square = 0.3 * 4.0 / 3 + 0.7 * (4.0 + 1.0 + 0.25) / 3  # integral of a linear chord squared, panel by panel
    scale = 0.7e-3 / area
    assert plan.moment(1) == pytest.approx(0.7e-3 * 2.4e-3, rel=1e-13)
    assert plan.moment(2) == pytest.approx(scale**2 * square * 2.4e-3, rel=1e-13)


def test_legendre_moments_are_moments():
    assert PLAN.legendre_moment(2, 0) == pytest.approx(PLAN.moment(2), rel=1e-14)
    assert PLAN.legendre_moment(2, 1) == pytest.approx(2 * PLAN.moment(2, 1) / 2.4e-3 - PLAN.moment(2), rel=1e-10)


def test_a_thin_plate_has_the_inertia_of_its_points():
    """A rectangle, axis at a quarter of the chord: the double integral of s, c over it."""
    plan = replace(PLAN, table=ChordTable(span=(0.0, 1.0), chord=(1.0, 1.0)))
    wing, chord = thin_plate(plan, 2e-9, 0.25), 0.7e-3
    density = 2e-9 / (chord * 2.4e-3)

    def over(f):
        return density * dblquad(lambda c, s: f(s, c), 0.0, 2.4e-3, -0.75 * chord, 0.25 * chord, epsabs=0.0)[0]

    assert wing.centre == pytest.approx((1.2e-3, -0.25 * chord), rel=1e-12)
    assert wing.span_inertia == pytest.approx(over(lambda s, c: c * c), rel=1e-9)
    assert wing.chord_inertia == pytest.approx(over(lambda s, c: s * s), rel=1e-9)
    assert wing.normal_inertia == pytest.approx(over(lambda s, c: s * s + c * c), rel=1e-9)
    assert wing.product == pytest.approx(over(lambda s, c: -s * c), rel=1e-9)


@pytest.mark.parametrize(
    ("size", "sentence"),
    [
        ({"wing_length": 2.4}, r"wing_length must lie in 5e-05..0.2 metres, .*, got 2.4; write 2.4 \* mm"),
        ({"mass": 1.1}, r"mass must lie in 1e-10..0.1 kilograms, .*, got 1.1; write 1.1 \* mg"),
        ({"mean_chord": 0.7}, r"mean_chord must lie in 1e-06..0.2 metres"),
        ({"wing_length": 0.0}, r"wing_length must .* metres"),
        ({"mass": float("nan")}, r"mass must .* kilograms"),
        ({"wing_length": float("inf")}, r"wing_length must .* metres"),
    ],
)
def test_sizes_that_nothing_that_flaps_has_are_refused_with_their_unit(size, sentence):
    with pytest.raises(InvalidParameterError, match=sentence):
        replace(drosophila_hydei(), **size)


def test_bodies_that_cannot_be_are_refused():
    fly = drosophila_hydei()
    wing = fly.wing_body
    with pytest.raises(InvalidParameterError, match="No wing has these moments"):
        replace(wing, normal_inertia=2 * wing.normal_inertia)
    heavy = WingBody(mass=1e-6, centre=(0.0, 0.0), span_inertia=1.0, chord_inertia=1.0, normal_inertia=2.0)
    with pytest.raises(InvalidParameterError, match="do not fit into a fly"):
        replace(fly, wing=heavy)
    with pytest.raises(InvalidParameterError, match="at most the sum of the other two"):
        replace(fly, inertia=((1e-13, 0.0, 0.0), (0.0, 5e-13, 0.0), (0.0, 0.0, 1e-13)))
    with pytest.raises(InvalidParameterError, match="symmetric"):
        replace(fly, inertia=((4e-13, 1e-13, 0.0), (0.0, 5e-13, 0.0), (0.0, 0.0, 4e-13)))
    with pytest.raises(InvalidParameterError, match="pitch_axis"):
        replace(fly, pitch_axis=1.2)
    with pytest.raises(InvalidParameterError, match="rise from 0"):
        ChordTable(span=(0.1, 1.0), chord=(1.0, 1.0))
    with pytest.raises(InvalidParameterError, match="some of them > 0"):
        ChordTable(span=(0.0, 1.0), chord=(0.0, 0.0))
