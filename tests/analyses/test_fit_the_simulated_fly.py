"""The claims of the lab note that fits recordings of beating wings, on what it finds."""

import json

import numpy as np
import pytest
import scipy.stats
from lab_note import lab_note

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    """The lab note as a module, its findings, and the folder that it wrote."""
    note = lab_note("fit_the_simulated_fly")
    folder = tmp_path_factory.mktemp("fit_the_simulated_fly")
    return note, note.main(folder), folder


def test_without_noise_the_fit_of_a_paddling_fly_misses_by_a_hundredth_at_most(results):
    _, found, _ = results
    assert np.abs(found.exact[0].off).max() < 0.01


def test_a_fly_on_springs_is_found_with_the_damping_of_wings_that_give_way(results):
    _, found, _ = results
    springs = found.exact[1]
    assert np.abs(springs.off[:4]).max() < 0.02
    assert springs.fit["damping"].value < 0.8 * found.rigid_damping


def test_intervals_hold_the_truth_where_pulses_are_small(results):
    """Fewer happen by chance with true 95 % intervals in one case of five hundred."""
    note, found, _ = results
    fewest = scipy.stats.binom.ppf(0.002, note.DRAWS, 0.95) / note.DRAWS
    assert np.all(found.strengths[0].inside >= fewest)


def test_and_do_not_where_the_models_error_is_several_standard_errors(results):
    note, found, _ = results
    k = note.NAMES.index("kp")
    assert found.strengths[-1].peak > 2 * found.crossing[k]
    assert found.strengths[-1].inside[k] < 0.5


def test_standard_errors_go_as_the_inverse_of_the_strength(results):
    """To about a tenth: paddling's noise and curvature add to it where pulses are weak, chance everywhere."""
    _, found, _ = results
    for weak, strong in zip(found.strengths[1:], found.strengths[2:], strict=False):
        np.testing.assert_allclose(weak.standard_error / strong.standard_error, 2.0, rtol=0.15)


def test_every_fit_to_files_is_usable(results):
    _, found, _ = results
    assert all(one.example.usable for one in found.strengths)


def test_the_note_and_the_numbers_state_what_was_found(results):
    _, found, folder = results
    text = (folder / "fit_the_simulated_fly.md").read_text()
    numbers = json.loads((folder / "fit_the_simulated_fly.json").read_text())
    estimate = numbers["without_noise"]["paddling"]["kp"]["estimate"]
    assert estimate == pytest.approx(found.exact[0].fit["kp"].value, rel=1e-5)
    assert f"{found.crossing[0]:.0f} deg" in text
    assert (folder / "fit_the_simulated_fly.svg").read_text().startswith("<?xml")
