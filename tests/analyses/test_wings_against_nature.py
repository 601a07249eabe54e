import json
from pathlib import Path

import numpy as np
import pytest
from lab_note import lab_note

ANALYSES = Path(__file__).resolve().parents[2] / "analyses"

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def results(real_data, tmp_path_factory):
    """The lab note's findings and the folder that it wrote."""
    note = lab_note("wings_against_nature")
    note.DATA = real_data
    folder = tmp_path_factory.mktemp("wings_against_nature")
    return note.main(folder), folder


def test_support_goes_with_the_fourth_power_of_wing_length_and_the_square_of_frequency(results):
    found, _ = results
    exponents = {i.name: i.exponent for i in found.influences}
    assert exponents["wing length"] == pytest.approx(4.0, abs=1e-9)
    assert exponents["frequency"] == pytest.approx(2.0, abs=1e-9)
    assert 2.0 < exponents["r2 / R"] < 2.3
    assert -1.3 < exponents["length / mean chord"] < -1.0  # rotation goes with the chord squared


def test_no_shift_of_the_angle_suits_both_lift_and_drag(results):
    found, _ = results
    lift, drag = found.misses["dickinson1999"]
    assert found.shift.angle > 5
    assert found.shift.lift_rms < lift.rms
    assert found.shift.drag_rms > drag.rms


def test_the_note_states_the_numbers_that_it_finds(results):
    found, folder = results
    text = " ".join((ANALYSES / "wings_against_nature.py").read_text(encoding="utf-8").replace("\n#", " ").split())
    hover, turned, free = (sum(terms.values()) for terms in found.terms.values())
    assert f"carries {free:.2f} of its weight and *D. melanogaster* in hover {hover:.2f}" in text
    assert f"the hover would carry {turned:.2f}" in text.replace("# ", "")
    length = found.influences[0]
    assert f"runs from {length.at_low:.2f} to {length.at_high:.2f}" in text
    lift, drag = found.misses["dickinson1999"]
    assert f"miss C_L by {lift.rms:.2f} rms" in text
    assert f"C_D by {drag.rms:.2f} and {found.misses['whitney2010'][1].rms:.2f}" in text
    terms = found.terms["D. melanogaster, hover"], found.terms["D. hydei, mean wingbeat"]
    assert f"rotation adds {terms[0]['rotational']:.2f} to the second and takes {-terms[1]['rotational']:.2f}" in text
    numbers = json.loads((folder / "wings_against_nature.json").read_text(encoding="utf-8"))
    assert np.isclose(numbers["model_less_measurement"]["dickinson1999"]["C_L"]["rms"], lift.rms, rtol=1e-5)
    assert (folder / "wings_against_nature.svg").stat().st_size < 300_000
    assert sorted(path.suffix for path in folder.iterdir()) == [".json", ".md", ".svg"]
