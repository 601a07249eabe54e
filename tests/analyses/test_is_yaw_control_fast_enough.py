"""The note's numbers hang together, and its words say what they show."""

import json

import numpy as np
import pytest
from lab_note import lab_note

from flycontrol.io.parameters import read_parameters
from flycontrol.report.nominal import yaw_loop


@pytest.fixture(scope="module")
def note():
    """The lab note as a module."""
    return lab_note("is_yaw_control_fast_enough")


def test_the_links_spend_the_whole_delay_and_their_phases_leave_the_phase_margin(note):
    fly = read_parameters()
    parts, loop = note.shares(fly), yaw_loop(fly)
    assert sum(part.delay for part in parts) == pytest.approx(loop.delay, rel=1e-12)
    assert np.pi - sum(part.phase for part in parts) == pytest.approx(loop.margins().phase_margin, rel=1e-9)


@pytest.mark.slow
def test_the_answer_is_what_the_numbers_say(note, tmp_path):
    note.main(tmp_path)
    found = json.loads((tmp_path / "is_yaw_control_fast_enough.json").read_text())
    longest = {each["damping"]: each["longest"] for each in found["lateness"]}
    own = read_parameters().delay.value
    assert longest[34.5] < own < longest[69.0] < longest[176.0]
    assert longest[69.0] - own == pytest.approx(1 / 220, rel=0.05)  # one wingbeat to spare
    best = np.array([each["best"] for each in found["lateness"]])
    assert np.all(np.diff(best, axis=1) > 0)  # later is slower
    assert np.all(np.diff(best, axis=0) < 0)  # damping helps
    assert all(claim["agreement"].startswith("agrees") for claim in found["claims"][:2])
