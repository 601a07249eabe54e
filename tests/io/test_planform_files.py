import json
from dataclasses import replace

import numpy as np
import pytest

from flycontrol.errors import InvalidInputError
from flycontrol.flight.blades import planform_blades
from flycontrol.io.morphology_files import morphology_in, read_morphology
from flycontrol.io.morphology_text import write_morphology
from flycontrol.io.planform_files import read_planform
from flycontrol.io.text_files import text_file
from flycontrol.io.toml_files import parse_toml

BASE = 'fly = "drosophila_melanogaster"\n'


def ellipse(count, chord=0.3):
    turn = 2 * np.pi * np.arange(count + 1) / count
    return np.stack([chord / 2 * np.cos(turn), (1 + np.sin(turn)) / 2], axis=1)


def write_points(path, points, separator=","):
    lines = [separator.join(map(repr, row)) for row in points.tolist()]
    path.write_text("\n".join(["# x, y", separator.join(["x", "y"]), *lines]))


def planform(folder, **keys):
    entries = ", ".join(f"{key} = {json.dumps(value)}" for key, value in keys.items())
    return morphology_in(parse_toml(text_file("fly.toml", f"{BASE}planform = {{ {entries} }}".encode())), folder=folder)


def test_an_outline_gives_a_fly_its_chords_and_its_area(tmp_path):
    write_points(tmp_path / "wing.csv", ellipse(400))
    fly = planform(tmp_path, file="wing.csv", format="outline").morphology
    assert fly.wing_area == pytest.approx(np.pi * 0.3 / 4 * 2.4e-3**2, rel=1e-4)
    assert fly.second_moment_radius == pytest.approx(np.sqrt(5) / 4, rel=1e-4)
    assert planform(tmp_path, file="wing.csv", format="outline").morphology == fly


def test_an_outline_may_be_in_a_unit_of_length(tmp_path):
    write_points(tmp_path / "wing.txt", 2.4 * ellipse(400), " ")
    write_points(tmp_path / "wing.csv", ellipse(400))
    in_mm = planform(tmp_path, file="wing.txt", format="outline", unit="mm").morphology
    assert in_mm.mean_chord == pytest.approx(
        planform(tmp_path, file="wing.csv", format="outline").morphology.mean_chord, rel=1e-12
    )
    with pytest.raises(InvalidInputError, match=r"tip of the outline lies 2\.4 wing lengths from the hinge"):
        planform(tmp_path, file="wing.txt", format="outline")


def test_a_fly_with_an_outline_is_written_and_read_back_equal(tmp_path):
    write_points(tmp_path / "wing.csv", ellipse(60))
    fly = planform(tmp_path, file="wing.csv", format="outline", source="flycontrol", certainty="C")
    again = read_morphology(write_morphology(fly, tmp_path / "fly.toml"))
    assert again.morphology == fly.morphology
    assert again.provenance["planform"] == fly.provenance["planform"]


def test_few_gauss_nodes_integrate_an_outline_exactly(tmp_path):
    """n nodes are exact for c(r) r^k, k < 2 n: the moments of the planform itself."""
    write_points(tmp_path / "wing.csv", ellipse(60))
    wing = planform(tmp_path, file="wing.csv", format="outline").morphology.planform
    blades = planform_blades(wing, 6)
    assert len(blades.radius) == 6
    for power in range(12):
        assert np.sum(blades.area * blades.radius**power) == pytest.approx(wing.moment(1, power), rel=1e-12)


def fourier(path, **changes):
    """A circle of diameter 1 that touches the hinge."""
    data = {"a0": 1.0, "ai": [0.0], "bi": [0.0], "xc": 0.0, "yc": 0.5, "convention": "R(th) = a0/2 + sum"} | changes
    path.write_text(json.dumps(data))
    return path


def test_a_fourier_outline_is_its_formula(tmp_path):
    circle = read_planform(fourier(tmp_path / "circle.json"), "Fourier outline")
    assert circle.mean_chord == pytest.approx(np.pi / 4, rel=5e-5)  # 512 points: (2 pi / 512)^2 / 6
    same = fourier(tmp_path / "same.json", a0=0.5, convention="")
    assert read_planform(same, "Fourier outline", constant="the mean").mean_chord == circle.mean_chord
    lobed = fourier(tmp_path / "lobed.json", ai=[0.0, 0.02], bi=[0.0, 0.0, 0.03], yc=0.49)
    turn = (np.arange(200000) + 0.5) * 2 * np.pi / 200000
    radius = 0.5 + 0.02 * np.cos(2 * turn) + 0.03 * np.sin(3 * turn)
    tip = (0.49 - radius * np.sin(turn)).max()
    found = read_planform(lobed, "Fourier outline")
    assert found.mean_chord == pytest.approx(np.mean(radius**2) * np.pi / tip**2, rel=1e-3)


TABLE = "0.7\n2.5\n0.0 0.0\n0.5 2.0\n1.0 0.0\n"


def test_a_chord_table_has_its_own_mean_chord(tmp_path):
    (tmp_path / "chords.txt").write_text(TABLE)
    fly = planform(tmp_path, file="chords.txt", format="chord table").morphology
    assert fly.mean_chord == pytest.approx(0.28 * 2.4e-3, rel=1e-14)
    assert fly.second_moment_radius == pytest.approx(np.sqrt(7 / 24), rel=1e-14)  # of a triangle, widest in the middle


