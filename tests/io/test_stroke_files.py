import json
from contextlib import suppress
from dataclasses import fields

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from flycontrol.errors import InvalidInputError, InvalidParameterError
from flycontrol.io.series_conventions import CONVENTIONS, AngleSeries, SeriesConvention
from flycontrol.io.series_files import read_series_file
from flycontrol.io.stroke_files import read_stroke, stroke_in
from flycontrol.io.stroke_tables import BermanWangTable, SamplesTable
from flycontrol.io.stroke_text import stroke_text
from flycontrol.io.text_files import text_file
from flycontrol.io.toml_files import TomlFile, parse_toml
from flycontrol.model.stroke_kinematics import StrokeKinematics, hover_stroke
from flycontrol.model.wing_stroke import BermanWangStroke, FourierStroke, ModulatedStroke, Modulation
from flycontrol.units import deg

HOVER = """\
frequency = "220 Hz"
[both]
kind = "Berman and Wang"
stroke_amplitude = "70 deg"
stroke_shape = 0.7
pitch_amplitude = "45 deg"
pitch_shape = 2.0
pitch_lead = "5 deg"
"""
PHASE = np.arange(40) / 40


def parsed(text):
    return parse_toml(text_file("stroke.toml", text.encode()))


def read(text, folder=None, **options):
    return stroke_in(parsed(text), folder=folder, **options)


def refused(text, folder=None, **options):
    with pytest.raises(InvalidInputError) as error:
        read(text, folder, **options)
    assert "\n" not in str(error.value)
    return str(error.value)


def same(one, other, tolerance=1e-14):
    return all(
        np.allclose(getattr(one(PHASE), field.name), getattr(other(PHASE), field.name), rtol=0, atol=tolerance)
        for field in fields(one(PHASE))
    )


def test_the_built_in_stroke_is_written_with_its_parameters():
    assert read(HOVER) == hover_stroke(220.0)


angles = st.floats(-3.0, 3.0)


@given(
    st.builds(
        BermanWangStroke,
        stroke_amplitude=angles,
        stroke_shape=st.floats(1e-3, 0.999),
        stroke_offset=angles,
        pitch_amplitude=angles,
        pitch_shape=st.floats(1e-3, 100.0),
        pitch_lead=angles,
        pitch_offset=angles,
        deviation_amplitude=angles,
        deviation_order=st.integers(1, 100),
        deviation_phase=angles,
        deviation_offset=angles,
    )
)
def test_every_stroke_of_the_family_is_read_as_it_is_written(stroke):
    kinematics = StrokeKinematics.symmetric(stroke, 220.0)
    assert read(stroke_text(kinematics)) == kinematics


rows = arrays(np.float64, (3, 5), elements=st.floats(-3.0, 3.0))


@given(rows, rows)
def test_every_series_is_read_as_it_is_written(cosine, sine):
    sine[:, 0] = 0.0
    written = StrokeKinematics(
        frequency=187.3, left=FourierStroke(cosine=cosine, sine=sine), right=FourierStroke(cosine=sine, sine=sine)
    )
    again = read(stroke_text(written))
    assert again.frequency == written.frequency
    for side in ("left", "right"):
        assert np.array_equal(again.wing(side).cosine, written.wing(side).cosine)
        assert np.array_equal(again.wing(side).sine, written.wing(side).sine)


def test_a_modulated_stroke_is_not_written():
    with pytest.raises(InvalidInputError, match="ModulatedStroke is not written as TOML"):
        stroke_text(hover_stroke().modulated(Modulation(), Modulation(stroke_gain=0.1)))


def test_a_fourier_series_is_its_formula():
    text = """
    frequency = "200 Hz"
    [both]
    kind = "Fourier"
    stroke = { mean = "3 deg", cosine = ["-70 deg", "2 deg"], sine = ["1 deg"] }
    pitch = { mean = "90 deg", sine = ["-45 deg", "0 deg", "4 deg"] }
    """
    turn = 2 * np.pi * PHASE
    found = read(text).left(PHASE).angles / deg
    assert np.allclose(found[:, 0], 3 - 70 * np.cos(turn) + 2 * np.cos(2 * turn) + np.sin(turn), atol=1e-12)
    assert np.allclose(found[:, 1], 0.0, atol=1e-15)
    assert np.allclose(found[:, 2], 90 - 45 * np.sin(turn) + 4 * np.sin(3 * turn), atol=1e-12)


coefficients = st.lists(st.floats(-90, 90), min_size=1, max_size=6)


