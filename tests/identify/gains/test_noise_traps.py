"""Fits with noise: biased gains and intervals that are too narrow, and how the fit keeps clear of both."""

from dataclasses import replace

import numpy as np
import pytest
from perturbed_fly import AT_REST, TRUTH, recording

from flycontrol.identify.gains.fit import fit_gains
from flycontrol.identify.gains.model import gain_model

FREE = gain_model(fixed=AT_REST)


def mirrored(trial, clean):
    """The same recording with the noise turned over: errors of first order cancel in the mean of both fits."""
    return replace(trial, yaw=2 * clean - trial.yaw)


@pytest.mark.parametrize(("noise", "correlation"), [(1.0, 0.0), (0.3, 0.9)])
def test_curvature_biases_kd_by_least_squares_and_the_estimates_are_freed_of_it(noise, correlation):
    clean = recording(0, noise=0.0).yaw
    raw, predicted, variance = [], [], []
    for seed in range(24):
        trial = recording(seed, noise=noise, correlation=correlation)
        for one in (trial, mirrored(trial, clean)):
            found = fit_gains([one], FREE, noise=1 if correlation else "white")
            raw.append(found.minimum.x[1] - TRUTH["kd"])
            predicted.append(found.uncertainty.bias[1])
            variance.append(found["kd"].standard_error ** 2)
    error = np.sqrt(np.mean(variance))
    assert 0.1 < np.mean(raw) / error < 0.4
    assert abs(np.mean(raw) - np.mean(predicted)) / error < 0.1


@pytest.mark.slow
def test_coloured_noise_leaves_95_percent_intervals_at_92_percent_or_more_of_400_recordings():
    model = gain_model(fixed=AT_REST | {"damping": 69.0})
    inside = dict.fromkeys(("kp", "kd", "delay"), 0)
    naive = dict(inside)
    for seed in range(400):
        trial = recording(seed, correlation=0.9)
        careful, plain = fit_gains([trial], model), fit_gains([trial], model, noise="white")
        for name in inside:
            inside[name] += careful[name].low <= TRUTH[name] <= careful[name].high
            naive[name] += plain[name].low <= TRUTH[name] <= plain[name].high
    assert min(inside.values()) >= 368, inside
    assert max(naive.values()) < 300, naive  # what taking the noise for white would give