def test_a_chord_given_beside_a_planform_sets_its_size(tmp_path):
    write_points(tmp_path / "wing.csv", ellipse(60))
    text = BASE + 'mean_chord = "0.5 mm"\nplanform = { file = "wing.csv", format = "outline" }'
    fly = morphology_in(parse_toml(text_file("fly.toml", text.encode())), folder=tmp_path).morphology
    plain = planform(tmp_path, file="wing.csv", format="outline").morphology
    assert fly == replace(plain, mean_chord=0.5e-3)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (TABLE.replace("0.7\n", ""), "begins with the mean chord and the wing length"),
        (TABLE.replace("0.7", "7"), "must be > 0, the first smaller, got 7 and 2.5"),
        (TABLE.replace("0.5 2.0", "0.5 -2.0"), "finite and >= 0"),
        (TABLE.replace("0.5 2.0", "1.5 2.0"), "positions that rise from 0"),
        (TABLE.replace("0.5 2.0", "0.5 2.0 3.0"), "3 fields where line 3 has 2"),
        (TABLE.replace("0.5 2.0", "0.5 wide"), "no ordinary number"),
        (TABLE.replace(" ", ","), "has 1 columns; two are needed"),
    ],
)
def test_chord_tables_that_are_none_are_refused_with_the_name_of_the_file(tmp_path, text, said):
    (tmp_path / "chords.txt").write_text(text)
    with pytest.raises(InvalidInputError, match=r"chords\.txt") as error:
        planform(tmp_path, file="chords.txt", format="chord table")
    assert said in str(error.value)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"convention": "R is a series"}, "does not state whether a0 is the mean radius or twice that"),
        ({"a0": -1.0}, "the radius of the outline falls to -0.5"),
        ({"ai": ["wide"]}, "ai holds something that is no ordinary number"),
        ({"yc": 5.0}, "tip of the outline lies 5.5 wing lengths"),
        ({"yc": 0.45}, "beyond the hinge"),
        ({"yc": []}, "a0, xc and yc must be numbers"),
    ],
)
def test_fourier_outlines_that_are_none_are_refused(tmp_path, changes, said):
    with pytest.raises(InvalidInputError, match=r"wing\.json") as error:
        read_planform(fourier(tmp_path / "wing.json", **changes), "Fourier outline")
    assert said in str(error.value)


@pytest.mark.parametrize(
    ("keys", "said"),
    [
        ({"file": "wing.csv"}, "either span and chord, two lists of equal length, or file and format"),
        ({"file": "wing.csv", "format": "outline", "span": [0.0, 1.0]}, "either span and chord"),
        ({"file": "wing.csv", "format": "outlines"}, "'outline', 'Fourier outline' or 'chord table'"),
        ({"file": "wing.csv", "format": "outline", "unit": "mg"}, "a mass; a length"),
        ({"file": "none.csv", "format": "outline"}, "there is no such file"),
        ({"file": "wing.csv", "format": "Fourier outline"}, "is not valid JSON"),
    ],
)
def test_planforms_that_cannot_be_meant_are_refused(tmp_path, keys, said):
    write_points(tmp_path / "wing.csv", ellipse(60))
    with pytest.raises(InvalidInputError) as error:
        planform(tmp_path, **keys)
    assert said in str(error.value)


def test_points_out_of_order_are_refused_with_the_name_of_the_file(tmp_path):
    points = ellipse(60)
    points[[10, 20]] = points[[20, 10]]
    write_points(tmp_path / "wing.csv", points)
    with pytest.raises(InvalidInputError, match=r"wing\.csv: an outline must not cross itself"):
        read_planform(tmp_path / "wing.csv", "outline")


@pytest.mark.parametrize("name", ["drosophila", "drosophila_maeda"])
def test_the_published_outlines_agree_with_their_series_and_with_the_area_that_is_stated(real_data, name):
    folder = real_data / "planforms"
    stated = json.loads((folder / f"{name}_fourier.json").read_text())
    series = read_planform(folder / f"{name}_fourier.json", "Fourier outline")
    points = read_planform(folder / f"contour_{name}.csv", "outline")
    assert series.mean_chord == pytest.approx(stated["area"] / stated["y_tip"] ** 2, rel=5e-5)
    assert series.second_moment_radius == pytest.approx(stated["r2"], rel=1e-4)
    assert points.mean_chord == pytest.approx(series.mean_chord, rel=1e-3)  # 200 points: (2 pi / 200)^2 / 6 = 2e-4
    assert points.second_moment_radius == pytest.approx(series.second_moment_radius, rel=1e-3)


def test_measured_wings_lie_in_the_published_range_and_a_tenth_of_the_mean_chord_from_the_beta_distribution(real_data):
    """Root mean square over the span; the wings of one species, drawn by three laboratories."""
    folder = real_data / "planforms"
    wings = [
        read_planform(folder / "contour_drosophila.csv", "outline"),
        read_planform(folder / "guf_chord_table.txt", "chord table"),
        read_planform(folder / "contour_drosophila_maeda.csv", "outline"),
    ]
    assert all(0.575 < wing.second_moment_radius < 0.595 for wing in wings)
    assert all(1 / 3.6 < wing.mean_chord < 1 / 3.3 for wing in wings[:2])
    assert all(wing.beta_difference() < 0.1 for wing in wings[:2])
    assert wings[2].mean_chord > 1 / 3.3  # the third is broader, and further from the beta distribution
    assert 0.1 < wings[2].beta_difference() < 0.12
