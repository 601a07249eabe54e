"""Flies compared with each other: shared gains, their spread, predictions from the others, outliers by name."""

import functools
from dataclasses import replace

import numpy as np
import pytest
import scipy.stats

from flycontrol.errors import InvalidInputError, InvalidParameterError
from flycontrol.identify.gains.alone import LoneFit, fits_alone
from flycontrol.identify.gains.fit import fit_gains
from flycontrol.identify.gains.homogeneity import homogeneity
from flycontrol.identify.gains.labour import Labour
from flycontrol.identify.gains.left_out import leave_one_out
from flycontrol.identify.gains.model import gain_model
from flycontrol.identify.gains.outliers import outliers
from flycontrol.identify.gains.random_effects import random_effects, spread
from flycontrol.identify.gains.response import yaw_response
from flycontrol.jobs.checkpoint import Checkpoint
from flycontrol.model.trial import Pulse, Trial
from flycontrol.units import deg

TRUTH = {"kp": 3050.0, "kd": 45.0, "delay": 0.0136, "damping": 69.0, "impulse": 35.0}
MODEL = gain_model(fixed={"initial_yaw": 0.0, "initial_rate": 0.0, "damping": 69.0})
PULSE = Pulse(onset=0.01, duration=0.0045)
TIMES = np.arange(201) / 2000


def trials(seed, count, *, flies=1, noise=0.3, odd=None, kd_by_fly=lambda fly: 45.0):
    rng = np.random.default_rng(seed)
    found = []
    for k in range(count):
        kd = kd_by_fly(k % flies) if k not in (odd or {}) else odd[k]
        values = TRUTH | {"impulse": float(rng.uniform(20, 40) * rng.choice([-1, 1])), "kd": kd}
        yaw = yaw_response(values, TIMES, PULSE).yaw + noise * deg * rng.standard_normal(len(TIMES))
        found.append(
            Trial(name=f"trial {k}", fly=f"fly {k % flies}", time=TIMES, yaw=yaw, rate=2000.0, perturbation=PULSE)
        )
    return found


def lone(name, kd, *, error=1.0, freedom=200.0):
    return LoneFit(
        name=name, trials=(name,), kinds=("kd",), values=np.array([kd]), covariance=np.array([[error**2]]),
        freedom=np.array([freedom]), cost=0.0, free=1, minimum={}, noise=(), usable=True, status="",
    )  # fmt: skip


@functools.cache
def alike():
    """Six recordings of three flies of one kind, pooled and alone."""
    those = trials(0, 6, flies=3)
    return those, fit_gains(those, MODEL, noise="white"), fits_alone(those, MODEL, by="recording", noise="white")


def test_a_fit_inside_a_group_is_judged_as_the_same_fit_alone():
    """The second recording ends 25 ms after the onset, before a reflex could act and be answered."""
    whole, cut = trials(0, 2, flies=2)
    cut = replace(cut, time=cut.time[:71], yaw=cut.yaw[:71])
    inside, alone = fits_alone([whole, cut], MODEL), [fit_gains([trial], MODEL) for trial in (whole, cut)]
    assert [fit.usable for fit in inside] == [True, False]
    assert [fit.status for fit in inside] == [found.status for found in alone]
    assert alone[1].status.startswith("not identifiable: the longest recording shows 25 ms after the onset")
    assert alone[1]["kp"].standard_error == np.inf


def test_without_noise_every_fly_alone_gives_its_own_gains_back():
    found = fits_alone(trials(1, 4, flies=2, noise=1e-7, kd_by_fly=lambda fly: 40.0 + 10 * fly), MODEL, noise="white")
    assert [fit.name for fit in found] == ["fly 0", "fly 1"]
    assert found[1].trials == ("trial 1", "trial 3")
    for fly, fit in enumerate(found):
        assert abs(fit.estimate("kd") - (40.0 + 10 * fly)) < 1e-4
        assert abs(fit.estimate("kp") - 3050.0) < 1e-2


def test_workers_and_an_interruption_change_no_byte_of_the_fits_alone(tmp_path):
    those = trials(2, 3)
    here = fits_alone(those, MODEL, by="recording", noise="white")
    labour = Labour(workers=1, checkpoint=Checkpoint(tmp_path, identity="three recordings"))
    fits_alone(those, MODEL, by="recording", noise="white", labour=labour)
    (tmp_path / "chunk-000001.npz").unlink()
    told = []
    resumed = Labour(checkpoint=labour.checkpoint, progress=lambda done, total, what: told.append((done, total, what)))
    again = fits_alone(those, MODEL, by="recording", noise="white", labour=resumed)
    assert told == [(2, 3, "recordings"), (3, 3, "recordings")]
    for one, other in zip(here, again, strict=True):
        assert one.values.tobytes() == other.values.tobytes()
        assert one.covariance.tobytes() == other.covariance.tobytes()


def test_the_weighted_mean_of_recordings_alone_is_the_pooled_fit_within_a_fraction_of_its_error():
    _, pooled, alone = alike()
    summary = random_effects(alone, "kd")
    assert summary.count == 6
    assert abs(summary.mean - pooled["kd"].value) < 0.5 * pooled["kd"].standard_error


def test_a_damping_that_differs_between_flies_is_noticed():
    those = trials(3, 4, flies=2, kd_by_fly=lambda fly: 40.0 + 15 * fly)
    found = homogeneity(those, MODEL, fits_alone(those, MODEL, noise="white"))
    assert found.p < 1e-6
    assert found.sentence.startswith("The 2 fits differ in kp, kd and delay")
    assert found.unknowns == 3