@given(coefficients, coefficients, st.floats(-90, 90), st.floats(-1, 1), st.booleans())
def test_a_file_of_series_means_what_its_convention_says(tmp_path_factory, cosine, sine, a0, advance, twice):
    path = tmp_path_factory.getbasetemp() / "series.json"
    path.write_text(json.dumps({"phi": {"a": cosine, "b": sine, "a0": a0}, "eta": {"b": sine}}))
    convention = SeriesConvention(
        unit=deg,
        constant="twice the mean" if twice else "the mean",
        stroke=AngleSeries(cosine="phi.a", sine="phi.b", constant="phi.a0", sign=-1, advance=advance, scale=1.5),
        pitch=AngleSeries(sine="eta.b", offset=90 * deg),
    )
    found = read_series_file(path, convention)(PHASE).angles / deg

    def series(cosine, sine, phase):
        cos = sum(a * np.cos(2 * np.pi * k * phase) for k, a in enumerate(cosine, 1))
        return cos + sum(b * np.sin(2 * np.pi * k * phase) for k, b in enumerate(sine, 1))

    mean = a0 / 2 if twice else a0
    assert np.allclose(found[:, 0], -1.5 * (mean + series(cosine, sine, PHASE + advance)), atol=1e-10)
    assert np.allclose(found[:, 2], 90 + series([], sine, PHASE), atol=1e-10)


def test_a_convention_is_spelt_out_in_a_table(tmp_path):
    (tmp_path / "mine.json").write_text(json.dumps({"position": [70.0], "feathering": [45.0], "a0": 20.0}))
    text = """
    frequency = "220 Hz"
    [both]
    kind = "Fourier file"
    file = "mine.json"
    [both.convention]
    unit = "deg"
    constant = "twice the mean"
    stroke = { cosine = "position", constant = "a0", sign = -1 }
    pitch = { sine = "feathering", sign = -1, offset = "90 deg", advance = 0.05 }
    """
    found = read(text, tmp_path).right(PHASE).angles / deg
    assert np.allclose(found[:, 0], -10 - 70 * np.cos(2 * np.pi * PHASE), atol=1e-12)
    assert np.allclose(found[:, 2], 90 - 45 * np.sin(2 * np.pi * (PHASE + 0.05)), atol=1e-12)


NAMED = {
    "hovering fruit fly": "Drosophila_hovering_fry.json",
    "robofly": "flapper_dickinson.json",
    "robofly, mean stroke 10 deg": "flapper_ramamurti.json",
}


def published(real_data, name):
    text = f'frequency = "220 Hz"\n[both]\nkind = "Fourier file"\nfile = "{NAMED[name]}"\nconvention = "{name}"'
    return read(text, real_data / "kinematics_fourier", periodic=True).left


@pytest.mark.parametrize("name", CONVENTIONS)
def test_published_strokes_start_at_the_dorsal_reversal_with_the_leading_edge_ahead(real_data, name):
    fine = np.arange(1000) / 1000
    angles = published(real_data, name)(fine).angles / deg
    assert min(fine[np.argmin(angles[:, 0])], 1 - fine[np.argmin(angles[:, 0])]) < 0.02
    assert np.all(angles[150:350, 2] < 60)  # attack angle on the forward stroke
    assert np.all(180 - angles[650:850, 2] < 60)


def test_the_mean_of_the_published_strokes_is_half_of_a0(real_data):
    hover = published(real_data, "hovering fruit fly")(PHASE).angles.mean(axis=0) / deg
    assert hover == pytest.approx((-25.4649398 / 2, 17.8244658 / 2, 90 + 0.3056968 / 2), rel=1e-12)
    assert published(real_data, "robofly, mean stroke 10 deg")(PHASE).angles[:, 0].mean() / deg == pytest.approx(-10)
    assert np.ptp(published(real_data, "robofly")(PHASE).angles[:, 2]) / deg == pytest.approx(100, abs=0.1)  # 40 to 140


def test_the_hovering_fruit_fly_moves_its_wings_as_another_laboratory_measured_another_species(real_data):
    """The sign of every angle: all three correlate with the mean wingbeat of D. hydei, whose signs lift decided."""
    table = np.genfromtxt(real_data / "muijres_mean_wingbeats" / "steady_free_flight.csv", delimiter=",", names=True)[
        :-1
    ]
    measured = np.stack([-table["stroke_mean_deg"], table["dev_mean_deg"], 180 - table["pitch_mean_deg"]])
    found = published(real_data, "hovering fruit fly")(np.arange(len(table)) / len(table)).angles.T
    stroke, deviation, pitch = (float(np.corrcoef(*pair)[0, 1]) for pair in zip(found, measured, strict=True))
    assert stroke > 0.99
    assert deviation > 0.8
    assert pitch > 0.98


