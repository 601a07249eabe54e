"""The command from files to results; what the options mean is tested apart."""

import json
import sys

import pytest

from flycontrol import cli
from flycontrol.identify.gains.synthetic import synthetic_experiment
from flycontrol.io.example_files import example_files

AT_REST = ("--fix", "initial_yaw=0", "--fix", "initial_rate=0")


@pytest.fixture(scope="module")
def demo(tmp_path_factory):
    """The example's files of one fly."""
    folder, made = tmp_path_factory.mktemp("demo"), synthetic_experiment(0, 1)
    for name, text in example_files(made.trials, made.flies, made.impulses, 0).items():
        (folder / name).write_text(text)
    return folder


@pytest.fixture
def command(monkeypatch, capsys):
    """Run `flycontrol fit` in this process: exit status, standard output, standard error."""

    def run(*arguments):
        monkeypatch.setattr(sys, "argv", ["flycontrol", "fit", *map(str, arguments)])
        with pytest.raises(SystemExit) as done:
            cli.main()
        printed = capsys.readouterr()
        return done.value.code or 0, printed.out, printed.err

    return run


def test_json_on_standard_output_holds_the_truth_and_nothing_is_written(command, demo, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    status, printed, said = command(demo / "*3.csv", "--mapping", demo / "mapping.toml", "--json", *AT_REST)
    assert status == 0
    assert said.startswith("flycontrol: converged")
    found, truth = json.loads(printed), synthetic_experiment(0, 1).flies["fly1"]
    estimates = {e["name"]: e for e in found["estimates"]}
    for name, value in truth.items():
        assert abs(estimates[name]["value"] - value) < 4 * estimates[name]["standard_error"], name
    assert not list(tmp_path.iterdir())


def test_without_a_mapping_one_to_edit_is_printed(command, demo):
    status, printed, said = command(demo / "fly1_pulse1.csv")
    assert status == 2
    assert "time_ms" in printed
    assert "no --mapping says what its numbers mean" in said


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["--noise", "pink"], "--noise must be auto, white or an order from 0 to 12, got 'pink'."),
        (["--loss", "cauchy"], "--loss must be linear or huber, got 'cauchy'."),
        (["--level", "95"], "--level must lie between 0 and 1, got 95."),
        (["--fix", "damping=69"], "without a unit"),
        (["--estimate", "gain"], "unknown parameter, 'gain'"),
        (["--out", "FILE"], "is not a folder"),
    ],
)
def test_bad_options_end_with_status_2_before_any_work(command, demo, tmp_path, arguments, sentence):
    (tmp_path / "FILE").touch()
    arguments = [tmp_path / "FILE" if word == "FILE" else word for word in arguments]
    status, _, said = command(demo / "*.csv", "--mapping", demo / "mapping.toml", *arguments)
    assert status == 2
    assert sentence in said
    assert said.count("\n") == 1


def test_a_pattern_that_matches_nothing_is_refused(command, demo, tmp_path):
    status, _, said = command(demo / "*.tsv", "--mapping", demo / "mapping.toml", "--out", tmp_path / "out")
    assert status == 2
    assert "No file matches" in said
    assert not (tmp_path / "out").exists()
