import re
from dataclasses import replace

import pytest
from outline import Outline, leaves, read_json
from texts import overlapping_texts, texts_outside, unlabelled

from flycontrol.identify.flight import analyse_flight
from flycontrol.identify.turns import turn_sentence
from flycontrol.io.morphology import read_morphology_table
from flycontrol.io.recordings import read_recording
from flycontrol.model.morphology import morphology_from_table
from flycontrol.report.figures.turn_angles import turn_angles
from flycontrol.report.figures.turning import turning
from flycontrol.report.figures.wing_motion import wing_motion
from flycontrol.report.flight_result import FLIGHT_FIELDS
from flycontrol.report.page import page
from flycontrol.report.provenance import provenance
from flycontrol.report.result import FIELDS, result_json

FLIGHTS = ("20121009_S0003", "20121120_S0001", "20121128_S0003")


@pytest.fixture(scope="module", params=FLIGHTS)
def analysis(request, real_data):
    return analysed(real_data, request.param)


@pytest.fixture(scope="module")
def one_analysis(real_data):
    return analysed(real_data, FLIGHTS[2])


def analysed(folder, name):
    recording = read_recording(folder / "muijres_freeflight" / f"{name}.txt", "muijres_freeflight")
    table = read_morphology_table("drosophila_hydei")
    return analyse_flight(recording, morphology_from_table(table, species="Drosophila hydei", wingbeat_frequency=189.0))


@pytest.fixture(scope="module")
def whole_page(stable, parameters, analysis):
    return page(stable, parameters, provenance(parameters, "flycontrol report", analysis), analysis)


def test_a_real_flight_gets_its_part_of_the_page(whole_page, analysis):
    outline = Outline(whole_page)
    assert not outline.errors
    assert len(outline.ids) == len(set(outline.ids))
    assert {"figure-flight-wings", "figure-flight-turning", "figure-flight-angles"} <= set(outline.ids)
    assert f"{analysis.turning.plant.r2_acceleration_best:.0%}" in outline.text
    assert analysis.recording.source_sha256 in outline.text
    assert "20101020" in outline.text  # the seed of the bootstrap
    assert len(whole_page.encode()) < 1.5e6
    assert not re.search(r"\b(nan|inf|None)\b", outline.text)


def test_every_turn_and_every_convention_stands_in_a_table(whole_page, analysis):
    rows = re.findall(r"<tr><th scope=\"row\">.*?</tr>", whole_page)
    for test in analysis.conventions.tests:
        assert any(test.convention in row and test.finding in row for row in rows)
    text = Outline(whole_page).text
    assert not any(turn_sentence(turn) in text for turn in analysis.turning.turns)  # the table says it
    assert sum("–" in row for row in rows) >= len(analysis.turning.turns)


def test_its_figures_have_units_and_no_text_overlaps(analysis):
    found = analysis.turning
    for figure in (wing_motion(analysis), turning(found), turn_angles(found.turns)):
        assert not unlabelled(figure)
        assert not texts_outside(figure)
        assert not overlapping_texts(figure)


def test_its_numbers_are_documented_and_finite(stable, parameters, analysis):
    origin = provenance(parameters, "flycontrol report", analysis)
    found = read_json(result_json(stable, parameters, origin, analysis))
    assert set(found["fields"]) == set(FIELDS) | set(FLIGHT_FIELDS)
    present = set(leaves({"flight": found["flight"]}))
    assert present <= set(FLIGHT_FIELDS)
    assert found["flight"]["plants"]["as_it_stands"]["r2_simulated"] == analysis.turning.plant.r2_simulated
    assert found["provenance"]["recording_sha256"] == analysis.recording.source_sha256


def test_a_hostile_recording_name_is_never_markup(stable, parameters, one_analysis):
    hostile = replace(one_analysis, recording=replace(one_analysis.recording, name="<script>alert(1)</script>"))
    written = page(stable, parameters, provenance(parameters, "flycontrol report", hostile), hostile)
    assert "<script" not in written
    assert "<script>alert(1)</script>" in Outline(written).text


def test_a_flight_without_turns_and_without_a_plant_still_gets_a_page(stable, parameters, one_analysis):
    poor = replace(
        one_analysis.turning, plant=None, plant_with_coupling=None, turns=(), status="5 wingbeats are too few."
    )
    bare = replace(
        one_analysis, turning=poor, conventions=None, blade_elements=None, torque=None, verdicts=("Too few.",)
    )
    origin = provenance(parameters, "flycontrol report", bare)
    text = Outline(page(stable, parameters, origin, bare)).text
    assert "5 wingbeats are too few." in text
    assert "no turn of 5° or more" in text
    assert read_json(result_json(stable, parameters, origin, bare))["flight"]["plants"]["as_it_stands"] is None
