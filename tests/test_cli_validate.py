"""`flycontrol validate` on tiny analyses made up here; the real ones are run by tests/systems."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from command_line import exit_status

ROOT = Path(__file__).parents[1]
STATES = '''"""Is {name} so?"""
import json, os, pathlib, sys, time
with open({log!r}, "a") as log: log.write({name!r} + "\\n")
{wait}
claim = {{"claim": "{name} is so", "published": "1", "ours": os.environ.get("FLYCONTROL_DATA", "no data")[-8:],
         "agreement": {agreement!r}, "where": "section 4, Fig. 5c"}}
folder = pathlib.Path(sys.argv[1])
(folder / "{name}.json").write_text(json.dumps({{"claims": [claim]}}))
(folder / "{name}.md").write_text("# {name}")
'''


class Place:
    """Analyses in a folder, and the command run beside it."""

    def __init__(self, folder, monkeypatch, capsys):
        self.folder, self.log = folder, folder / "log"
        self._patch, self._captured = monkeypatch, capsys
        (folder / "analyses").mkdir()

    def analysis(self, name, agreement="agrees", wait=""):
        text = STATES.format(name=name, agreement=agreement, wait=wait, log=str(self.log))
        (self.folder / "analyses" / f"{name}.py").write_text(text)

    def start(self, *options):
        paths = os.pathsep.join([str(ROOT), os.environ.get("PYTHONPATH", "")])
        environment = {key: value for key, value in os.environ.items() if key != "FLYCONTROL_DATA"}
        return subprocess.Popen(
            [sys.executable, "-m", "flycontrol", "validate", *map(str, options)], cwd=self.folder, text=True,
            stdout=subprocess.PIPE, stderr=subprocess.PIPE, env=environment | {"PYTHONPATH": paths},
            preexec_fn=heed_ctrl_c,  # noqa: PLW1509 (no threads run in a test)
        )  # fmt: skip

    def run(self, *options):
        """In this process, which has loaded the package: exit status, standard error."""
        self._patch.chdir(self.folder)
        self._patch.delenv("FLYCONTROL_DATA", raising=False)
        return exit_status("validate", *options), self._captured.readouterr().err

    @property
    def runs(self):
        return sorted(self.log.read_text().split()) if self.log.exists() else []


def heed_ctrl_c():
    """A shell's background jobs, and what they start, ignore it."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


@pytest.fixture
def place(tmp_path, monkeypatch, capsys):
    return Place(tmp_path, monkeypatch, capsys)


def test_every_claim_stands_on_the_page_and_in_the_result_and_a_second_run_runs_nothing(place):
    place.analysis("one")
    place.analysis("two", "fails: by far")
    (place.folder / "measured" / "flights").mkdir(parents=True)
    (place.folder / "measured" / "flights" / "a.txt").write_text("1")
    for _ in range(2):
        status, said = place.run("--out", "page", "--data", "measured", "--reports", "own")
        assert status == 0, said
    assert place.runs == ["one", "two"]
    assert "0 of them run now" in said
    found = json.loads((place.folder / "page" / "result.json").read_text())
    rows = {row["analysis"]: row for row in found["claims"]}
    assert {name: row["verdict"] for name, row in rows.items()} == {"one": "agrees", "two": "fails"}
    assert rows["one"]["ours"] == "measured"
    assert found["data"]["folders"] == ["flights"]
    assert found["analyses"][0]["question"] == "Is one so?"
    for row in found["claims"]:
        assert (place.folder / "page" / row["link"]).resolve() == place.folder / "own" / row["analysis"] / (
            f"{row['analysis']}.md"
        )
        assert row["link"] in (place.folder / "page" / "index.html").read_text()
    (place.folder / "measured" / "flights" / "a.txt").write_text("2")  # other data: other findings
    place.run("--out", "page", "--data", "measured", "--reports", "own", "--workers", "1")
    assert place.runs == ["one", "one", "two", "two"]


def test_an_analysis_that_fails_has_its_row_and_ends_the_command_with_status_1(place):
    place.analysis("good")
    place.analysis("vague", "it depends")
    (place.folder / "analyses" / "lost.py").write_text('raise SystemExit("The data are not there.")')
    status, said = place.run("--out", "page")
    assert status == 1
    assert "lost gave no result: The data are not there." in said
    assert "vague gave no result: vague.json, claim 1: agreement begins with one of" in said
    page = (place.folder / "page" / "index.html").read_text()
    assert "<b>no result:</b> The data are not there." in page
    assert "Real measurements were not there" in page
    assert "good is so" in page
    (place.folder / "analyses" / "lost.py").unlink()
    place.analysis("vague", "roughly")
    assert place.run("--out", "page")[0] == 0
    assert place.runs == ["good", "vague", "vague"]


