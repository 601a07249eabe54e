"""The claims of the lab note on recovery with beating wings, on what it finds."""

import json

import numpy as np
import pytest
from lab_note import lab_note

from flycontrol.units import deg, ms

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def results(real_data, tmp_path_factory):
    """The lab note as a module, its findings, and the folder that it wrote."""
    note = lab_note("recovery_at_two_levels")
    note.DATA = real_data
    folder = tmp_path_factory.mktemp("recovery_at_two_levels")
    return note, note.main(folder), folder


def test_paddling_agrees_within_a_hundredth_and_springs_within_a_tenth_at_every_phase(results):
    """A hundredth with the built-in stroke; the measured hover misses it by a fifth of that, and its row says so."""
    note, found, _ = results
    assert found.worst(found.paddling) < 0.01
    assert found.worst(found.paddling_hover) < 0.015
    assert found.worst(found.hinge.level) < 0.1
    for level, claim in zip((found.paddling, found.paddling_hover), note.loop_claims(found), strict=False):
        assert claim.agreement == ("agrees" if found.worst(level) < 0.01 else "roughly")


def test_the_loop_of_wings_that_do_not_give_way_fails_on_springs(results):
    _, found, _ = results
    assert found.rigid.misfit > 0.1
    assert found.hinge.level.plant.damping < 0.8 * found.hinge.rigid.damping


def test_paddling_seen_on_springs_is_what_was_asked_for_and_what_the_turn_adds(results):
    """What is left goes with the angular acceleration of the pulse, in the wingbeats that it reaches."""
    _, found, _ = results
    assert found.seen.off > 0.5
    assert found.seen.off_with_turning < found.seen.off / 4


def test_recovery_times_of_both_levels_agree_and_grow_with_the_peak(results):
    """But for the strongest pulse on springs: there 60 ms are the edge at which the second swing leaves the band."""
    _, found, _ = results
    for level in found.levels:
        times, reduced = found.times[level.name], found.reduced_times[level.name]
        on_edge = level is found.hinge.level
        np.testing.assert_allclose(times[: -1 if on_edge else None], reduced[: -1 if on_edge else None], atol=2 * ms)
        assert np.all(np.diff(times) > 0)
        if on_edge:
            assert level.chosen.nearby > times[-1]  # so does the reduced loop with gains 1 % off


def test_without_the_second_swing_recovery_grows_ever_more_slowly(results):
    note, found, _ = results
    for level in (found.paddling, found.paddling_hover):
        slopes = np.diff(found.times[level.name]) / np.diff(note.PEAKS)
        assert slopes[0] > 20 * slopes[-1]


def test_sampling_and_filters_act_as_the_delay_that_is_their_mean_lag(results):
    _, found, _ = results
    assert all(row.delayed < 0.015 for row in found.sensing)
    assert found.sensing[2].misfit > 0.1  # once a wingbeat, unaccounted for


def test_shorter_pulses_meet_the_wings_at_a_phase_and_longer_ones_at_all(results):
    _, found, _ = results
    for rows in found.durations.values():
        misfits = [row.misfit for row in rows]
        assert misfits == sorted(misfits, reverse=True)
        assert misfits[0] > 3 * misfits[3]


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
    assert all(claim.where.startswith("section") for claim in note.claims(found))
    assert not any(claim.agreement == "agrees" for claim in note.paddling_claims(found))
    assert "(../../analyses/recovery_at_two_levels.py)" in text
    assert numbers["levels"]["paddling"]["damping_rate_per_s"] == pytest.approx(
        found.paddling.plant.damping_rate, rel=1e-5
    )
    assert (folder / "recovery_at_two_levels.svg").read_text().startswith("<?xml")
