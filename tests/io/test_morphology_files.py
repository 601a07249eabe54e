import re
from contextlib import suppress
from dataclasses import replace

import numpy as np
import pytest
from drawn_morphologies import morphologies, provenances
from hypothesis import given
from hypothesis import strategies as st

from flycontrol.errors import InvalidInputError, InvalidParameterError
from flycontrol.io.morphology_files import morphology_in, read_morphology
from flycontrol.io.morphology_tables import MorphologyTable, WingTable
from flycontrol.io.morphology_text import morphology_text, write_morphology
from flycontrol.io.published_flies import PUBLISHED
from flycontrol.io.quantities import KINDS, NUMBER, read_quantity
from flycontrol.io.quantity_text import quantity_text
from flycontrol.io.text_files import text_file
from flycontrol.io.toml_files import TomlFile, parse_toml
from flycontrol.model.morphology import drosophila_hydei, pitch_rotation
from flycontrol.model.planform import ChordTable
from flycontrol.model.provenance import SourcedMorphology
from flycontrol.model.references import cite

BASE = 'fly = "drosophila_melanogaster"\n'


def parsed(text, name="fly.toml"):
    return parse_toml(text_file(name, text.encode()))


def read(text):
    return morphology_in(parsed(text))


def refused(text):
    with pytest.raises(InvalidInputError) as error:
        read(text)
    sentence = str(error.value)
    assert sentence.startswith("fly.toml")
    assert "\n" not in sentence
    return sentence


@given(
    st.floats(allow_nan=False, allow_infinity=False),
    st.sampled_from([(kind, kind.unit) for kind in KINDS if kind is not NUMBER] + [(KINDS[2], "mm"), (KINDS[4], "mg")]),
)
def test_a_quantity_reads_back_to_the_last_bit(value, kind_and_unit):
    kind, unit = kind_and_unit
    assert read_quantity(quantity_text(value, kind, unit), kind, key="x").value == value


@given(morphologies(), st.data())
def test_what_is_written_reads_back_equal(fly, data):
    keys = ["mass", "wing_length", "mean_chord", "second_moment_radius", "pitch_axis", "stroke_plane_angle"]
    keys += ["right_hinge", "inertia"] + ["planform"] * (fly.chord_table is not None)
    keys += [f"wing.{key}" for key in ("mass", "centre", "span_inertia")] * (fly.wing is not None)
    known = {key: data.draw(provenances) for key in keys}
    again = read(morphology_text(SourcedMorphology(morphology=fly, provenance=known)))
    assert again.morphology == fly
    assert {key: again.provenance[key] for key in keys} == known


@pytest.mark.parametrize("name", PUBLISHED)
def test_a_published_fly_is_written_with_its_sources_and_read_back_equal(tmp_path, name):
    fly = read_morphology(name)
    again = read_morphology(write_morphology(fly, tmp_path / "fly.toml"))
    assert again.morphology == fly.morphology
    assert again.provenance == fly.provenance
    assert len(fly.provenance) == 8
    assert all(cite(known.source).label and known.certainty != "user" for known in fly.provenance.values())


def test_the_published_larger_fly_is_that_of_the_model():
    assert read_morphology("drosophila_hydei").morphology == drosophila_hydei()


def test_the_text_of_a_published_fly_has_its_published_numbers_as_they_are_printed():
    text = morphology_text(read_morphology("drosophila_melanogaster"))
    assert 'mass = { value = "1.1 mg", source = "cheng2009"' in text
    assert 'wing_length = { value = "2.4 mm"' in text
    assert 'stroke_plane_angle = { value = "55 deg"' in text


@given(morphologies())
def test_body_axes_and_stroke_plane_describe_one_fly(fly):
    R = pitch_rotation(fly.stroke_plane_angle)
    hinge_B, inertia_B = R.T @ fly.right_hinge, R.T @ fly.inertia_S @ R
    in_body = replace(fly, right_hinge=tuple(hinge_B.tolist()), inertia=tuple(map(tuple, inertia_B.tolist())))
    again = read(morphology_text(in_body).replace('frame = "stroke plane"', 'frame = "body"')).morphology
    assert np.allclose(again.right_hinge, fly.right_hinge, rtol=0, atol=1e-14 * fly.wing_length)
    assert np.allclose(again.inertia_S, fly.inertia_S, rtol=0, atol=1e-14 * np.trace(fly.inertia_S))


def test_a_table_of_a_larger_file_starts_from_a_fly_and_says_what_differs():
    toml = parsed(
        'title = "hover"\n[morphology]\nfly = "drosophila_melanogaster"\nmass = "1.2 mg"\nwing_area = "1.75 mm^2"'
    )
    fly, base = morphology_in(toml, "morphology").morphology, read_morphology("drosophila_melanogaster").morphology
    assert fly == replace(base, mass=1.2e-6, mean_chord=1.75e-6 / 2.4e-3)


