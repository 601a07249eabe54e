"""The lab note on symmetrised turns, with few films and draws."""

import importlib
import json
import sys
from pathlib import Path

import numpy as np
import pytest

ANALYSES = Path(__file__).resolve().parents[2] / "analyses"
IMPORTED = ("which_angle_turns_the_fly", "replayed_flights", "hinge_as_a_spring")

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def note(real_data, tmp_path_factory):
    """What it finds, and the folder it wrote."""
    sys.path.insert(0, str(ANALYSES))
    analysis, *others = (importlib.import_module(name) for name in IMPORTED)
    for module in (analysis, *others):
        module.DATA = real_data
    analysis.DRAWS, analysis.FILMS = 80, 2
    folder = tmp_path_factory.mktemp("note")
    yield analysis.main(folder), folder
    sys.path.remove(str(ANALYSES))
    for name in IMPORTED:
        del sys.modules[name]


def test_turns_made_by_pitch_are_attributed_to_pitch_by_nine_tenths_through_a_trackers_jitter(note):
    by_pitch = [known for known in note[0].known if known.steering.by == ("pitch",)]
    assert len(by_pitch) == 2
    assert all(known.filmed.shapley["pitch"].value >= 0.9 for known in by_pitch)
    assert all(known.turned > 0 for known in by_pitch)


def test_a_turn_made_by_stroke_is_not_attributed_to_pitch(note):
    """One strong enough to stand out of the jitter."""
    (known,) = [known for known in note[0].known if known.steering.name == "stroke amplitude, 30 %"]
    found = known.filmed.shapley
    assert found["pitch"].high < 0.5 < found["stroke"].low


def test_a_turn_within_the_jitter_has_no_bounds_and_the_note_says_so(note):
    (known,) = [known for known in note[0].known if known.steering.name == "stroke amplitude, 10 %"]
    assert not np.isfinite(known.filmed.shapley["pitch"].low)
    assert "Of the turns by stroke amplitude, 10 %" in (note[1] / "which_angle_turns_the_fly.md").read_text()


def test_shares_of_a_mixed_turn_add_up_within_the_interaction_that_is_stated(note):
    """The interaction is small: it is 1 less the shares of each angle alone, in the torque and in the turn angle."""
    mixed = note[0].known[-1]
    for known in (mixed.truth, mixed.flown):
        assert abs(known.alone.sum() / known.total - 1) < 0.1
        assert np.allclose(known.alone, known.all_but_one, rtol=0, atol=0.1 * abs(known.total))


def test_turn_angles_of_the_versions_are_shared_like_their_torques(note):
    """But for the wings' asymmetry in the damping, and the beginning and the end of the steering."""
    for known in note[0].known:
        turn, torque = (f.shapley / f.total for f in (known.flown, known.truth))
        assert np.allclose(turn, torque, rtol=0, atol=0.12)


def test_pitch_has_the_largest_share_of_the_level_turn_and_stroke_none(note):
    shares = note[0].level.shares
    for name in ("as it is", "less the quiet wingbeats after"):
        assert shares[name].shapley["pitch"].value > 0.5
        assert abs(shares[name].shapley["stroke"].value) < 0.2
    assert 50 < np.degrees(note[0].level.angle) < 70


def test_the_slopes_parts_add_up_to_that_of_the_replay(note):
    """The replay's own is 1.04 and 1.63 in the turning flights."""
    slopes = note[0].slopes
    for name, whole in (("20121009_S0003", 1.04), ("20121120_S0001", 1.63)):
        assert abs(slopes[name].symmetric.value + slopes[name].total.value - whole) < 0.01


def test_the_note_its_numbers_and_its_figure_are_there(note):
    folder = note[1]
    assert sorted(path.suffix for path in folder.iterdir()) == [".json", ".md", ".svg"]
    assert (folder / "which_angle_turns_the_fly.svg").stat().st_size < 300_000
    numbers = json.loads((folder / "which_angle_turns_the_fly.json").read_text(encoding="utf-8"))
    assert len(numbers["simulated"]) == 6
    assert numbers["level_turn"]["shares"]["as it is"]["shapley"]["pitch"][0] > 0.5
