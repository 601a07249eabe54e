"""Fits to data drawn anew around an estimate."""

import numpy as np
import pytest
from perturbed_fly import AT_REST, recording

from flycontrol.errors import InvalidParameterError
from flycontrol.identify.gains.bootstrap import bootstrap
from flycontrol.identify.gains.fit import fit_gains
from flycontrol.identify.gains.labour import Labour
from flycontrol.identify.gains.model import gain_model
from flycontrol.identify.gains.noise import Noise, drawn, whitened

MODEL = gain_model(fixed=AT_REST | {"damping": 69.0})
DRAWS = 400
DEVIATION_ERROR = 4 / np.sqrt(2 * DRAWS)  # of a standard deviation from as many draws, relative, fourfold


@pytest.fixture(scope="module")
def found():
    return fit_gains([recording(0)], MODEL)


def relative_spread(boot, found):
    return np.sqrt(np.diag(boot.covariance) / np.diag(found.covariance))


@pytest.mark.parametrize("pacf", [[], [0.9], [0.8, -0.3, 0.5]])
def test_drawn_noise_is_what_the_whitening_undoes(pacf):
    noise = Noise(0.2, np.array(pacf), np.eye(1 + len(pacf)))
    firsts = np.array([0, 2, 300])  # a stretch shorter than the order, too
    innovations = np.random.default_rng(3).standard_normal(801)
    back = whitened(drawn(noise, firsts, 801, np.random.default_rng(3))[None, :], firsts, noise)[0]
    np.testing.assert_allclose(back, innovations, atol=1e-12)


@pytest.mark.parametrize("kind", ["parametric", "block"])
def test_draws_spread_as_the_covariance_says_where_it_is_true(found, kind):
    boot = bootstrap(found, DRAWS, kind=kind, seed=1)
    assert boot.failed == 0
    assert np.abs(relative_spread(boot, found) - 1).max() < DEVIATION_ERROR + 0.06 * (kind == "block")


def test_coloured_noise_is_drawn_coloured():
    coloured = fit_gains([recording(3, correlation=0.9)], MODEL)
    assert np.abs(relative_spread(bootstrap(coloured, DRAWS), coloured) - 1).max() < DEVIATION_ERROR + 0.02


def test_blocks_keep_the_correlation_that_a_white_noise_model_misses():
    trial = recording(3, correlation=0.9)
    naive, careful = fit_gains([trial], MODEL, noise="white"), fit_gains([trial], MODEL)
    boot = bootstrap(naive, DRAWS, kind="block")
    i = naive.problem.names.index("kp")
    spread = np.sqrt(boot.covariance[i, i])
    assert spread > 2.5 * naive["kp"].standard_error
    assert spread < 1.3 * careful["kp"].standard_error  # blocks lose some correlation at their ends, never gain any


def test_the_draws_are_the_same_bytes_for_one_worker_and_two(found):
    one, two = (bootstrap(found, 24, seed=7, labour=Labour(workers=w)) for w in (1, 2))
    assert one.draws.tobytes() == two.draws.tobytes()
    assert one.draws.tobytes() != bootstrap(found, 24, seed=8).draws.tobytes()


@pytest.mark.parametrize("method", ["percentile", "basic", "bca"])
def test_bootstrap_intervals_agree_with_students_where_the_model_is_nearly_linear(found, method):
    boot = bootstrap(found, 1000, seed=2)
    for estimate in found.estimates:
        low, high = boot.interval(estimate.name, method=method)
        # a 2.5 % quantile of 1,000 normal draws has a standard error of 0.085 standard deviations; BCa's own z0 of 0.04
        close = 4 * np.hypot(0.085, 2 * 0.04 * (method == "bca")) * estimate.standard_error
        assert abs(low - estimate.low - estimate.bias) < close
        assert abs(high - estimate.high - estimate.bias) < close


def test_basic_intervals_mirror_percentile_intervals_at_the_estimate(found):
    boot = bootstrap(found, 50)
    low, high = boot.interval("kp", method="percentile")
    assert boot.interval("kp", method="basic") == pytest.approx((2 * boot.centre[0] - high, 2 * boot.centre[0] - low))


def test_a_bad_request_of_a_bootstrap_is_refused(found):
    with pytest.raises(InvalidParameterError, match="at least 2 draws"):
        bootstrap(found, 1)
    with pytest.raises(InvalidParameterError, match="An interval needs one of kp"):
        bootstrap(found, 10).interval("gain")
