import json
from pathlib import Path

import pytest
from lab_note import lab_note

from flycontrol.units import ms

ANALYSES = Path(__file__).resolve().parents[2] / "analyses"

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    """The candidates by name, and the folder that the lab note wrote."""
    note = lab_note("nominal_gains")
    folder = tmp_path_factory.mktemp("nominal_gains")
    return {found.name: found for found in note.main(folder)}, folder


def test_the_shipped_gains_are_the_optimum_of_the_rule_rounded_into_the_deadline(results):
    found, _ = results
    shipped, rule = found["shipped"], found["rule"]
    assert (shipped.kp, shipped.kd) == (3050.0, 45.0)
    assert shipped.kp == pytest.approx(rule.kp, rel=0.01)
    assert shipped.kd == pytest.approx(rule.kd, rel=0.03)
    assert 0.99 * rule.modulus_margin < shipped.modulus_margin < rule.modulus_margin
    assert shipped.from_40_deg < 60 * ms - 0.5 * ms < rule.from_40_deg <= 60 * ms


def test_the_note_states_the_numbers_that_it_finds(results):
    found, _ = results
    text = " ".join((ANALYSES / "nominal_gains.py").read_text(encoding="utf-8").replace("\n#", " ").split())
    shipped, rule = found["shipped"], found["rule"]
    assert f"margin {shipped.modulus_margin:.3f}, recovery" in text
    assert f"{shipped.from_20_deg / ms:.1f} ms from 20 deg and {shipped.from_40_deg / ms:.1f} ms from 40 deg" in text
    assert f"modulus margin of {rule.modulus_margin:.3f}" in text


def test_decay_is_not_recovery(results):
    found, _ = results
    decay, recovery = found["fastest decay"], found["fastest recovery"]
    assert decay.decay > 1.4 * recovery.decay
    assert decay.from_40_deg > 2 * recovery.from_40_deg
    assert decay.modulus_margin > found["shipped"].modulus_margin > recovery.modulus_margin


def test_the_numbers_and_the_figure_are_written_and_small(results):
    found, folder = results
    numbers = json.loads((folder / "nominal_gains.json").read_text(encoding="utf-8"))
    assert numbers["shipped"]["modulus_margin"] == pytest.approx(found["shipped"].modulus_margin, rel=1e-5)
    assert (folder / "nominal_gains.svg").stat().st_size < 300_000
    assert sorted(path.suffix for path in folder.iterdir()) == [".json", ".md", ".svg"]
