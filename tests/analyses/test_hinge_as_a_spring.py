"""The claims of the lab note on the wing's hinge, on what it finds."""

import json

import numpy as np
import pytest
from lab_note import lab_note

from flycontrol.units import deg

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def results(real_data, tmp_path_factory):
    """The lab note's findings and the folder that it wrote."""
    note = lab_note("hinge_as_a_spring")
    note.DATA = real_data
    folder = tmp_path_factory.mktemp("hinge_as_a_spring")
    return note.main(folder), folder


def test_the_measured_loops_are_counter_clockwise_at_every_axis_and_whatever_is_changed(results):
    found, _ = results
    every = [one for profile in found.profiles.values() for one in profile] + [v.found for v in found.variations]
    assert all(one.loop.work < 0 for one in every)


def test_the_works_on_a_wings_pitch_add_up_to_what_its_hinge_takes(results):
    found, _ = results
    for torques in found.torques.values():
        given = sum(torques.work(air) for air in torques.air.values()) - torques.work(torques.inertia)
        assert given == pytest.approx(-torques.work(torques.hinge), rel=1e-9)


def test_biases_paddle_in_proportion_and_turn_by_their_sign(results):
    found, _ = results
    mu = found.at_chosen(found.flies[0]).transmission.mu
    for beat in found.biased:
        assert np.sign(beat.torque[2]) == np.sign(round(beat.bias, 12))
        assert beat.d_alpha == pytest.approx(mu * beat.bias, abs=0.01 * 25 * deg)


def test_claims_that_fail_stand_there_too(results):
    found, folder = results
    numbers = json.loads((folder / "hinge_as_a_spring.json").read_text(encoding="utf-8"))
    words = [claim["agreement"].split(":")[0].split(",")[0] for claim in numbers["claims"]]
    assert set(words) == {"agrees", "roughly", "fails", "cannot be told"}
    hover = found.at_chosen(found.flies[0]).transmission
    assert words[4] == ("agrees" if 0.54 < hover.mu < 0.66 else "roughly" if 0.45 < hover.mu < 0.75 else "fails")
    for claim in numbers["claims"]:
        assert claim["ours"] in (folder / "hinge_as_a_spring.md").read_text(encoding="utf-8")


def test_the_hinge_brakes_a_wing_that_its_own_inertia_turns_over(results):
    """The air gives by added mass what it takes otherwise, so that the work goes with the wing's mass."""
    found, _ = results
    hover = found.flies[0].name
    torques = found.torques[hover]
    air = {term: torques.work(of) for term, of in torques.air.items()}
    assert air["added_mass"] > 0
    assert all(air[term] < 0 for term in ("translational", "rotational", "dissipative"))
    assert abs(sum(air.values())) < 0.1 * -torques.work(torques.inertia)
    work = {one.name: one.found.loop.work for one in found.variations}
    assert work["half the wing mass"] == pytest.approx(work["as above"] / 2, rel=0.05)
    for fly in found.flies:
        assert -found.at_chosen(fly).loop.work < 0.25 * found.stroke_work[fly.name]


def test_pitch_settles_on_its_spring_within_a_fraction_of_a_wingbeat(results):
    found, _ = results
    assert found.at_chosen(found.flies[0]).fit.passive.settling < 0.15


def test_wings_on_springs_damp_less_than_wings_that_keep_their_pitch_however_that_is_taken(results):
    found, _ = results
    springs, *given = (one.beta for one in found.dampings)
    assert springs < 0.6 * min(given)
    assert max(given) < 1.15 * min(given)


def test_bias_and_paddling_of_flights_go_together_even_with_torques_of_other_wingbeats(results):
    """Both contain the mean pitch; the row therefore claims nothing."""
    found, _ = results
    (row,) = [claim for claim in lab_note("hinge_as_a_spring").claims(found) if "recorded flights" in claim.claim]
    assert row.agreement.startswith("cannot be told")
    for flight in found.flights:
        by_pitch, _ = flight.correlation_by_pitch
        assert 0.3 < by_pitch < flight.correlation
        low, high = flight.slopes
        assert flight.interval[0] < low < high < flight.interval[1]
        assert f"{low:.2f} to {high:.2f}" in row.ours


def test_with_noise_in_either_angle_mu_lies_between_both_regressions():
    """Paddling mu times a bias, noise on either: the slopes enclose mu."""
    slopes_of = lab_note("hinge_as_a_spring").slopes_of
    rng = np.random.default_rng(0)
    bias = rng.standard_normal(20000)
    for noise in ((0.5, 0.0), (0.0, 0.3), (0.5, 0.3)):
        pair = (one + sd * rng.standard_normal(20000) for one, sd in zip((bias, 0.6 * bias), noise, strict=True))
        low, high = slopes_of(*pair)
        assert low - 0.01 < 0.6 < high + 0.01
        assert high - low > 0.05


def test_the_note_opens_with_its_answer_and_its_numbers(results):
    found, folder = results
    text = (folder / "hinge_as_a_spring.md").read_text(encoding="utf-8")
    hover, free = (found.at_chosen(fly) for fly in found.flies)
    assert text.index("It is a brake") < text.index("| claim |")
    assert f"gives {hover.transmission.mu:.2f} in hover and {free.transmission.mu:.2f} for" in text
    assert all(word in text for word in ("*plain*", "*mid-stroke*", "*torque*", "Beware"))
    assert "(../../analyses/hinge_as_a_spring.py)" in text
    numbers = json.loads((folder / "hinge_as_a_spring.json").read_text(encoding="utf-8"))
    assert numbers["flies"][found.flies[0].name][1]["mu"] == pytest.approx(hover.transmission.mu, rel=1e-5)
    assert (folder / "hinge_as_a_spring.svg").stat().st_size < 300_000
    assert sorted(path.suffix for path in folder.iterdir()) == [".json", ".md", ".svg"]
