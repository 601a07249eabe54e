import sys
from functools import partial
from types import ModuleType

import numpy as np
import pytest

from flycontrol.io.parameters import read_parameters

FLIGHT = "muijres_freeflight/20121128_S0003.txt"


@pytest.fixture
def report(command):
    """Run `flycontrol report`: exit status, standard output, standard error."""
    return partial(command, "report")


@pytest.fixture
def refused(report, tmp_path):
    """Run what must be refused before any work: status 2, one sentence, nothing written; return the sentence."""

    def run(*arguments):
        before = sorted(tmp_path.rglob("*"))
        status, _, sentence = report(*arguments)
        assert status == 2
        assert sentence.count("\n") == 1
        assert sorted(tmp_path.rglob("*")) == before
        return sentence

    return run


@pytest.fixture
def written_reports(monkeypatch):
    """Catch what the command hands to the page instead of computing it."""
    caught = []
    page = ModuleType("flycontrol.report.page")

    def write_report(parameters, analysis, folder, *, command, progress):
        progress(1, 2, "roots")
        caught.append((parameters, analysis, folder, command))

    page.write_report = write_report
    monkeypatch.setitem(sys.modules, "flycontrol.report.page", page)
    return caught


def test_the_published_fly_is_reported_by_default(report, written_reports, tmp_path):
    status, _, log = report("--out", tmp_path / "new")
    assert status == 0
    assert written_reports == [(read_parameters(), None, tmp_path / "new", "flycontrol report")]
    assert "index.html" in log


def test_parameters_and_a_real_flight_reach_the_report(report, written_reports, tmp_path, real_data):
    fly = tmp_path / "fly.toml"
    fly.write_text('[controller]\ndelay = "12 ms"')
    status, _, _ = report(
        *("--parameters", fly, "--recording", real_data / FLIGHT, "--mapping", "muijres_freeflight", "--out", tmp_path)
    )
    ((parameters, analysis, _, _),) = written_reports
    assert status == 0
    assert parameters.delay.value == 0.012
    assert analysis.recording.name == "20121128_S0003"


def test_without_a_mapping_the_columns_and_a_mapping_to_edit_are_printed(report, real_data, tmp_path):
    status, printed, sentence = report("--recording", real_data / FLIGHT, "--out", tmp_path)
    assert status == 2
    assert "row 20: 1284 samples" in printed
    assert "[clock]" in printed
    assert sentence.count("\n") == 1
    assert "a shipped mapping fits: if it is such a recording, add --mapping muijres_freeflight" in sentence


def test_a_file_that_no_shipped_mapping_fits_is_described_too(report, tmp_path):
    table = tmp_path / "table.csv"
    table.write_text("t,psi\n" + "\n".join(f"{k / 5000},{np.sin(k / 100)}" for k in range(300)))
    status, printed, sentence = report("--recording", table, "--out", tmp_path / "out")
    assert status == 2
    assert "column 1 'psi': 300 samples" in printed
    assert "edit the mapping printed above" in sentence
    assert "shipped mapping fits" not in sentence


def test_bad_input_is_refused_before_anything_is_written(refused, tmp_path):
    (tmp_path / "file").write_text("x")
    (tmp_path / "fly.toml").write_text("[controller]\ndelay = 13.6")
    out = tmp_path / "out"
    assert "is not a folder" in refused("--out", tmp_path / "file" / "reports")
    assert "is not a folder" in refused("--out", tmp_path / "file")
    assert "without a unit" in refused("--parameters", tmp_path / "fly.toml", "--out", out)
    assert "there is no such file" in refused("--parameters", tmp_path / "absent.toml", "--out", out)
    assert "there is no such file" in refused("--recording", tmp_path / "absent.txt", "--out", out)
    assert "there is no such file" in refused("--recording", "a", "--mapping", tmp_path / "absent.toml", "--out", out)
    assert "--out is empty" in refused("--out", "")
    assert "shipped are fly, drosophila_hydei" in refused("--parameters", "nope", "--out", out)
    assert "shipped are fontaine_takeoff, muijres_freeflight" in refused(
        "--recording", "a", "--mapping", "nope", "--out", out
    )
    assert "name the recording too" in refused("--mapping", "muijres_freeflight", "--out", out)


def test_a_recording_of_the_body_alone_is_refused_by_what_it_lacks(refused, real_data, tmp_path):
    take_off = real_data / "fontaine_takeoff" / "exp035c.csv"
    sentence = refused("--recording", take_off, "--mapping", "fontaine_takeoff", "--out", tmp_path / "out")
    assert "the mapping reads the body's motion alone" in sentence
