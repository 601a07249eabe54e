"""What the analyses do with their one argument, and without measurements: a sentence and status 2."""

import os
import subprocess
import sys

import pytest
from lab_note import ANALYSES

BY_HAND = sorted(path.name for path in ANALYSES.glob("[a-z]*.py"))


def run(name, *arguments, data=None):
    environment = os.environ | ({"FLYCONTROL_DATA": str(data)} if data else {})
    return subprocess.run(
        [sys.executable, str(ANALYSES / name), *map(str, arguments)],
        check=False,
        capture_output=True,
        text=True,
        env=environment,
    )


@pytest.mark.slow
@pytest.mark.parametrize("name", BY_HAND)
def test_help_shows_the_question_and_writes_nothing(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    shown = run(name, "--help")
    assert shown.returncode == 0
    assert (ANALYSES / name).read_text(encoding="utf-8").split("\n")[0].strip('"') in shown.stdout
    assert list(tmp_path.iterdir()) == []


def test_an_option_that_is_none_is_refused(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    refused = run("late_but_in_time.py", "--fast")
    assert (refused.returncode, list(tmp_path.iterdir())) == (2, [])
    assert "--fast" in refused.stderr


def test_a_file_is_no_folder_for_results(tmp_path):
    (tmp_path / "a").write_text("mine")
    refused = run("late_but_in_time.py", tmp_path / "a")
    assert (refused.returncode, refused.stdout) == (2, "")
    assert refused.stderr == f"{tmp_path / 'a'} is a file; name a folder for the results.\n"
    assert (tmp_path / "a").read_text() == "mine"


@pytest.mark.parametrize("name", ["conventions_of_another_tracker.py", "hinge_as_a_spring.py", "replayed_flights.py"])
def test_without_measurements_one_sentence_says_what_is_missing_where(name, tmp_path):
    results = () if name.startswith("conventions") else (tmp_path / "results",)
    refused = run(name, *results, data=tmp_path)
    assert (refused.returncode, refused.stdout, list(tmp_path.iterdir())) == (2, "", [])
    assert refused.stderr.startswith("There is no ")
    assert f" in {tmp_path}; set FLYCONTROL_DATA to the folder of measurements that holds it.\n" in refused.stderr


@pytest.mark.parametrize("place", ["picture.png", "none/picture.svg"])
def test_a_figure_that_cannot_be_written_is_refused_at_once(place, tmp_path):
    refused = run("conventions_of_a_recording.py", tmp_path / place)
    assert (refused.returncode, refused.stdout) == (2, "")
    assert refused.stderr == (
        f"{tmp_path / place} is no place for a figure; name a file that ends in .svg in a folder that exists.\n"
    )