def test_recordings_of_one_kind_pass_for_one_kind():
    those, _, alone = alike()
    found = homogeneity(those, MODEL, alone)
    assert found.unknowns == 15
    assert found.p > 1e-3
    assert (found.p < 0.05) == ("differ in" in found.sentence)


@pytest.mark.slow
def test_equal_flies_are_called_different_in_5_percent_of_200_experiments():
    p = []
    for seed in range(200):
        those = trials(1000 + seed, 4)
        p.append(homogeneity(those, MODEL, fits_alone(those, MODEL, by="recording", noise="white")).p)
    low, high = scipy.stats.binom.ppf([0.0005, 0.9995], 200, 0.05)
    assert low <= np.sum(np.array(p) < 0.05) <= high
    assert scipy.stats.kstest(p, "uniform").pvalue > 1e-3


def test_intervals_of_the_spread_between_flies_hold_the_truth_in_95_percent_of_1000_experiments():
    rng, tau, inside, mean_inside = np.random.default_rng(5), 4.0, 0, 0
    for _ in range(1000):
        errors = rng.uniform(1.0, 5.0, 8)
        found = spread("kd", 45.0 + tau * rng.standard_normal(8) + errors * rng.standard_normal(8), errors)
        inside += found.deviation_low <= tau <= found.deviation_high
        mean_inside += found.mean_low <= 45.0 <= found.mean_high
    low, high = scipy.stats.binom.ppf([0.0005, 0.9995], 1000, 0.95)
    assert low <= inside <= high
    assert low <= mean_inside


def test_with_equal_errors_the_spread_is_the_excess_of_the_variance():
    values = np.array([40.0, 44.0, 47.0, 53.0, 41.0])
    found = spread("kd", values, np.full(5, 2.0))
    assert abs(found.deviation - np.sqrt(values.var(ddof=1) - 4.0)) < 1e-5
    assert abs(found.mean - values.mean()) < 1e-12
    assert spread("kd", [45.0, 45.1, 44.9], [2.0, 2.0, 2.0]).deviation == 0.0


def test_the_others_predict_a_recording_to_its_noise():
    _, pooled, alone = alike()
    found = leave_one_out(pooled, noise=[channels for fit in alone for channels in fit.noise])
    ratios = np.array([prediction.in_noise for prediction in found])
    assert all(prediction.converged for prediction in found)
    assert np.all(np.abs(ratios - 1) < 4 * np.sqrt(1 / (2 * len(TIMES))) + 0.03)  # 3 unknowns more in 200 samples
    assert np.all(np.abs([p.error / (0.3 * deg) - 1 for p in found]) < 0.2)


def test_leaving_one_out_refits_the_others():
    those, pooled, _ = alike()
    found = leave_one_out(pooled)[2]
    others = fit_gains([trial for trial in those if trial.name != "trial 2"], MODEL, noise="white")
    for name, value in found.from_others.items():
        i = others.problem.names.index(name)
        assert abs(value - others.minimum.x[i]) < 0.02 * others[name].standard_error, name


def test_an_odd_recording_is_named_and_so_is_what_is_odd_about_it():
    alone = fits_alone(trials(6, 8, odd={5: 10.0}), MODEL, by="recording", noise="white")
    (found,) = outliers(alone)
    assert found.name == "trial 5"
    assert found.p < 1e-3
    assert found.sentence.startswith("trial 5 does not go with the others: its k")
    assert abs(found.deviations) > 4


def test_two_outliers_do_not_hide_each_other():
    rng = np.random.default_rng(0)
    fits = [lone(f"trial {k}", 45.0 + rng.standard_normal()) for k in range(10)]
    fits[3], fits[7] = lone("trial 3", 75.0), lone("trial 7", 80.0)
    assert {found.name for found in outliers(fits)} == {"trial 3", "trial 7"}


def test_an_outlier_is_named_among_equals_in_at_most_5_percent_of_500_experiments():
    rng, named = np.random.default_rng(1), 0
    for _ in range(500):
        named += bool(outliers([lone(f"trial {k}", rng.standard_normal()) for k in range(10)]))
    assert named <= scipy.stats.binom.ppf(0.9995, 500, 0.05)


def test_a_recording_that_says_nothing_is_named_too():
    those = trials(7, 3)
    still = Trial(
        name="still", time=TIMES, yaw=0.3 * deg * np.random.default_rng(0).standard_normal(201), rate=2000.0,
        perturbation=None,
    )  # fmt: skip
    alone = fits_alone([*those, still], MODEL, by="recording", noise="white")
    assert not alone[3].usable
    assert outliers(alone)[-1].sentence.startswith("still could not be fitted alone: not identifiable")
    assert homogeneity([*those, still], MODEL, alone).left_out == ("still",)


def test_too_few_recordings_are_refused_in_a_sentence():
    one = trials(8, 1)
    with pytest.raises(InvalidInputError, match="at least one trial, got none"):
        fits_alone([], MODEL)
    with pytest.raises(InvalidInputError, match="one alone has no others"):
        leave_one_out(fit_gains(one, MODEL, noise="white"))
    with pytest.raises(InvalidInputError, match="needs two that could be fitted, got 1"):
        homogeneity(one, MODEL, fits_alone(one, MODEL))
    with pytest.raises(InvalidInputError, match="at least two fits that converged, got 1"):
        spread("kd", [1.0], [1.0])
    with pytest.raises(InvalidParameterError, match="between 0 and 1"):
        spread("kd", [1.0, 2.0], [1.0, 1.0], level=95)