def test_a_table_starts_from_a_file_beside_it(tmp_path):
    write_morphology(drosophila_hydei(), tmp_path / "mine.toml")
    (tmp_path / "heavy.toml").write_text('fly = "mine.toml"\nmass = "2 mg"')
    assert read_morphology(tmp_path / "heavy.toml").morphology == replace(drosophila_hydei(), mass=2e-6)


def test_flies_that_start_from_one_another_are_refused(tmp_path):
    (tmp_path / "a.toml").write_text('fly = "b.toml"')
    (tmp_path / "b.toml").write_text('fly = "./a.toml"')
    with pytest.raises(InvalidInputError, match="must not start from one another"):
        read_morphology(tmp_path / "a.toml")
    (tmp_path / "c.toml").write_text('fly = "../' + tmp_path.name + '/c.toml"')
    with pytest.raises(InvalidInputError, match="must not start from one another"):
        read_morphology(tmp_path / "c.toml")


def test_names_that_no_file_has_are_refused(tmp_path):
    for name in ("", ".", "a\0b", "x" * 900):
        with pytest.raises(InvalidInputError):
            morphology_in(TomlFile(text_file("fly.toml", b"x"), {"fly": name}), folder=tmp_path)


def test_three_moments_are_a_diagonal_inertia():
    fly = read(BASE + 'inertia = ["3e-13 kg m^2", "4e-13 kg m^2", "5e-13 kg m^2"]').morphology
    assert np.array_equal(fly.inertia_S, np.diag([3e-13, 4e-13, 5e-13]))


def test_the_shape_of_a_chord_table_tells_its_own_second_moment():
    """A triangle that is widest at the hinge: r2^2 = integral of (1 - x) x^2 dx over that of (1 - x) dx = 1/6."""
    fly = read(BASE + "planform = { span = [0.0, 1.0], chord = [1.0, 0.0] }").morphology
    assert fly.second_moment_radius == pytest.approx(np.sqrt(1 / 6), rel=1e-14)
    assert fly.chord_table == ChordTable(span=(0.0, 1.0), chord=(1.0, 0.0))


def wing(mass, centre, moments):
    """Text of a [wing]; centre in mm, moments about span, chord and normal, and the product, in kg m^2."""
    keys = ("span_inertia", "chord_inertia", "normal_inertia", "product")
    lines = [f'{key} = "{value} kg m^2"' for key, value in zip(keys, moments, strict=True)]
    return "\n".join(["[wing]", f'mass = "{mass}"', f'centre = ["{centre[0]} mm", "{centre[1]} mm"]', *lines])


WING = wing("2.4 ug", (1.27, -0.19), (2.2e-16, 4.7e-15, 4.9e-15, 6e-16))


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("mass = 1.1", 'mass is 1.1, without a unit; write a string with a unit, for example mass = "1.1 mg"'),
        ('mass = "1.1 mm"', "a length; a mass such as '1.1 mg' is needed"),
        ('mass = "1 kg"', "mass is '1 kg', outside the plausible 1 ug to 100 g"),
        ('mass = "-1 mg"', "outside the plausible"),
        ('mas = "1 mg"', "mas is not a key known here; the nearest known key is mass"),
        ('mass = { value = "1 mg", surce = "x" }', "the nearest known key is mass.source"),
        ('mass = { value = "1 mg", source = "cheng09" }', "the nearest is 'cheng2009'"),
        ('mass = { value = "1 mg", certainty = "sure" }', "'S', 'S2', 'C' or 'user'"),
        ('wing_length = "-2.4 mm"', "outside the plausible 0.1 mm to 200 mm"),
        ('mean_chord = "0.7 m"', "outside the plausible 0.5 to 30"),
        ('mean_chord = "-0.7 mm"', "mean chords long"),
        (
            'mean_chord = "0.7 mm"\nwing_area = "2 mm^2"',
            "exactly one of mean_chord, wing_length_over_mean_chord, wing_area",
        ),
        ("second_moment_radius = 0.9", "must lie in 0.4..0.8"),
        ("pitch_axis = 25.0", "must lie in 0..1 chords"),
        ("pitch_axis = nan", "a finite number without unit"),
        ('right_hinge = ["0.2 mm", "-0.4 mm", "-0.3 mm"]', "is it the left one?"),
        ('right_hinge = ["0.2 mm", "0 mm", "-0.3 mm"]', "to the right of the centre of mass"),
        ('right_hinge = ["0.2 mm", "40 mm", "-0.3 mm"]', "over 2 wing lengths; check its unit"),
        ('right_hinge = ["0.2 mm", "0.4 mm"]', "a list of 3 values is needed"),
        ('frame = "body"', "frame is that of right_hinge and inertia: give both"),
        ('frame = "world"', "'stroke plane' or 'body'"),
        ('inertia = ["1e-13 kg m^2", "1e-13 kg m^2", "3e-13 kg m^2"]', "at most the sum of the other two"),
        ('inertia = ["-1e-13 kg m^2", "1e-13 kg m^2", "1e-13 kg m^2"]', "positive principal moments"),
        ('inertia = ["1e-7 kg m^2", "1e-7 kg m^2", "1e-7 kg m^2"]', "radius of gyration of 126 wing lengths"),
        ('inertia = "1e-13 kg m^2"', "three moments, or three rows of three values, are needed"),
        ("planform = { span = [0.0, 1.0] }", "needs either span and chord"),
        ("planform = { span = [0.0, 1.0], chord = [1.0, inf] }", "must be finite and >= 0"),
        ("planform = { span = [0.0, 0.9], chord = [1.0, 1.0] }", "rise from 0 at the hinge to 1 at the tip"),
        ('planform = { span = [0.0, "1"], chord = [1.0, 1.0] }', "planform.span.1 is '1'"),
        (wing("0.6 mg", (1.27, -0.19), (5.5e-14, 1.18e-12, 1.23e-12, 1.5e-13)), "Two wings of 6e-07 kg do not fit"),
        (wing("2.4 ug", (2.5, 0.0), (2.2e-16, 1.6e-14, 1.62e-14, 0.0)), "lies outside the wing"),
        (wing("2.4 ug", (-1.27, -0.19), (2.2e-16, 4.7e-15, 4.9e-15, -6e-16)), "lies outside the wing"),
        (wing("2.4 ug", (1.27, -1.0), (3e-15, 5e-15, 8e-15, 3e-15)), "lies outside the wing"),
        (wing("2.4 ug", (1.27, 0.0), (2.2e-16, 4.7e-14, 4.7e-14, 0.0)), "chord_inertia of 4.7e-14 kg m^2 is more than"),
        (wing("2.4 ug", (1.27, -0.19), (2e-15, 4.7e-15, 6.6e-15, 6e-16)), "span_inertia of 2e-15 kg m^2 is more than"),
        (WING.replace("4.9e-15", "4.9e-14"), "No wing has these moments"),
        (WING.replace("span_inertia", "span_inertai"), "the nearest known key is wing.span_inertia"),
        (WING.replace('mass = "2.4 ug"\n', ""), "wing.mass is missing"),
    ],
)
def test_a_fly_that_cannot_be_is_refused_in_one_sentence(text, said):
    assert said in refused(BASE + text)