def wingbeat_file(path, phase, turns=None):
    turn = 2 * np.pi * (phase if turns is None else turns)
    columns = [phase, 60 * np.cos(turn), 3 * np.sin(2 * turn), 45 * np.sin(turn)]
    path.write_text(
        "p,phi,theta,alpha\n" + "\n".join(",".join(map(repr, row)) for row in np.stack(columns, 1).tolist())
    )


SAMPLES = """\
frequency = "200 Hz"
[both]
kind = "samples"
file = "wing.csv"
phase = { column = "p" }
stroke = { column = "phi", unit = "deg", sign = -1 }
deviation = { column = "theta", unit = "deg" }
pitch = { column = 3, unit = "deg", sign = -1, offset = "90 deg" }
periodic = true
"""
FOURIER = """\
frequency = "200 Hz"
[both]
kind = "Fourier"
stroke = { cosine = ["-60 deg"] }
deviation = { sine = ["0 deg", "3 deg"] }
pitch = { mean = "90 deg", sine = ["-45 deg"] }
"""


@pytest.mark.parametrize("count", [200, 201])
def test_a_measured_wingbeat_is_closed_whether_or_not_its_end_is_written_twice(tmp_path, count):
    """A quintic spline of a sine over h = 2 pi / 200: error in x about h^6 / 100, in x'' about h^4."""
    phase = np.arange(count) / 200
    wingbeat_file(tmp_path / "wing.csv", phase, phase % 1.0)
    found, truth = read(SAMPLES, tmp_path, periodic=True).left, read(FOURIER).left
    assert found.periodic
    assert np.allclose(found(PHASE + 3).angles, truth(PHASE).angles, rtol=0, atol=1e-9)
    assert np.allclose(found(PHASE).second, truth(PHASE).second, rtol=0, atol=1e-4)


def test_harmonics_of_many_wingbeats_are_their_series(tmp_path):
    wingbeat_file(tmp_path / "wing.csv", np.arange(700) / 200)
    found = read(SAMPLES.replace("periodic = true", "periodic = false\nharmonics = 4"), tmp_path, periodic=True)
    assert same(found.left, read(FOURIER).left, 1e-10)


def test_times_become_phases_by_the_frequency_and_the_start(tmp_path):
    wingbeat_file(tmp_path / "wing.csv", np.arange(200) / 200 * 5.0 + 100.0, np.arange(200) / 200)  # 200 Hz: 5 ms
    timed = SAMPLES.replace('phase = { column = "p" }', 'time = { column = "p", unit = "ms" }\nstart = "100 ms"')
    found = read(timed, tmp_path).left
    assert np.allclose(found(PHASE).angles, read(FOURIER).left(PHASE).angles, rtol=0, atol=1e-9)


def test_a_periodic_stroke_is_asked_for_and_refused_in_one_sentence(tmp_path):
    wingbeat_file(tmp_path / "wing.csv", np.arange(700) / 200)
    once = SAMPLES.replace("periodic = true", "periodic = false")
    assert not read(once, tmp_path).left.periodic
    assert "the left and the right wing's stroke is not the same in every wingbeat" in refused(
        once, tmp_path, periodic=True
    )
    ramp = HOVER + '[[modulation]]\nwing = "right"\nstroke_gain = 0.1\nramp = [1.0, 2.0]'
    assert "stroke.toml, line 2: the right wing's stroke" in refused(ramp, periodic=True)
    assert "span one wingbeat, and these span 3.495" in refused(SAMPLES, tmp_path)
    wingbeat_file(tmp_path / "wing.csv", np.arange(201) / 200, np.arange(201) / 210)
    assert "must end where they began" in refused(SAMPLES, tmp_path)


def test_modulations_are_laid_one_over_the_other():
    text = (
        HOVER
        + """
    [[modulation]]
    paddling = "6 deg"
    [[modulation]]
    wing = "left"
    stroke_gain = 0.1
    stroke_offset = "3 deg"
    ramp = [5.0, 6.5]
    """
    )
    plain, found = hover_stroke(220.0).left, read(text)
    right = ModulatedStroke(
        stroke=plain, before=Modulation(pitch_offset=6 * deg), after=Modulation(pitch_offset=6 * deg)
    )
    left = ModulatedStroke(
        stroke=plain, before=Modulation(pitch_offset=-6 * deg), after=Modulation(pitch_offset=-6 * deg)
    )
    change = Modulation(stroke_gain=0.1, stroke_offset=3 * deg)
    assert found.right == right
    assert found.left == ModulatedStroke(stroke=left, after=change, ramp=(5.0, 6.5))


