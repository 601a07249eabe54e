"""The lab notes on another tracker, on the last third of the frames, where wings beat."""

import importlib
import json
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from flycontrol.io.claims import read_claims
from flycontrol.units import deg

ANALYSES = Path(__file__).resolve().parents[2] / "analyses"
NOTES = ("_drawn_flies", "conventions_of_another_tracker", "beside_another_tracker")
LAST = slice(31, None)

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def notes(real_data):
    """By name; they import one another as scripts in one folder do."""
    sys.path.insert(0, str(ANALYSES))
    found = {name: importlib.import_module(name) for name in NOTES}
    found["conventions_of_another_tracker"].DATA = real_data
    yield found
    sys.path.remove(str(ANALYSES))
    for name in NOTES:
        del sys.modules[name]


@pytest.fixture(scope="module")
def results(notes, tmp_path_factory):
    """Findings on sixteen frames, and the folder that was written."""
    note = notes["beside_another_tracker"]
    take = note.read_take()
    note.read_take = lambda: replace(
        take, frames=take.frames[LAST], filmed=take.filmed[LAST], state=take.state[LAST]
    )  # fmt: skip
    folder = tmp_path_factory.mktemp("beside_another_tracker")
    return note.main(folder), folder


def test_the_silhouettes_leave_one_reading_of_the_quaternions(notes):
    take = notes["conventions_of_another_tracker"].read_take()
    best, *others = notes["conventions_of_another_tracker"].reading_rows(take)
    assert (best.reading.first, best.reading.scalar, best.reading.relative, best.reading.inverse) == (
        "left", "last", "body", False,
    )  # fmt: skip
    assert all(row.overlap.mean() < best.overlap.mean() - 0.2 for row in others)


def test_every_frame_is_tracked_or_said_not_to_be(results):
    found, _ = results
    status, reasons = found.ours.track.status, found.ours.track.reasons
    assert len(status) == len(found.take.masks)
    assert all(word == "tracked" or reason for word, reason in zip(status, reasons, strict=True))


def test_our_fly_looks_more_like_the_silhouettes_than_the_other_one_in_every_view(results):
    found, _ = results
    assert np.all(np.median(found.our_overlap, axis=0) > np.median(found.other_overlap, axis=0))
    assert found.check.residual < 1.5  # px


def test_where_the_bodies_or_wings_are_far_apart_it_is_seldom_ours_that_the_silhouettes_deny(notes, results):
    found, _ = results
    for part, least in (("body", 6 * deg), ("left wing", 8 * deg), ("right wing", 8 * deg)):
        said = notes["beside_another_tracker"].counts(found, part, least)
        assert said["ours is wrong"] <= said["the other tracker is wrong"]


def test_exchanging_a_part_with_itself_changes_nothing(notes, results):
    found, _ = results
    alike = notes["beside_another_tracker"].trial(found.take, found.ours, found.ours.flies, found.ours.drawing)
    assert not alike.in_our_drawing.any()
    assert not alike.in_other_drawing.any()


def test_a_wing_is_placed_by_the_centre_and_the_long_axis_of_its_outline(notes):
    """A rectangle from a corner, 4 by 1, turned by 30 deg."""
    flies = notes["_drawn_flies"]
    turn = flies.in_plane(30 * deg)
    drawing = flies.drawing_of(
        np.array([[-1.0, 0.0], [0.0, 1.0], [1.0, 0.0]]), 1.0, np.array([[0, 0], [4, 0], [4, 1], [0, 1]]) @ turn.T
    )
    np.testing.assert_allclose(drawing.centre, turn @ [2, 0.5], atol=1e-12)
    assert drawing.tilt == pytest.approx(30 * deg)
    np.testing.assert_allclose(np.ptp(drawing.wing, axis=0), [4, 1], atol=1e-12)


def test_an_even_turn_keeps_to_the_middle_and_a_kink_is_off_it_whatever_the_axes_signs(notes):
    angle = np.array([0.0, 10.0, 20.0, 35.0, 40.0]) * deg
    axes = np.stack([np.cos(angle), np.sin(angle), np.zeros(5)], axis=1) * [[1], [-1], [1], [1], [-1]]
    off = notes["beside_another_tracker"].off_the_middle(axes)
    np.testing.assert_allclose(off, [0, 2.5 * deg, 5 * deg], atol=1e-12)


def test_the_note_its_figures_and_its_claims_are_written(results):
    _, folder = results
    assert sorted(path.name.removeprefix("beside_another_tracker") for path in folder.iterdir()) == [
        ".json", ".md", ".svg", "_worst.svg",
    ]  # fmt: skip
    assert sum(path.stat().st_size for path in folder.iterdir()) < 400_000
    assert len(read_claims(folder / "beside_another_tracker.json")) == 2
    assert "readings" in json.loads((folder / "beside_another_tracker.json").read_text(encoding="utf-8"))