def test_a_morphology_on_its_own_must_be_whole():
    assert "mass is missing" in refused('species = "mine"')
    assert "second_moment_radius" in refused(
        re.sub(r"second_moment_radius = .*\n", "", morphology_text(drosophila_hydei()))
    )


def test_the_line_of_a_fault_is_named():
    toml = parsed('[morphology]\nfly = "drosophila_hydei"\n[morphology.wing]\nmass = 1')
    with pytest.raises(InvalidInputError, match=r"fly\.toml, line 3: morphology\.wing\.centre is missing"):
        morphology_in(toml, "morphology")
    toml = parsed('[morphology]\nfly = "drosophila_hydei"\nmass = 1')
    with pytest.raises(InvalidInputError, match=r"fly\.toml, line 3: morphology\.mass is 1, without a unit"):
        morphology_in(toml, "morphology")


def test_unknown_flies_are_refused():
    assert "is 3; the name of a published fly" in refused("fly = 3")
    with pytest.raises(InvalidInputError, match=r"musca\.toml: there is no such file"):
        read('fly = "musca.toml"')
    with pytest.raises(InvalidInputError, match="there are drosophila_melanogaster, drosophila_hydei"):
        read_morphology("drosofila")
    with pytest.raises(InvalidInputError, match="morphology is 3; a table is needed"):
        morphology_in(parsed("morphology = 3"), "morphology")


def test_impossible_values_are_refused_by_the_type_itself():
    fly = drosophila_hydei()
    for change in (
        {"mass": float("inf")},
        {"right_hinge": (0.0, -1e-4, 0.0)},
        {"right_hinge": (0.0, float("nan"), 0.0)},
        {"stroke_plane_angle": float("nan")},
        {"inertia": ((float("nan"),) * 3,) * 3},
    ):
        with pytest.raises(InvalidParameterError):
            replace(fly, **change)


anything = st.recursive(
    st.none() | st.booleans() | st.floats() | st.integers() | st.sampled_from(["3 deg", "1 mm", "1 mg", "", "body"]),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.sampled_from(["value", "span", "file"]), inner),
    max_leaves=6,
)


@given(st.sampled_from(["fly", *MorphologyTable.model_fields]), anything)
def test_no_value_crashes_the_reader(key, value):
    with suppress(InvalidInputError):
        morphology_in(TomlFile(text_file("fly.toml", b"x"), {"fly": "drosophila_hydei"} | {key: value}))


@given(st.sampled_from(list(WingTable.model_fields)), anything)
def test_no_value_of_a_wing_crashes_the_reader(key, value):
    wing_table = parse_toml(text_file("fly.toml", WING.encode())).data["wing"]
    data = {"fly": "drosophila_melanogaster", "wing": wing_table | {key: value}}
    with suppress(InvalidInputError):
        morphology_in(TomlFile(text_file("fly.toml", b"x"), data))