def test_wings_may_differ(tmp_path):
    both = HOVER.split("[both]\n")[1]
    text = 'frequency = "220 Hz"\n[left]\n' + both + "[right]\n" + both.replace("70 deg", "60 deg")
    (tmp_path / "stroke.toml").write_text(text)
    found = read_stroke(tmp_path / "stroke.toml")
    assert (found.left.stroke_amplitude, found.right.stroke_amplitude) == (70 * deg, 60 * deg)


def test_the_table_of_a_larger_file_is_read_with_its_lines():
    text = "[stroke]\n" + HOVER.replace("[both]", "[stroke.both]")
    assert stroke_in(parsed(text), "stroke") == hover_stroke(220.0)
    bad = text + '[[stroke.modulation]]\nwing = "left"\n[[stroke.modulation]]\nwing = "left"\nstroke_offset = 3'
    with pytest.raises(
        InvalidInputError, match=r"stroke\.toml, line 14: stroke\.modulation\.1\.stroke_offset is 3, wi"
    ):
        stroke_in(parsed(bad), "stroke")


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        (
            '"220 Hz"',
            "220",
            'frequency is 220, without a unit; write a string with a unit, for example frequency = "220',
        ),
        ('"220 Hz"', '"220 kHz"', "outside the plausible 1 Hz to 2000 Hz"),
        ('"70 deg"', "70", "both.stroke_amplitude is 70, without a unit"),
        ('"70 deg"', '"70 rad"', "outside the plausible -180 deg to 180 deg"),
        ("stroke_amplitude", "stroke_amplitud", "the nearest known key is stroke_amplitude"),
        ("stroke_shape = 0.7", "stroke_shape = 1.0", "must lie in 0..1"),
        ("pitch_shape = 2.0", "pitch_shape = 0.0", "pitch_shape must be > 0"),
        ("Berman and Wang", "Bermann and Wang", "one of 'Berman and Wang', 'Fourier'"),
        ("Berman and Wang", "hover", "'Fourier file', 'samples' is needed"),
        ("[both]", "[left]", "a table for both wings, or else left and right"),
        ("[both]", "[both.more]", "both.kind is None"),
        ("[both]", "[beide]", "beide is not a key known here"),
        ("[both]", "modulation = [{ stroke_gain = 0.1 }]\n[both]", "modulation.0.wing is missing"),
        ("[both]", 'modulation = [{ wing = "left", stroke_gain = -1.0 }]\n[both]', "greater than -1"),
        ("[both]", 'modulation = [{ wing = "left", stroke_gain = 0.1, ramp = [2.0, 1.0] }]\n[both]', "must end after"),
        ("[both]", 'modulation = [{ wing = "left", paddling = "3 deg" }]\n[both]', "stands alone"),
        ("[both]", 'modulation = [{ paddling = "300 deg" }]\n[both]', "outside the plausible -90 deg to 90 deg"),
    ],
)
def test_a_stroke_that_cannot_be_meant_is_refused(old, new, said):
    assert said in refused(HOVER.replace(old, new, 1))


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('file = "wing.csv"', 'file = "none.csv"', "there is no such file"),
        ('column = "phi"', 'column = "psi"', "has no column named 'psi'; the nearest is 'phi'"),
        ('column = "phi", unit = "deg"', 'column = "phi"', "both.stroke.unit is missing"),
        ('column = "phi", unit = "deg"', 'column = "phi", unit = "mm"', "an angle such as"),
        ('column = "phi", unit = "deg"', 'column = "phi", unit = "rad"', "are the numbers degrees?"),
        ('column = "phi"', 'row = "phi"', "needs one column"),
        ('phase = { column = "p" }\n', "", "phase or time is needed"),
        ("periodic = true\n", "", "both.periodic is missing"),
        ("periodic = true", "periodic = true\nharmonics = 100", "100 harmonics need 201 samples"),
        ("periodic = true", 'periodic = true\nstart = "1 ms"', "belongs to time, not to phase"),
        ('phase = { column = "p" }', 'time = { column = "p", unit = "s" }', "these span 199"),
    ],
)
def test_samples_that_are_not_as_the_table_says_are_refused(tmp_path, old, new, said):
    wingbeat_file(tmp_path / "wing.csv", np.arange(200) / 200)
    assert said in refused(SAMPLES.replace(old, new, 1), tmp_path)


