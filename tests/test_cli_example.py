import tomllib

import numpy as np
import pytest

from flycontrol.identify.gains.synthetic import PULSE, synthetic_experiment
from flycontrol.io.trials import read_trials


@pytest.fixture
def example(command):
    """Run `flycontrol example`: exit status, standard error."""

    def run(*arguments):
        status, _, said = command("example", *arguments)
        return status, said

    return run


def test_the_mapping_reads_back_the_trials_that_were_simulated(example, tmp_path):
    status, said = example(tmp_path / "demo", "--flies", 2)
    assert status == 0
    assert "8 synthetic recordings" in said
    made = synthetic_experiment(0, 2)
    trials = read_trials([f"{tmp_path}/demo/*.csv"], tmp_path / "demo/mapping.toml")
    assert [trial.name for trial in trials] == [trial.name for trial in made.trials]
    for read, simulated in zip(trials, made.trials, strict=True):
        assert (read.fly, read.perturbation) == (simulated.fly, PULSE)
        np.testing.assert_allclose(read.time, simulated.time, atol=1e-9)
        turns = np.round((simulated.yaw - read.yaw)[0] / (2 * np.pi)) * 2 * np.pi
        for mine, truth in ((read.yaw + turns, simulated.yaw), (read.paddling, simulated.paddling)):
            np.testing.assert_allclose(mine, truth, atol=np.radians(0.0006))  # written to 0.001 deg, NaN where NaN


def test_the_truth_lies_apart_and_is_that_of_the_simulation(example, tmp_path):
    example(tmp_path, "--flies", 1, "--seed", 7)
    truth, made = tomllib.loads((tmp_path / "truth.toml").read_text()), synthetic_experiment(7, 1)
    assert truth["flies"]["fly1"] == pytest.approx(made.flies["fly1"], rel=1e-9)
    assert truth["angular_impulse"] == pytest.approx(made.impulses, rel=1e-9)
    assert (tmp_path / "README.txt").read_text().startswith("SYNTHETIC DATA")


def test_the_same_seed_gives_the_same_bytes_and_another_is_refused_over_it(example, tmp_path):
    example(tmp_path, "--flies", 1)
    before = {path: path.read_bytes() for path in tmp_path.iterdir()}
    assert example(tmp_path, "--flies", 1)[0] == 0
    status, said = example(tmp_path, "--flies", 1, "--seed", 1)
    assert status == 2
    assert "is not of this example; choose another folder" in said
    assert {path: path.read_bytes() for path in tmp_path.iterdir()} == before


def test_nothing_is_mixed_with_other_tables(example, tmp_path):
    (tmp_path / "mine.csv").write_text("1\n")
    status, said = example(tmp_path)
    assert status == 2
    assert "mine.csv stands there already" in said
    assert [path.name for path in tmp_path.iterdir()] == ["mine.csv"]
