import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flycontrol.errors import InvalidParameterError
from flycontrol.model.chain import yaw_chain
from flycontrol.model.yaw import YawLoop

LOOP = YawLoop.from_rates(b=69.0, kp=3050.0, kd=45.0, delay=3 / 220, inertia=3.06e-13)
repeatable = settings(derandomize=True, deadline=None, max_examples=40)


@repeatable
@given(st.floats(1e-11, 1e-7), st.floats(0.1, 2.0), st.floats(0.1, 2000.0), st.floats(-200.0, 200.0))
def test_the_product_of_the_chain_is_the_open_loop_whatever_gamma_and_mu(gamma, mu, omega, sigma):
    s = complex(sigma, omega)
    assert yaw_chain(LOOP, gamma, mu)(s) == pytest.approx(LOOP.open_loop()(s)[0, 0], rel=1e-11)


@repeatable
@given(st.floats(0.1, 2000.0))
def test_the_phase_budget_adds_up_to_the_phase_of_the_loop(omega):
    budget = yaw_chain(LOOP, 1e-9, 0.6).phase_budget(omega)
    L = LOOP.open_loop()(1j * omega)[0, 0]
    assert np.exp(1j * sum(budget.values())) == pytest.approx(L / abs(L), abs=1e-11)
    by_hand = np.arctan2(45.0 * omega, 3050.0) - omega * LOOP.delay - np.pi / 2 - np.arctan2(omega, 69.0)
    assert sum(budget.values()) == pytest.approx(by_hand, abs=1e-9)


def test_at_the_crossover_the_phase_margin_is_what_the_budget_leaves_of_180_deg():
    found = LOOP.margins()
    spent = sum(yaw_chain(LOOP, 1e-9, 0.6).phase_budget(float(found.gain_crossovers[0])).values())
    assert np.pi + spent == pytest.approx(found.phase_margin, rel=1e-10)


def test_the_links_hand_each_other_the_same_signal_around_the_loop():
    links = yaw_chain(LOOP, 1e-9, 0.6).links
    for link, after in zip(links, [*links[1:], links[0]], strict=True):
        assert link.gives == after.reads


def test_pd_on_the_angle_is_pi_on_the_rate():
    halteres, neural, *_ = yaw_chain(LOOP, 1e-9, 0.6).links
    s = 3 + 40j
    angle = (LOOP.controller.proportional + LOOP.controller.derivative * s) * np.exp(-s * LOOP.delay)
    assert halteres(s) * neural(s) == pytest.approx(angle / (1e-9 * 0.6), rel=1e-12)


@pytest.mark.parametrize(("gamma", "mu"), [(0.0, 0.6), (-1e-9, 0.6), (1e-9, 0.0), (np.nan, 0.6)])
def test_a_chain_that_cannot_push_is_refused(gamma, mu):
    with pytest.raises(InvalidParameterError, match="gamma > 0 N m/rad and mu > 0"):
        yaw_chain(LOOP, gamma, mu)