def test_samples_out_of_order_or_with_holes_are_refused(tmp_path):
    wingbeat_file(tmp_path / "wing.csv", np.array([0.0, 0.2, 0.1, 0.3, 0.4, 0.5, 0.6]))
    assert "must rise from sample to sample" in refused(SAMPLES, tmp_path)
    text = (tmp_path / "wing.csv").read_text().replace("\n0.2,", "\n0.05,").replace("0.3,", "nan,")
    (tmp_path / "wing.csv").write_text(text)
    assert "is not a usable number" in refused(SAMPLES, tmp_path)


@pytest.mark.parametrize(
    ("content", "said"),
    [
        ("no json", "is not valid JSON"),
        ("[1]", "no JSON object"),
        ('{"convention": "a0 is the mean"}', "states the convention 'a0 is the mean'"),
        ('{"convention": "u(t)=a0/2+sum ai cos(2 pi i t)+bi sin(2 pi i t)"}', "holds no 'phi.ai'"),
        ('{"convention": "u(t)=a0/2+sum ai cos(2 pi i t)+bi sin(2 pi i t)", "phi": {"aj": []}}', "there are 'aj'"),
        (
            '{"convention": "u(t)=a0/2+sum ai cos(2 pi i t)+bi sin(2 pi i t)", "phi": {"ai": ["x"]}}',
            "no ordinary number",
        ),
    ],
)
def test_files_of_series_that_mean_something_else_are_refused(tmp_path, content, said):
    (tmp_path / "series.json").write_text(content)
    text = 'frequency = "220 Hz"\n[both]\nkind = "Fourier file"\nfile = "series.json"\n'
    assert said in refused(text + 'convention = "hovering fruit fly"', tmp_path)
    assert "'hovering fruit fly', 'robofly'" in refused(text + 'convention = "fry"', tmp_path)
    assert "both.convention is missing" in refused(text, tmp_path)


def test_a_ramp_runs_forward():
    with pytest.raises(InvalidParameterError, match="must end after it starts"):
        ModulatedStroke(stroke=hover_stroke().left, ramp=(1.0, 1.0))


anything = st.recursive(
    st.none() | st.booleans() | st.floats() | st.integers() | st.sampled_from(["3 deg", "1 mm", "", "both", "Fourier"]),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.sampled_from(["value", "mean", "kind"]), inner),
    max_leaves=4,
)
KEYS = ["frequency", "both", "left", "right", "modulation", "kind", "file", "stroke", "pitch", "ramp", "wing", "phase"]


@given(st.dictionaries(st.sampled_from(KEYS), anything | st.dictionaries(st.sampled_from(KEYS), anything)))
def test_no_table_crashes_the_reader(data):
    toml = TomlFile(text_file("stroke.toml", b"x"), {"frequency": "220 Hz"} | data)
    with pytest.raises(InvalidInputError, match=r"stroke\.toml"):
        stroke_in(toml)


@given(st.sampled_from(list(BermanWangTable.model_fields)), anything)
def test_no_value_of_the_family_crashes_the_reader(key, value):
    table = {"kind": "Berman and Wang", "stroke_amplitude": "70 deg"} | {key: value}
    with suppress(InvalidInputError):
        stroke_in(TomlFile(text_file("stroke.toml", b"x"), {"frequency": "220 Hz", "both": table}))


@given(st.sampled_from(list(SamplesTable.model_fields)), anything | st.just({"column": 0, "unit": "deg"}))
def test_no_value_of_samples_crashes_the_reader(tmp_path_factory, key, value):
    folder = tmp_path_factory.getbasetemp()
    wingbeat_file(folder / "wing.csv", np.arange(20) / 20)
    table = parsed(SAMPLES).data["both"] | {key: value}
    with suppress(InvalidInputError):
        stroke_in(TomlFile(text_file("stroke.toml", b"x"), {"frequency": "220 Hz", "both": table}), folder=folder)


@pytest.mark.parametrize("value", [10**400, -(10**400), float("nan"), float("inf")])
def test_numbers_beyond_all_numbers_are_refused(value):
    for key in ("stroke_shape", "deviation_order"):
        table = {"kind": "Berman and Wang", "stroke_amplitude": "70 deg", key: value}
        with pytest.raises(InvalidInputError, match=key):
            stroke_in(TomlFile(text_file("stroke.toml", b"x"), {"frequency": "220 Hz", "both": table}))
    ramp = {"wing": "left", "stroke_gain": 0.1, "ramp": [0.0, value]}
    toml = parsed(HOVER)
    with pytest.raises(InvalidInputError, match="ramp"):
        stroke_in(TomlFile(toml.file, toml.data | {"modulation": [ramp]}))
