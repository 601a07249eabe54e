"""Which controller: P against PD against PI against PID on recordings of known truth."""

import functools

import numpy as np
import pytest
import scipy.signal
import scipy.stats

from flycontrol.errors import InvalidInputError, InvalidParameterError
from flycontrol.identify.gains.blocks import blocks_left_out
from flycontrol.identify.gains.fit import fit_gains
from flycontrol.identify.gains.labour import Labour
from flycontrol.identify.gains.model import gain_model
from flycontrol.identify.gains.response import yaw_response
from flycontrol.identify.gains.selection import Validation, compare_controllers
from flycontrol.jobs.checkpoint import Checkpoint
from flycontrol.model.trial import Pulse, Trial
from flycontrol.units import deg

FLY = {"kp": 3050.0, "kd": 45.0, "delay": 0.0136, "damping": 69.0, "impulse": 35.0}
SLOW_FLY = FLY | {"kp": 1200.0, "kd": 0.0, "damping": 120.0}  # well damped without derivative gain
PULSE = Pulse(onset=0.01, duration=0.0045)
TIMES = np.arange(201) / 2000


def model_of(truth):
    return gain_model(fixed={"initial_yaw": 0.0, "initial_rate": 0.0, "damping": truth["damping"]})


def recorded(seed, truth=FLY, noise=0.3, name="fly"):
    yaw = yaw_response(truth, TIMES, PULSE).yaw
    yaw = yaw + noise * deg * np.random.default_rng(seed).standard_normal(len(TIMES))
    return Trial(name=name, time=TIMES, yaw=yaw, rate=2000.0, perturbation=PULSE)


@functools.cache
def one_recording():
    return compare_controllers([recorded(0)], model_of(FLY), noise="white")


def test_a_fly_with_derivative_gain_is_told_from_a_proportional_one_by_every_criterion():
    found = one_recording()
    assert (found.by_aicc, found.by_bic) == ("PD", "PD")
    assert found["P"].aicc - found["PD"].aicc > 100
    assert found["P"].cross_validation > found["PD"].cross_validation + 100
    assert found["P"].error > found["PD"].error
    assert "P is worse by" in found.sentence


def test_criteria_are_those_of_the_likelihood_of_independent_residuals():
    found = fit_gains([recorded(0)], model_of(FLY), noise="white")
    (residuals,), sigma = found.residuals()[0], found.noise[0][0].deviation
    deviance = -2 * scipy.stats.norm.logpdf(residuals, scale=sigma).sum()
    row = one_recording()["PD"]
    n, k = 201, 6  # kp, kd, delay, impulse, heading, variance
    assert row.unknowns == k
    assert abs(row.deviance - deviance) < 1e-6 * abs(deviance)
    assert abs(row.aicc - (deviance + 2 * k + 2 * k * (k + 1) / (n - k - 1))) < 1e-6 * abs(deviance)
    assert abs(row.bic - (deviance + k * np.log(n))) < 1e-6 * abs(deviance)


def test_a_more_general_controller_never_fits_worse():
    rows = {row.controller: row for row in one_recording().rows}
    for special, general in (("P", "PD"), ("P", "PI"), ("PD", "PID"), ("PI", "PID")):
        assert rows[general].deviance <= rows[special].deviance + 0.1, (special, general)  # variance by n - k, not n
    assert abs(sum(row.weight for row in rows.values()) - 1) < 1e-12


@pytest.mark.slow
def test_aicc_takes_a_proportional_fly_for_pd_as_often_as_chance_lets_it():
    wrong_aicc = wrong_bic = 0
    for seed in range(200):
        found = compare_controllers(
            [recorded(seed, SLOW_FLY)], model_of(SLOW_FLY), ("P", "PD"), noise="white", validation=None
        )
        wrong_aicc += found.by_aicc == "PD"
        wrong_bic += found.by_bic == "PD"
    # one unknown more wins when a chi^2 of one degree of freedom exceeds what the criterion charges for it
    for wrong, price in ((wrong_aicc, 2 + 0.11), (wrong_bic, np.log(201))):
        low, high = scipy.stats.binom.ppf([0.0005, 0.9995], 200, scipy.stats.chi2.sf(price, 1))
        assert low <= wrong <= high, (wrong, price)


def test_several_recordings_are_predicted_from_each_other():
    trials = [recorded(k, FLY | {"impulse": 20.0 + 5 * k}, name=f"trial {k}") for k in range(4)]
    found = compare_controllers(trials, model_of(FLY), ("P", "PD"), noise="white")
    assert found.validation == "each recording predicted from the others"
    assert found["P"].scores.shape == (4,)
    assert np.all(found["P"].scores > found["PD"].scores)
    assert abs(found["PD"].cross_validation / (4 * 201) - 1) < 0.15  # whitened squares of samples: 1 +- 0.05, 3 sigma


def test_all_controllers_get_noise_of_one_order():
    rng = np.random.default_rng(0)
    innovations = rng.standard_normal(401)
    noise = scipy.signal.lfilter([np.sqrt(1 - 0.9**2)], [1, -0.9], innovations)[200:]
    yaw = yaw_response(FLY, TIMES, PULSE).yaw + 0.3 * deg * noise
    trial = Trial(name="coloured", time=TIMES, yaw=yaw, rate=2000.0, perturbation=PULSE)
    found = compare_controllers([trial], model_of(FLY), ("P", "PD"))
    assert found.order >= 1
    assert found["PD"].unknowns - found["P"].unknowns == 1
    assert found.by_aicc == "PD"


def test_blocks_of_an_undisturbed_recording_are_predicted_exactly():
    fit = fit_gains([recorded(0, noise=1e-7)], model_of(FLY), noise="white")
    held = blocks_left_out(fit, fit.noise, 0.01, 5)
    assert held.scores.shape == (5,)
    assert held.error < 3e-7 * deg
    assert abs(held.scores.sum() / 201 - 1) < 0.4  # every sample once, in units of its noise


def test_a_comparison_that_compares_nothing_is_refused():
    with pytest.raises(InvalidParameterError, match="two or more different controllers"):
        compare_controllers([recorded(0)], controllers=["PD"])
    with pytest.raises(InvalidParameterError, match="Unknown controller 'PDD'"):
        compare_controllers([recorded(0)], controllers=["P", "PDD"])
    with pytest.raises(InvalidParameterError, match="'PI' was not compared"):
        compare_controllers([recorded(0)], model_of(FLY), ("P", "PD"), noise="white", validation=None)["PI"]
    with pytest.raises(InvalidInputError, match="fewer than 5 blocks"):
        compare_controllers([recorded(0)], model_of(FLY), ("P", "PD"), noise="white", validation=Validation(block=0.05))
    with pytest.raises(InvalidParameterError, match=r"block must be > 0 s"):
        Validation(block=-1.0)


def test_jobs_of_one_comparison_keep_their_finished_parts_apart(tmp_path):
    kept = Labour(checkpoint=Checkpoint(tmp_path, "these recordings"))
    P, PD = kept.on("P").checkpoint, kept.on("PD").checkpoint
    assert P.folder != PD.folder
    assert P.identity != PD.identity
    assert Labour().on("P").checkpoint is None
