from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from flycontrol.errors import InvalidInputError
from flycontrol.identify import yaw_plant
from flycontrol.identify.bootstrap import block_bootstrap
from flycontrol.identify.yaw_plant import YawHistory, explained, fit_yaw_plant

B, G, C = 69.0, 2e4, 50.0
PERIOD = 1 / 185.0


def flight(
    seed: int, n: int = 60, noise: float = 300.0, rho: float = 0.6, feedback: float = 0.0, b: float = B
) -> YawHistory:
    """Eq. 3 driven by wandering paddling, by torque that nobody told, and by feedback of the yaw rate to the wings."""
    rng = np.random.default_rng(seed)
    durations = PERIOD * (1 + 0.05 * rng.standard_normal(n))
    wander, unknown, rate, d_alpha = 0.0, noise * rng.standard_normal(), [0.0], []
    for duration in durations:
        wander = 0.8 * wander + 0.6 * np.radians(1.5) * rng.standard_normal()
        d_alpha.append(wander - feedback * rate[-1])
        decay = np.exp(-b * duration)
        rate.append(decay * rate[-1] + (1 - decay) / b * (G * d_alpha[-1] + C + unknown))
        unknown = rho * unknown + noise * np.sqrt(1 - rho**2) * rng.standard_normal()
    return YawHistory(yaw_rate=np.array(rate), d_alpha=np.array(d_alpha), durations=durations, coupling=np.zeros(n))


def test_without_noise_the_plant_comes_back():
    # the grid over b is what limits it; a trace of noise keeps the likelihood finite
    fit = fit_yaw_plant(flight(1, noise=1.0))
    assert fit.damping.value == pytest.approx(B, rel=2e-3)
    assert fit.paddling.value == pytest.approx(G, rel=2e-3)
    assert fit.turn_gain is not None
    assert fit.turn_gain.value == pytest.approx(G / B, rel=2e-3)
    assert fit.intercept == pytest.approx(C, abs=2.0)
    assert fit.r2_acceleration > 0.9999
    assert fit.r2_simulated > 0.9999


@pytest.mark.slow
@pytest.mark.parametrize(
    "case",
    [
        {},
        {"n": 30, "noise": 1000.0, "rho": 0.5},
        {"feedback": 1e-3},
    ],
    ids=["long", "short, noise four times the signal", "yaw feeds back to the wings"],
)
def test_95_percent_intervals_cover_the_truth_at_95_percent(case):
    seeds = 400
    fits = [fit_yaw_plant(flight(seed, **case)) for seed in range(seeds)]
    damping = np.mean([f.damping.low <= B <= f.damping.high for f in fits])
    paddling = np.mean([f.paddling.low <= G <= f.paddling.high for f in fits])
    # three standard errors of a binomial at 0.95; the prior on b makes short, noisy records cover more
    binomial = 3 * np.sqrt(0.95 * 0.05 / seeds)
    assert damping > 0.95 - binomial
    assert abs(paddling - 0.95) < binomial


def test_feedback_from_yaw_to_the_wings_does_not_bias_the_estimates():
    fits = [fit_yaw_plant(flight(seed, feedback=1e-3, noise=600.0, n=120)) for seed in range(12)]
    paddling = np.array([f.paddling.value for f in fits])
    assert abs(paddling.mean() - G) < 3 * paddling.std(ddof=1) / np.sqrt(len(fits))


def test_a_known_coupling_is_taken_out():
    history = flight(3, noise=1.0)
    u = 500.0 * np.sin(np.arange(60))
    rate = [0.0]
    for k in range(60):
        decay = np.exp(-B * history.durations[k])
        rate.append(decay * rate[-1] + (1 - decay) / B * (G * history.d_alpha[k] + C - u[k]))
    fit = fit_yaw_plant(replace(history, yaw_rate=np.array(rate), coupling=u))
    assert fit.damping.value == pytest.approx(B, rel=2e-3)
    assert fit.paddling.value == pytest.approx(G, rel=2e-3)


@given(st.floats(0.1, 10.0))
def test_scaling_yaw_scales_paddling_and_leaves_damping(factor):
    history = flight(2)
    one, other = fit_yaw_plant(history), fit_yaw_plant(replace(history, yaw_rate=factor * history.yaw_rate))
    assert other.damping.value == pytest.approx(one.damping.value, rel=1e-6)
    assert other.paddling.value == pytest.approx(factor * one.paddling.value, rel=1e-6)


@pytest.mark.parametrize("seed", range(4))
def test_a_finer_grid_moves_no_interval_by_more_than_one_percent_of_its_width(seed, monkeypatch):
    history = flight(seed, n=30, noise=600.0)
    here = fit_yaw_plant(history)
    monkeypatch.setattr(yaw_plant, "FINE", (240, 80))
    finer = fit_yaw_plant(history)
    for one, other in ((here.damping, finer.damping), (here.paddling, finer.paddling)):
        width = other.high - other.low
        assert abs(one.low - other.low) < 0.01 * width
        assert abs(one.high - other.high) < 0.01 * width
        assert abs(one.value - other.value) < 0.01 * width


def test_where_damping_may_be_zero_the_turn_gain_has_no_interval():
    fit = fit_yaw_plant(flight(1, n=20, noise=3000.0, rho=0.95))
    assert fit.damping.low < 0
    assert fit.turn_gain is None


def test_turning_d_alphas_sign_turns_the_paddlings_sign():
    history = flight(2)
    one, other = fit_yaw_plant(history), fit_yaw_plant(replace(history, d_alpha=-history.d_alpha))
    assert other.paddling.value == pytest.approx(-one.paddling.value, rel=1e-6)
    assert other.paddling.low == pytest.approx(-one.paddling.high, rel=1e-6)


def test_the_block_bootstrap_agrees_with_the_posterior_to_a_factor_of_two_in_width():
    history = flight(4)
    fit = fit_yaw_plant(history)
    check = block_bootstrap(history, fit)
    for posterior, resampled in ((fit.damping, check.damping), (fit.paddling, check.paddling)):
        assert 0.5 < (resampled.high - resampled.low) / (posterior.high - posterior.low) < 2.0
    assert check == block_bootstrap(history, fit)


def test_the_mean_explains_nothing_and_a_worse_guess_less():
    measured = np.array([1.0, 2.0, 3.0])
    assert explained(measured, np.full(3, 2.0)) == 0.0
    assert explained(measured, measured) == 1.0
    assert explained(measured, np.zeros(3)) < 0


def test_too_few_wingbeats_and_unequal_lengths_are_refused():
    with pytest.raises(InvalidInputError, match="5 wingbeats are too few"):
        flight(0, n=5)
    with pytest.raises(InvalidInputError, match="n \\+ 1 reversals"):
        YawHistory(yaw_rate=np.zeros(9), d_alpha=np.zeros(9), durations=np.ones(9), coupling=np.zeros(9))


def test_without_any_paddling_damping_comes_back_and_gamma_is_not_told():
    paddled = flight(1, noise=300.0, rho=0.0)
    decay = np.exp(-B * paddled.durations)
    rng = np.random.default_rng(4)
    rate = [20.0]
    for part, duration in zip(decay, paddled.durations, strict=True):
        rate.append(part * rate[-1] + 1e-3 * duration * rng.standard_normal())
    fit = fit_yaw_plant(replace(paddled, yaw_rate=np.array(rate), d_alpha=np.zeros_like(paddled.d_alpha)))
    assert fit.paddling is None
    assert fit.turn_gain is None
    assert fit.damping.value == pytest.approx(B, rel=2e-3)  # the grid over b is what limits it
    assert fit.r2_acceleration > 0.9999
