"""What surrounds a fit: the same for any number of workers, nothing done twice, nothing kept at the end."""

from dataclasses import replace

import numpy as np
import pytest

from flycontrol.identify.gains.model import gain_model
from flycontrol.identify.gains.recording_fits import autocorrelation
from flycontrol.identify.gains.stages import Stages, identity_of
from flycontrol.identify.gains.study import FitOptions, fit_study
from flycontrol.identify.gains.synthetic import synthetic_experiment
from flycontrol.jobs.processes import ProcessPool

MODEL = gain_model(fixed={"initial_yaw": 0.0, "initial_rate": 0.0, "damping": 69.0})
OPTIONS = FitOptions(noise=2, bootstrap=6, compare=False)


@pytest.fixture(scope="module")
def trials():
    return [replace(trial, paddling=None) for trial in synthetic_experiment(0, 2).trials[2:7:4]]


def numbers(study):
    single = [fit.values for fit in study.single.fits]
    return np.concatenate([study.bootstrap.draws.ravel(), study.profiles["delay"].values, *single])


def test_results_are_the_same_bytes_for_any_workers_and_finished_parts_are_not_done_again(trials, tmp_path):
    alone = fit_study(trials, MODEL, OPTIONS)
    with ProcessPool(2) as pool:
        stages = Stages(workers=pool, folder=tmp_path / "unfinished")
        shared = fit_study(trials, MODEL, OPTIONS, stages)
    assert numbers(shared).tobytes() == numbers(alone).tobytes()

    kept = sorted((tmp_path / "unfinished").rglob("*.npz"))
    before = {path: path.stat().st_mtime_ns for path in kept}
    assert len(kept) == 2 + 2 + 2 + 3 + 6  # flies, recordings, recordings left out, profiles, bootstrap fits
    again = fit_study(trials, MODEL, OPTIONS, Stages(folder=tmp_path / "unfinished"))
    assert numbers(again).tobytes() == numbers(alone).tobytes()
    assert {path: path.stat().st_mtime_ns for path in kept} == before

    stages.clear()
    assert not list(tmp_path.iterdir())


def test_an_identity_changes_with_every_sample_and_option(trials):
    moved = np.array(trials[0].yaw)
    moved[0] += 1e-12
    identities = {
        identity_of(trials, MODEL, "auto"),
        identity_of(trials, MODEL, 2),
        identity_of(trials[:1], MODEL, "auto"),
        identity_of([replace(trials[0], yaw=moved), trials[1]], MODEL, "auto"),
        identity_of(trials, gain_model(), "auto"),
    }
    assert len(identities) == 5
    assert identity_of(trials, MODEL, "auto") in identities


def test_autocorrelation_of_autoregressive_noise_falls_by_its_coefficient_and_never_pairs_across_a_gap():
    rng = np.random.default_rng(0)
    noise = np.zeros(200_000)
    for k, innovation in enumerate(rng.standard_normal(len(noise) - 1), start=1):
        noise[k] = 0.8 * noise[k - 1] + innovation
    found = autocorrelation(noise, np.array([0]), 5)
    np.testing.assert_allclose(found, 0.8 ** np.arange(6), atol=4 * 3 / np.sqrt(len(noise)))
    ends = autocorrelation(np.array([1.0, -1.0, 5.0, -5.0]), np.array([0, 2]), 2)
    assert ends[1] == pytest.approx((-1 - 25) / 2 / 13)
    assert np.isnan(ends[2])