@pytest.mark.parametrize("how", [signal.SIGINT, pytest.param(signal.SIGKILL, marks=pytest.mark.slow)])
def test_an_interrupted_run_keeps_what_is_finished_and_goes_on(place, how):
    gate = place.folder / "gate"
    place.analysis("first")
    place.analysis("second", wait=f"while not os.path.exists({str(gate)!r}): time.sleep(0.02)")
    process, deadline = place.start("--out", "page", "--workers", "1"), time.monotonic() + 60
    while place.runs != ["first", "second"]:
        assert time.monotonic() < deadline
        time.sleep(0.02)
    process.send_signal(how)
    _, said = process.communicate(timeout=60)
    if how == signal.SIGINT:
        assert process.returncode == 130
        assert "finished analyses are kept" in said
        assert "Traceback" not in said
    assert not (place.folder / "page" / "index.html").exists()
    gate.touch()
    status, said = place.run("--out", "page", "--workers", "1")
    assert status == 0
    assert "from 2 analyses, 1 of them run now" in said
    assert place.runs == ["first", "second", "second"]
    assert sorted(path.name for path in (place.folder / "page" / "kept").iterdir()) == ["first.json", "second.json"]


def test_what_a_failed_analysis_said_is_kept_and_its_message_is_whole(place):
    (place.folder / "analyses" / "lost.py").write_text('def f():\n    raise ValueError("one\\ntwo")\nf()')
    (place.folder / "analyses" / "torn.py").write_text("def")
    place.analysis("elsewhere", wait="json.dump({'claims': []}, open(sys.argv[1] + '/other.json', 'w'))")
    place.analysis("slow", wait="time.sleep(60)")
    status, said = place.run("--out", "page", "--limit", "0.1")
    assert status == 1
    assert "lost gave no result: ValueError: one two\n" in said
    assert "torn gave no result: SyntaxError: invalid syntax" in said
    assert "elsewhere gave no result: other.json holds claims, which are read from elsewhere.json alone" in said
    assert "slow gave no result: it was ended after 6 s" in said
    assert 'raise ValueError("one' in (place.folder / "page" / "kept" / "lost.log").read_text()
    assert f"is in {Path('page', 'kept')}: lost.log, slow.log, torn.log\n" in said


def test_the_page_names_no_place_and_the_command_line_the_real_one(place):
    asks = "import os, sys\ndata = os.environ['FLYCONTROL_DATA']\n"
    lost = asks + "sys.exit(f'There is no box in {data}; look in {data}/a.')"
    (place.folder / "analyses" / "lost.py").write_text(lost)
    (place.folder / "measured").mkdir()
    status, said = place.run("--out", "page", "--data", "measured")
    data = place.folder / "measured"
    assert status == 1
    assert f"lost gave no result: There is no box in {data}; look in {data}/a.\n" in said
    page = (place.folder / "page" / "index.html").read_text()
    assert "There is no box in the folder of real measurements; look in FLYCONTROL_DATA/a." in page
    assert str(place.folder) not in page


def test_old_results_of_analyses_that_fail_or_are_no_more_go_and_what_lies_there_otherwise_is_told(place):
    for name in ("breaks", "gone", "later"):
        place.analysis(name)
    assert place.run("--out", "page")[0] == 0
    (place.folder / "page" / "breaks" / "mine.txt").write_text("by hand")
    (place.folder / "analyses" / "breaks.py").write_text("raise SystemExit('broken')")
    (place.folder / "analyses" / "gone.py").unlink()
    (place.folder / "analyses" / "validation.toml").write_text('[left_out]\nlater = "too long"\n')
    place.analysis("new")
    status, said = place.run("--out", "page")
    assert status == 1
    files = {path.relative_to(place.folder / "page").as_posix() for path in (place.folder / "page").rglob("*.*")}
    assert {file for file in files if not file.startswith("kept/")} == {
        "index.html", "result.json", "breaks/mine.txt", "later/later.json", "later/later.md",
        "new/new.json", "new/new.md",
    }  # fmt: skip
    assert "breaks gave no result: broken\n" in said
    page = (place.folder / "page" / "index.html").read_text()
    assert "broken (What lies in its folder is not of this run.)" in page


def test_a_changed_file_beside_the_analyses_makes_them_run_again_and_old_results_go(place):
    (place.folder / "analyses" / "table.csv").write_text("1")
    place.analysis("one", wait="pathlib.Path(sys.argv[1], 'old.txt').write_text('1')")
    place.run("--out", "page")
    (place.folder / "analyses" / "table.csv").write_text("2")
    place.run("--out", "page")
    assert place.runs == ["one", "one"]
    assert (place.folder / "page" / "one" / "old.txt").exists()
    place.analysis("one")
    place.run("--out", "page")
    assert sorted(path.name for path in (place.folder / "page" / "one").iterdir()) == ["one.json", "one.md"]


def test_missing_folders_are_refused_in_a_sentence_and_nothing_is_written(place):
    place.analysis("one")
    for options, sentence in [
        (("--analyses", "nowhere"), "nowhere: there is no such folder of analyses; run the command where"),
        (("--data", "nowhere"), "nowhere is no folder; name that of the real measurements"),
        (("--out", "log.txt/page"), "is not a folder"),
    ]:
        (place.folder / "log.txt").touch()
        status, said = place.run("--out", "page", *options)
        assert status == 2
        assert sentence in said
        assert len(said.splitlines()) == 1
    assert not (place.folder / "page").exists()
    assert place.runs == []
