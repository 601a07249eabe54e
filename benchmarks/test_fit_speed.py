"""One fit of kp, kd and the delay against named peers, at measured distances from the least-squares minimiser."""

import time

import numpy as np
import problems
import pytest
from scoreboard import Row
from test_speed import US, run_peer, stopwatch

from flycontrol.identify.gains.fit import fit_gains
from flycontrol.identify.gains.least_squares import WeightedProblem, minimise
from flycontrol.identify.gains.model import gain_model
from flycontrol.identify.gains.noise import white
from flycontrol.identify.gains.problem import fit_problem
from flycontrol.model.trial import Pulse, Trial

NAMES = ("kp", "kd", "delay")
BOOTSTRAP = 1000


def the_recording(problem, yaw):
    pulse = Pulse(onset=0.0, duration=problem["pulse"], angular_impulse=problem["acceleration"] * problem["pulse"])
    return Trial(name="fly", time=np.array(problem["times"]), yaw=np.array(yaw), rate=problems.RATE, perturbation=pulse)


def the_model(problem):
    return gain_model(fixed={"damping": problem["b"], "initial_yaw": 0.0, "initial_rate": 0.0, "heading": 0.0})


@pytest.mark.benchmark(disable_gc=True, warmup=True, timer=time.process_time)
def test_least_squares_ends_at_the_minimiser_to_a_thousandth_of_a_standard_error(benchmark, rows, tmp_path):
    """What the peers do and no more: the recording turned into a problem, and a search from their starting values."""
    problem = problems.fit()
    trial, model = the_recording(problem, problem["yaw"]), the_model(problem)

    def search():
        asked = fit_problem([trial], model)
        return asked.names, minimise(WeightedProblem(asked, [[white(problems.NOISE, 1.0)]]), np.array(problem["start"]))

    names, found = benchmark(search)
    assert names == NAMES
    error = stopwatch.estimate_error(problem, found.x)
    ours = Row(
        job="least squares for kp, kd, T", tool=US, setting="from the peers' start",
        run_s=benchmark.stats.stats.median, best_s=benchmark.stats.stats.min, error=error, unit="standard errors",
    )  # fmt: skip
    rows.append(ours)
    for peer in ("jitcdde_fit", "control_fit", "lmfit_fit"):
        rows.extend(run_peer(peer, problem, ours, tmp_path))
    assert error < 1e-3


@pytest.mark.benchmark(disable_gc=True, warmup=True, timer=time.process_time)
def test_a_whole_fit_ends_at_the_same_minimiser(benchmark, rows):
    """Everything included: starting values from the data, order of the noise, bias, intervals, the status."""
    problem = problems.fit()
    trial, model = the_recording(problem, problem["yaw"]), the_model(problem)
    found = benchmark(fit_gains, [trial], model)
    error = stopwatch.estimate_error(problem, found.minimum.x)
    rows.append(
        Row(
            job="whole fit of kp, kd, T", tool=US, setting="no start given; noise, bias and intervals included",
            run_s=benchmark.stats.stats.median, best_s=benchmark.stats.stats.min, error=error, unit="standard errors",
        )
    )  # fmt: skip
    assert error < 1e-3


@pytest.mark.slow
@pytest.mark.benchmark(disable_gc=True, timer=time.process_time)
def test_a_thousand_bootstrap_fits_scatter_like_the_standard_errors(benchmark, rows):
    """Each with noise of its own, from the estimate on; within 4 times the scatter of a standard deviation."""
    problem = problems.fit()
    fitted = fit_gains([the_recording(problem, problem["yaw"])], the_model(problem))
    clean, noise = fitted.problem.parts[0].predicted(fitted.minimum.x, False)[0][0], np.random.default_rng(2)

    def bootstrap():
        estimates = []
        for _ in range(BOOTSTRAP):
            yaw = clean + problems.NOISE * noise.standard_normal(len(clean))
            again = fit_problem([the_recording(problem, yaw)], fitted.problem.model)
            weighted = WeightedProblem(again, fitted.weighted.noise)
            estimates.append(minimise(weighted, fitted.minimum.x, scale=1.0).x)
        return np.array(estimates)

    estimates = benchmark.pedantic(bootstrap, rounds=2)
    scatter = estimates.std(axis=0) / np.array(problem["standard_errors"])
    rows.append(
        Row(
            job="1000 bootstrap fits of kp, kd, T",
            tool=US,
            setting="one core, each from the estimate",
            run_s=benchmark.stats.stats.median,
            best_s=benchmark.stats.stats.min,
            error=float(np.abs(scatter - 1).max()),
            unit="of the scatter",
        )
    )
    np.testing.assert_allclose(scatter, 1.0, atol=4 / np.sqrt(2 * BOOTSTRAP))
