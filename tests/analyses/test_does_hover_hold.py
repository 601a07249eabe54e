import json
from pathlib import Path

import numpy as np
import pytest
from lab_note import lab_note

from flycontrol.model.references import cite
from flycontrol.units import deg, ms

ANALYSES = Path(__file__).resolve().parents[2] / "analyses"

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    """The lab note as a module, its findings, and the folder that it wrote."""
    note = lab_note("does_hover_hold")
    folder = tmp_path_factory.mktemp("does_hover_hold")
    return note, note.main(folder), folder


def exponent(modes, name: str) -> complex:
    return next(mode.exponent for mode in modes if mode.name == name)


def test_what_is_flown_is_what_the_exponents_say(results):
    _, found, _ = results
    for grown in (found.roll, found.pitch):
        said = grown.said(np.arange(len(grown.flown)) * grown.period)
        assert np.max(np.abs(grown.flown)) > 3 * deg
        np.testing.assert_allclose(grown.flown, said, atol=0.01 * np.max(np.abs(grown.flown)))


def test_the_note_states_the_numbers_that_it_finds(results):
    note, found, _ = results
    text = " ".join((ANALYSES / "does_hover_hold.py").read_text(encoding="utf-8").replace("\n#", " ").split())
    fly, period = found.fly, found.fly.floquet.period
    roll, pitch = (exponent(fly.floquet.modes, name).real for name in (note.ROLL_MODE, note.PITCH_MODE))
    first, second = (exponent(modes, note.ROLL_MODE).real for modes in (fly.at_rest.modes, fly.along.modes(2)))
    assert f"doubles every {np.log(2) / roll / ms:.1f} ms, {np.log(2) / roll / period:.1f} wingbeats" in text
    assert f"doubles every {np.log(2) / pitch / ms:.1f} ms, {np.log(2) / pitch / period:.1f} wingbeats" in text
    assert f"{first:.1f} where flight says {roll:.1f} 1/s. With the second order it is {second:.1f}" in text
    assert f"grows by {100 * np.expm1(5 * ms * roll):.0f} % and {100 * np.expm1(10 * ms * pitch):.0f} %" in text
    assert {cite("beatus2015").year, cite("whitehead2015").year} == {"2015"}


def test_averaging_at_rest_sees_pitch_and_not_roll(results):
    note, found, _ = results
    exact, first = found.fly.floquet.modes, found.fly.at_rest.modes
    apart = {name: abs(exponent(first, name) / exponent(exact, name) - 1) for name in (note.ROLL_MODE, note.PITCH_MODE)}
    assert apart[note.PITCH_MODE] < 0.005
    assert apart[note.ROLL_MODE] == pytest.approx(0.25, abs=0.03)


def test_published_ranges_and_other_coefficients_change_the_growing_modes_by_a_few_per_cent(results):
    _, found, _ = results
    hovers = {each.case.name: each for each in found.hovers}
    roll, pitch = found.fly.fastest_lateral, found.fly.fastest_longitudinal
    for name, each in hovers.items():
        if name.startswith(("hinge", "stroke plane", "lift and drag")):
            assert abs(each.fastest_lateral / roll - 1) < 0.04
            assert abs(each.fastest_longitudinal / pitch - 1) < 0.04
    assert hovers["no rotational lift"].fastest_lateral.real < 0.5 * roll.real
    assert hovers["translation alone"].fastest_lateral.real < 0.02 * roll.real


def test_with_measured_strokes_hover_is_lost_in_roll_first_too(results, real_data):
    note, found, _ = results
    hovers = {each.case.name: each for each in found.hovers}
    assert (real_data / "kinematics_fourier").is_dir()
    text = " ".join((ANALYSES / "does_hover_hold.py").read_text(encoding="utf-8").replace("\n#", " ").split())
    hover, mean = hovers[note.MEASURED_HOVER], hovers[note.MEASURED_MEAN]
    for each in (hover, mean):
        assert each.fastest_lateral.real > each.fastest_longitudinal.real > 0
        assert abs(each.trim.values["stroke_gain"]) < 0.1
    calibrated = found.fly
    pitch = f"{calibrated.fastest_longitudinal.real:.1f} against {hover.fastest_longitudinal.real:.1f} 1/s"
    roll = f"{calibrated.fastest_lateral.real:.1f} against {hover.fastest_lateral.real:.1f} 1/s"
    damping = [f"{each.at_rest.yaw_damping * 1e12:.1f}e-12" for each in (calibrated, hover)]
    assert f"{damping[0]} N m s with the calibrated stroke, {damping[1]} with the measured hover" in text
    assert pitch in text
    assert roll in text


def test_the_numbers_and_the_figure_are_written_and_small(results):
    note, found, folder = results
    numbers = json.loads((folder / "does_hover_hold.json").read_text(encoding="utf-8"))
    stated = numbers["D. melanogaster"]["exponents_1_per_s"][note.ROLL_MODE][0]
    assert stated == pytest.approx(found.fly.fastest_lateral.real, rel=1e-5)
    assert (folder / "does_hover_hold.svg").stat().st_size < 100_000
    assert sorted(path.suffix for path in folder.iterdir()) == [".json", ".md", ".svg"]
