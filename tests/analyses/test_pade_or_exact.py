import importlib.util
import json
import sys
from math import factorial
from pathlib import Path

import numpy as np
import pytest

from flycontrol.delay import margins
from flycontrol.model.gains import largest_stable_delay
from flycontrol.units import ms

ANALYSES = Path(__file__).resolve().parents[2] / "analyses"

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def note():
    spec = importlib.util.spec_from_file_location("pade_or_exact", ANALYSES / "pade_or_exact.py")
    module = importlib.util.module_from_spec(spec)
    sys.modules["pade_or_exact"] = module  # where dataclasses look their annotations up
    spec.loader.exec_module(module)
    yield module
    del sys.modules["pade_or_exact"]


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


def test_the_note_states_the_numbers_that_it_finds(results, loops):
    found = results[0]
    text = " ".join((ANALYSES / "pade_or_exact.py").read_text(encoding="utf-8").replace("\n#", " ").split())
    first, second, third, fourth = ([wrongs[n] for wrongs in found.loops.values()] for n in (1, 2, 3, 4))

    def span(values):
        return f"{100 * min(values):.0f} to {100 * max(values):.0f} %"

    assert f"the gain margin by {span([w.gain_margin for w in first])}" in text
    assert f"the delay margin by {span([w.delay_margin for w in first])}" in text
    assert f"the rightmost pole by {span([w.pole for w in first])}" in text
    assert f"a delay too long by {span([w.fit['T'] for w in first])}" in text
    assert f"by {(found.fly[1].delay - loops['fly'].delay) / ms:.2f} ms of {loops['fly'].delay / ms:.2f} ms" in text
    assert f"up to {100 * max(w.delay_margin for w in second):.1f} % in margins" in text
    assert f"{100 * max(w.fit['T'] for w in second):.1f} % in fitted delays" in text
    assert max(max(w.delay_margin, w.fit["T"]) for w in third) < 4e-4
    assert max(w.delay_margin for w in fourth) < 4e-6
    fly, integrator = found.loops["fly"], found.loops["integrator"]
    assert f"{100 * fly[4].response:.2f} % at order 4 and {100 * fly[8].response:.3f} % at order 8" in text
    assert f"{100 * integrator[4].response:.1f} % and {100 * integrator[8].response:.2f} %" in text
    lags = [margins(loop.plant(*loop.truth)).phase_crossovers * loop.delay for loop in loops.values()]
    assert max(lag[lag > 0][0] for lag in lags) < 1.7


def test_the_files_are_small_and_the_same_every_time(results, note, loops):
    found, folder = results
    assert sum(path.stat().st_size for path in folder.iterdir()) < 300_000
    assert sorted(path.suffix for path in folder.iterdir()) == [".json", ".md", ".svg"]
    numbers = json.loads((folder / "pade_or_exact.json").read_text(encoding="utf-8"))
    assert numbers["seed"] == note.SEED
    assert note.draw(list(loops.values()), found.loops) == (folder / "pade_or_exact.svg").read_bytes()
    assert note.as_numbers(found.loops, found.fly) == (folder / "pade_or_exact.json").read_text(encoding="utf-8")
