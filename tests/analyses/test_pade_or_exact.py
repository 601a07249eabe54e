import json
from math import factorial

import numpy as np
import pytest
from lab_note import lab_note

from flycontrol.delay import margins
from flycontrol.model.gains import largest_stable_delay
from flycontrol.units import ms

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def note():
    return lab_note("pade_or_exact")


@pytest.fixture(scope="module")
def results(note, tmp_path_factory):
    folder = tmp_path_factory.mktemp("pade_or_exact")
    return note.main(folder), folder


@pytest.fixture(scope="module")
def loops(note):
    return {loop.name: loop for loop in [note.fly_loop(note.read_parameters()), *note.textbook_loops()]}


def test_the_exact_values_are_the_closed_forms(results, loops, note):
    exact = {name: wrongs[0] for name, wrongs in results[0].loops.items()}
    assert exact["integrator"].largest_delay == pytest.approx(np.pi / 2 / 0.7, rel=1e-10)
    assert exact["integrator"].gain_margin == pytest.approx(np.pi / 2 / 0.7, rel=1e-10)
    kp, kd, _ = loops["fly"].truth
    b = note.read_parameters().damping_rate
    assert exact["fly"].largest_delay == pytest.approx(largest_stable_delay(b, kp, kd), rel=1e-9)


def test_pade_overstates_margins_at_every_order_and_less_at_higher_ones(results):
    for wrongs in results[0].loops.values():
        for error in ("gain_margin", "largest_delay", "delay_margin"):
            found = np.array([getattr(w, error) for w in wrongs[1:]])
            resolved = found[np.abs(found) > 1e-10]  # beyond, rounding decides
            assert len(resolved) >= 4
            assert (resolved > 0).all()
            assert (np.diff(resolved) < 0).all()


def test_the_error_of_an_integrators_margin_is_that_of_the_approximants_phase(results):
    """L = k R / s crosses at phase(R(jw)) = -pi/2: to first order w moves by the phase error, at w T = pi/2."""
    wrongs = results[0].loops["integrator"]
    for w in wrongs[3:6]:  # small errors, so that first order holds
        n = w.order
        # the leading term of the phase error; the next is smaller by (wT)^2 / (4 (2n + 3)) or less
        phase = (np.pi / 2) ** (2 * n + 1) * factorial(n) ** 2 / (factorial(2 * n) * factorial(2 * n + 1))
        assert w.gain_margin == pytest.approx(phase / (np.pi / 2), rel=0.15)


def test_order_1_sees_a_critical_kd_a_third_too_high(results):
    exact, first, *_ = results[0].fly
    assert first.critical_kd / exact.critical_kd == pytest.approx(1.33, abs=0.005)


def test_a_fit_with_order_1_finds_a_delay_1_4_ms_too_long_and_the_exact_fit_the_delay_itself(results, loops):
    exact, first, *_ = results[0].fly
    T = loops["fly"].delay
    assert exact.delay == pytest.approx(T, rel=1e-7)
    assert first.delay - T == pytest.approx(1.4 * ms, abs=0.05 * ms)
    assert exact.noisy_delay == pytest.approx(T, abs=3 * exact.noisy_spread / 4)  # the mean of sixteen recordings
    assert first.noisy_delay - T > 4 * first.noisy_spread


def test_order_4_is_enough_for_margins_and_fits_of_all_four_loops(results):
    for wrongs in results[0].loops.values():
        fourth = wrongs[4]
        assert max(fourth.gain_margin, fourth.largest_delay, fourth.delay_margin, fourth.pole) < 4e-6
        assert abs(fourth.fit["T"]) < 1.1e-4
    exact, *_, fourth = results[0].fly
    assert fourth.recovery == pytest.approx(exact.recovery, abs=0.01 * ms)


def test_responses_converge_slower_than_margins(results):
    for wrongs in results[0].loops.values():
        responses = np.array([w.response for w in wrongs[1:]])
        assert (np.diff(responses) < 0).all()
        assert all(w.response > 100 * w.gain_margin for w in wrongs[4:])


def test_the_companion_form_loses_the_response_at_order_12_and_the_ladder_does_not(results):
    forms = {form.order: form for form in results[0].forms}
    assert forms[4].companion == pytest.approx(forms[4].ladder, rel=1e-3)
    for order in (12, 16):
        assert not forms[order].companion < 0.1
        assert forms[order].ladder < forms[8].ladder < 1e-4


def test_the_words_around_the_notes_numbers_hold(results, loops):
    found, folder = results
    page = (folder / "pade_or_exact.md").read_text(encoding="utf-8")
    assert page.splitlines()[0].endswith("which order is enough?")
    assert 0 < page.index("## Method\n") < page.index("## Answer\n") < page.index("![")
    T = loops["fly"].delay
    assert f"for the fly by {(found.fly[1].delay - T) / ms:.2f} ms of {T / ms:.2f} ms" in page
    lags = [margins(loop.plant(*loop.truth)).phase_crossovers * loop.delay for loop in loops.values()]
    assert max(lag[lag > 0][0] for lag in lags) < 1.7


@pytest.mark.parametrize(("name", "power"), [("integrator", 2), ("process", 2), ("fly", 3), ("stick", 3)])
def test_errors_of_responses_fall_as_the_power_of_the_order_that_the_corners_spectrum_gives(results, note, name, power):
    """What [n/n] misses lies beyond w T ~ 2 n, where the corner's spectrum falls as w^-(power + 1)."""
    errors = results[0].doubling[name]
    assert (np.diff(errors) < 0).all()
    slope = np.log(errors[0] / errors[-1]) / np.log(note.DOUBLING[-1] / note.DOUBLING[0])
    # interfering corners move an error by a factor of 2 or so, over three doublings 1/3 in the slope
    assert slope == pytest.approx(power, abs=0.4)


def test_the_files_are_small_and_the_same_every_time(results, note, loops):
    found, folder = results
    assert sum(path.stat().st_size for path in folder.iterdir()) < 300_000
    assert sorted(path.suffix for path in folder.iterdir()) == [".json", ".md", ".svg"]
    numbers = json.loads((folder / "pade_or_exact.json").read_text(encoding="utf-8"))
    assert numbers["seed"] == note.SEED
    assert note.draw(list(loops.values()), found.loops) == (folder / "pade_or_exact.svg").read_bytes()
    assert note.as_numbers(found.loops, found.fly) == (folder / "pade_or_exact.json").read_text(encoding="utf-8")
