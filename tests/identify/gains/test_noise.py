"""Autoregressive noise by restricted likelihood."""

import numpy as np
import pytest
import scipy.linalg
import scipy.signal

from flycontrol.identify.gains.kernels import noise as kernels
from flycontrol.identify.gains.noise import Noise, estimate, order_by_bic, whitened

NO_GAP = np.array([0], dtype=np.int64)


def covariance(pacf, n):
    """Of n samples of unit innovations, from the autocorrelations by Levinson's recursion run backwards."""
    table = np.zeros((len(pacf), len(pacf)))
    kernels.coefficients(np.asarray(pacf), table)
    impulse = scipy.signal.lfilter([1.0], np.concatenate([[1.0], -table[-1]]), np.eye(1, 20000)[0])
    return scipy.linalg.toeplitz([impulse[: 20000 - k] @ impulse[k:] for k in range(n)])


@pytest.mark.parametrize("pacf", [[0.9], [0.5, -0.7], [0.8, 0.3, -0.4]])
def test_whitened_samples_have_the_likelihood_of_the_correlated_ones(pacf):
    rng = np.random.default_rng(0)
    rows, firsts = rng.standard_normal((3, 40)), np.array([0, 2, 17], dtype=np.int64)
    noise = Noise(1.0, np.array(pacf), np.eye(1 + len(pacf)))
    whitened_rows = whitened(rows, firsts, noise)
    V = scipy.linalg.block_diag(*[covariance(pacf, n) for n in (2, 15, 23)])
    expected = rows @ np.linalg.solve(V, rows.T)
    np.testing.assert_allclose(whitened_rows @ whitened_rows.T, expected, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("pacf", [[0.9], [0.5, -0.7]])
def test_the_restricted_likelihood_is_that_of_dense_matrices(pacf):
    rng = np.random.default_rng(1)
    rows, firsts = rng.standard_normal((4, 50)), np.array([0, 21], dtype=np.int64)
    value, variance = kernels.restricted(*kernels.lagged(rows, firsts, len(pacf)), 50, np.array(pacf))
    V = scipy.linalg.block_diag(covariance(pacf, 21), covariance(pacf, 29))
    r, X = rows[0], rows[1:].T
    W = np.linalg.inv(V)
    information = X.T @ W @ X
    left = r @ W @ r - r @ W @ X @ np.linalg.solve(information, X.T @ W @ r)
    dense = 47 * np.log(left / 47) + np.linalg.slogdet(V)[1] + np.linalg.slogdet(information)[1]
    assert abs(value - dense) < 1e-8 * abs(dense)
    assert abs(variance - left / 47) < 1e-9 * variance


def test_the_variance_is_not_underestimated_where_many_derivatives_are_fitted():
    rng = np.random.default_rng(2)
    found = []
    for _ in range(200):
        X, y = rng.standard_normal((10, 40)), rng.standard_normal(40)
        residual = y - X.T @ np.linalg.lstsq(X.T, y, rcond=None)[0]
        found.append(estimate(np.vstack([residual, X]), NO_GAP, 0).deviation ** 2)
    assert abs(np.mean(found) - 1.0) < 4 * np.std(found) / np.sqrt(200)


def test_the_order_of_white_and_of_coloured_noise_is_recognised():
    rng = np.random.default_rng(3)
    white = [order_by_bic(rng.standard_normal(800), NO_GAP, 4) for _ in range(100)]
    coloured = [
        order_by_bic(scipy.signal.lfilter([1.0], [1.0, -0.9], rng.standard_normal(900))[100:], NO_GAP, 4)
        for _ in range(100)
    ]
    assert white.count(0) >= 95  # one lag passes by chance in 1 % of cases: P(chi2 > log 800)
    assert coloured.count(1) >= 90
    assert 0 not in coloured


def test_its_uncertainty_is_that_of_repeated_estimates():
    rng = np.random.default_rng(4)
    X = np.vstack([np.cos(np.pi * k * np.linspace(0, 1, 400)) for k in range(4)])
    found = []
    for _ in range(200):
        y = scipy.signal.lfilter([1.0], [1.0, -0.8], rng.standard_normal(600))[200:]
        noise = estimate(np.vstack([y, X]), NO_GAP, 1)
        found.append([np.arctanh(noise.pacf[0]), noise.uncertainty[1, 1]])
    z, variances = np.array(found).T
    assert abs(np.mean(np.tanh(z)) - 0.8) < 0.01
    assert 0.8 < np.var(z) / np.mean(variances) < 1.25  # 200 draws know a variance to 10 %
