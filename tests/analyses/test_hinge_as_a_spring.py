"""The claims of the lab note on the wing's hinge, on what it finds."""

import json
from pathlib import Path

import numpy as np
import pytest
from lab_note import lab_note

from flycontrol.units import deg

ANALYSES = Path(__file__).resolve().parents[2] / "analyses"

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
    assert set(words) == {"agrees", "roughly", "fails"}
    hover = found.at_chosen(found.flies[0]).transmission
    assert words[4] == ("agrees" if 0.54 < hover.mu < 0.66 else "roughly" if 0.45 < hover.mu < 0.75 else "fails")
    for claim in numbers["claims"]:
        assert claim["ours"] in (folder / "hinge_as_a_spring.md").read_text(encoding="utf-8")


def test_the_note_states_the_numbers_that_it_finds(results):
    found, folder = results
    text = " ".join((ANALYSES / "hinge_as_a_spring.py").read_text(encoding="utf-8").replace("\n#", " ").split())
    hover, free = (found.at_chosen(fly) for fly in found.flies)
    names = [fly.name for fly in found.flies]
    axes = found.profiles[names[0]]
    work = [-1e9 * one.loop.work for one in (hover, free)]
    share = [100 * w / (1e9 * found.stroke_work[name]) for w, name in zip(work, names, strict=True)]
    torques = found.torques[names[0]]
    air = {term: 1e9 * torques.work(of) for term, of in torques.air.items()}
    swing = [np.ptp(found.torques[name].pitch) / deg for name in names]
    mass = {v.name: v.found for v in found.variations}
    bulk = [f.fly.morphology.weight * f.fly.morphology.mean_chord for f in found.flies]
    turns = [f.slopes for f in found.flights]
    assert f"for an axis at {found.pitch_axis:g} chords" in text
    assert f"takes {work[0]:.1f} nJ" in text
    assert f"and {work[1]:.1f} nJ from" in text
    assert f"{share[0]:.0f} % and {share[1]:.0f} % of" in text
    assert f"delivers {-1e9 * torques.work(torques.inertia):.1f} nJ" in text
    taken = -(air["translational"] + air["rotational"] + air["dissipative"])
    assert f"gives {air['added_mass']:.1f} by added mass and takes {taken:.1f} by" in text
    assert mass["half the wing mass"].loop.work == pytest.approx(hover.loop.work / 2, rel=0.05)
    assert f"explains {hover.loop.explained:.2f} (hover) and {free.loop.explained:.2f} of" in text
    assert f"a spring alone {hover.loop.explained_by_line:.2f} and {free.loop.explained_by_line:.2f}" in text
    assert f"{hover.fit.rms / deg:.1f} and {free.fit.rms / deg:.1f} deg rms of" in text
    assert f"measured {swing[0]:.0f} and {swing[1]:.0f} deg" in text
    kappa = [1e9 * one.fit.spring.stiffness for one in axes]
    assert f"{kappa[1]:.1f} nN m/rad for" in text
    assert f"it would be {kappa[4]:.2f}" in text
    assert f"from {axes[0].fit.rms / deg:.1f} to {axes[4].fit.rms / deg:.1f} deg" in text
    assert f"kappa is sharp, {100 * hover.fit.relative_spread[0]:.0f} % for" in text
    assert f"falls {kappa[0] / kappa[4]:.1f}-fold" in text
    assert f"{bulk[1] / bulk[0]:.1f} times the weight times chord, has {1e9 * free.fit.spring.stiffness:.1f}" in text
    assert f"shrinks to {mass['mass half as far from the axis'].fit.rms / deg:.1f} deg" in text
    first, second = hover.transmission, free.transmission
    assert f"is {first.mu:.2f} in hover and {second.mu:.2f} for" in text
    assert f"over time {first.mu_plain:.2f} and {second.mu_plain:.2f}" in text
    assert f"in yaw torque {first.mu_torque:.2f} and {second.mu_torque:.2f}" in text
    quarter = [found.profiles[name][5].transmission.mu for name in names]
    assert f"falls to {quarter[0]:.2f} and {quarter[1]:.2f}" in text
    assert [round(f.correlation, 2) for f in found.flights[:2]] == [0.82, 0.82]
    assert f"between {turns[0][0]:.2f} and {turns[0][1]:.2f} in one and {turns[1][0]:.2f} and {turns[1][1]:.2f}" in text
    assert f"is {turns[2][0]:.2f} to {turns[2][1]:.2f}" in text
    assert hover.fit.passive.settling < 0.15
    assert f"beta is {1e12 * first.damping:.1f} pN m s" in text
    assert f"given have {1e12 * first.damping_at_given_pitch:.1f}" in text
    numbers = json.loads((folder / "hinge_as_a_spring.json").read_text(encoding="utf-8"))
    assert numbers["flies"][names[0]][1]["mu"] == pytest.approx(first.mu, rel=1e-5)
    assert (folder / "hinge_as_a_spring.svg").stat().st_size < 300_000
    assert sorted(path.suffix for path in folder.iterdir()) == [".json", ".md", ".svg"]
