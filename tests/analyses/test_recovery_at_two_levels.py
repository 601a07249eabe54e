"""The claims of the lab note on recovery with beating wings, on what it finds."""

import json

import numpy as np
import pytest
from lab_note import lab_note

from flycontrol.units import deg, ms

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    """The lab note as a module, its findings, and the folder that it wrote."""
    note = lab_note("recovery_at_two_levels")
    folder = tmp_path_factory.mktemp("recovery_at_two_levels")
    return note, note.main(folder), folder


def test_paddling_agrees_within_a_hundredth_and_springs_within_a_tenth_at_every_phase(results):
    _, found, _ = results
    assert found.worst("paddling") < 0.01
    assert found.worst("hinge bias") < 0.1


def test_the_loop_of_wings_that_do_not_give_way_fails_on_springs(results):
    _, found, _ = results
    assert found.rigid.misfit > 0.1
    assert found.hinge.level.plant.damping < 0.8 * found.hinge.rigid.damping


def test_recovery_times_of_both_levels_agree_and_grow_with_the_peak_ever_more_slowly(results):
    note, found, _ = results
    for name, times in found.times.items():
        np.testing.assert_allclose(times, found.reduced_times[name], rtol=0, atol=2 * ms)
        slopes = np.diff(times) / np.diff(note.PEAKS)
        assert np.all(slopes > 0)
        assert slopes[0] > 20 * slopes[-1]


def test_sampling_and_filters_act_as_the_delay_that_is_their_mean_lag(results):
    _, found, _ = results
    assert all(row.delayed < 0.015 for row in found.sensing)
    assert found.sensing[2].misfit > 0.1  # once a wingbeat, unaccounted for


def test_shorter_pulses_meet_the_wings_at_a_phase_and_longer_ones_at_all(results):
    _, found, _ = results
    misfits = [row.misfit for row in found.durations]
    assert misfits[0] > 3 * misfits[3]
    assert misfits[4] < 0.01


def test_yaw_control_alone_keeps_the_heading_unless_the_body_may_roll(results):
    _, found, _ = results
    alone, without_roll, free = found.freedoms
    assert abs(alone.yaw_later) < 0.1 * deg
    assert abs(without_roll.yaw_later) < 0.1 * deg
    assert abs(free.roll_later) > 5 * deg


def test_the_note_and_the_numbers_state_the_claims(results):
    note, found, folder = results
    text = (folder / "recovery_at_two_levels.md").read_text()
    numbers = json.loads((folder / "recovery_at_two_levels.json").read_text())
    assert all(f"| {claim.claim} |" in text for claim in note.claims(found))
    assert numbers["levels"]["paddling"]["damping_rate_per_s"] == pytest.approx(
        found.paddling.plant.damping_rate, rel=1e-5
    )
    assert (folder / "recovery_at_two_levels.svg").read_text().startswith("<?xml")
