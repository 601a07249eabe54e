"""The command from files to results; what the options mean is tested apart."""

import json
import re
import shlex
from dataclasses import replace
from functools import partial
from pathlib import Path

import pytest

from flycontrol.cli.fit_command import typed_command
from flycontrol.cli.fit_options import FitRequest, requested_model
from flycontrol.cli.fit_reporting import Report, listed
from flycontrol.identify.gains.problem import standard_model
from flycontrol.identify.gains.synthetic import synthetic_experiment
from flycontrol.io.example_files import example_files
from flycontrol.io.trials import read_trials

AT_REST = ("--fix", "initial_yaw=0", "--fix", "initial_rate=0")


@pytest.fixture(scope="module")
def demo(tmp_path_factory):
    """The example's files of one fly."""
    folder, made = tmp_path_factory.mktemp("demo"), synthetic_experiment(0, 1)
    for name, text in example_files(made.trials, made.flies, made.impulses, 0).items():
        (folder / name).write_text(text)
    return folder


@pytest.fixture
def fit(command):
    """Run `flycontrol fit`: exit status, standard output, standard error."""
    return partial(command, "fit")


def test_json_on_standard_output_holds_the_truth_and_nothing_is_written(fit, demo, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    status, printed, said = fit(demo / "*3.csv", "--mapping", demo / "mapping.toml", "--json", *AT_REST)
    assert status == 0
    assert said.startswith("flycontrol: converged")
    assert re.search(r"\nflycontrol: kp [\d.]+ 1/s\^2 \(from [\d.]+ to [\d.]+ 1/s\^2\); kd .*; delay [\d.]+ ms ", said)
    found, truth = json.loads(printed), synthetic_experiment(0, 1).flies["fly1"]
    estimates = {e["name"]: e for e in found["estimates"]}
    for name, value in truth.items():
        assert abs(estimates[name]["value"] - value) < 4 * estimates[name]["standard_error"], name
    assert not list(tmp_path.iterdir())


def test_without_a_mapping_one_to_edit_is_printed(fit, demo):
    status, printed, said = fit(demo / "fly1_pulse1.csv")
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
def test_bad_options_end_with_status_2_before_any_work(fit, demo, tmp_path, arguments, sentence):
    (tmp_path / "FILE").touch()
    arguments = [tmp_path / "FILE" if word == "FILE" else word for word in arguments]
    status, _, said = fit(demo / "*.csv", "--mapping", demo / "mapping.toml", *arguments)
    assert status == 2
    assert sentence in said
    assert said.count("\n") == 1


def test_a_folder_in_place_of_a_file_is_refused_in_one_sentence(fit, demo):
    status, _, said = fit(demo, "--mapping", demo / "mapping.toml")
    assert (status, said) == (2, f"flycontrol: {demo} is a folder; name a file in it.\n")


def test_everything_that_was_written_is_named():
    report = Report("", "", "", lambda *_: (), str)
    written = tuple(Path("out", name) for name in ("result.json", "stability.html", "index.html", "table.md"))
    assert listed(report, written) == f"{Path('out/index.html')}, result.json, stability.html and table.md"


def test_a_pattern_that_matches_nothing_is_refused(fit, demo, tmp_path):
    status, _, said = fit(demo / "*.tsv", "--mapping", demo / "mapping.toml", "--out", tmp_path / "out")
    assert status == 2
    assert "No file matches" in said
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("further", "sentence"),
    [
        ([], "the mapping gives fly1_pulse3 a perturbation; leave --spontaneous out"),
        (["--fix", "impulse=30 rad/s"], "--fix names the impulse of a pulse; leave one of them out"),
        (["--estimate", "onset_shift"], "--estimate names the onset_shift of a pulse; leave one of them out"),
    ],
)
def test_a_spontaneous_flight_that_was_perturbed_is_refused(fit, demo, further, sentence):
    status, _, said = fit(demo / "*3.csv", "--mapping", demo / "mapping.toml", "--spontaneous", *further)
    assert status == 2
    assert sentence in said


def test_from_python_the_standard_fit_asks_what_the_command_asks(demo):
    trials = read_trials([demo / "fly1_pulse3.csv"], demo / "mapping.toml")
    model = standard_model(trials)
    assert "paddling_gain" in model.unknown
    assert model == requested_model(FitRequest(), paddling=True)
    bare = [replace(trial, paddling=None) for trial in trials]
    assert standard_model(bare) == requested_model(FitRequest(), paddling=False)


def test_the_command_in_the_provenance_is_what_was_typed():
    defaults = {"controller": "PD", "seed": 0, "spontaneous": False}
    asked = {
        "mapping": "demo/mapping.toml", "controller": "P", "fix": ["damping=69 1/s", "initial_yaw=0"], "bound": None,
        "seed": 0, "compare": False, "spontaneous": True, "parameters": "drosophila_hydei",
    }  # fmt: skip
    typed = shlex.split(typed_command(["demo/a.csv", "my flies/b.csv"], asked, defaults))
    assert typed == [
        "flycontrol", "fit", "demo/a.csv", "my flies/b.csv", "--mapping", "demo/mapping.toml", "--controller", "P",
        "--fix", "damping=69 1/s", "--fix", "initial_yaw=0", "--no-compare", "--spontaneous",
        "--parameters", "drosophila_hydei",
    ]  # fmt: skip


def test_the_command_names_one_file_of_many_and_no_machine():
    files = [f"/home/someone/flies/{k}.csv" for k in range(20)]
    assert typed_command(files, {}, {}) == "flycontrol fit flies/0.csv ... flies/19.csv (20 files)"
