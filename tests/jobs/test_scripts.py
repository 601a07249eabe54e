"""Scripts as processes: each once, what finished is kept, what fails hinders nobody."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from test_killed import is_alive, wait_until

from flycontrol.errors import InvalidParameterError, OutputError
from flycontrol.jobs.digest import digest_of, files_below
from flycontrol.jobs.folder_lock import locked_folder
from flycontrol.jobs.scripts import Script, run_scripts

ROOT = Path(__file__).parents[2]
WRITE = """
import os, sys, pathlib
with open({log!r}, "a") as log: log.write({name!r} + "\\n")
pathlib.Path(sys.argv[1], {name!r} + ".txt").write_text(os.environ["OMP_NUM_THREADS"])
"""


@pytest.fixture
def make(tmp_path):
    """A script by name and text; `runs` counts how often each was run."""
    log = tmp_path / "log"

    def script(name, after="", identity="1"):
        path = tmp_path / f"{name}.py"
        path.write_text(WRITE.format(log=str(log), name=name) + after)
        return Script(path, tmp_path / "reports" / name, identity)

    script.runs = lambda: log.read_text().split() if log.exists() else []
    return script


def test_a_finished_script_is_not_run_again_and_a_failing_one_is(make, tmp_path):
    good, bad = make("good"), make("bad", "print('first', file=sys.stderr)\nraise ValueError('no water')")
    for _ in range(2):
        ends = run_scripts([good, bad], tmp_path / "kept", at_once=2)
        assert [end.failure for end in ends] == ["", "ValueError: no water"]
    assert sorted(make.runs()) == ["bad", "bad", "good"]
    assert ends[0].kept
    assert (good.folder / "good.txt").read_text() == "1"  # one thread
    assert not bad.folder.exists()  # nothing half-written
    assert sorted(path.name for path in (tmp_path / "kept").iterdir()) == ["bad.log", "good.json"]
    assert (tmp_path / "kept" / "bad.log").read_text().startswith("first\nTraceback")


@pytest.mark.parametrize("change", ["identity", "result", "note"])
def test_a_script_is_run_again_if_it_its_result_or_the_note_about_it_changed(make, tmp_path, change):
    run_scripts([make("one")], tmp_path / "kept")
    if change == "result":
        (tmp_path / "reports" / "one" / "one.txt").write_text("by hand")
    if change == "note":
        (tmp_path / "kept" / "one.json").write_text('{"identity": "1", "results"')
    (end,) = run_scripts([make("one", identity="2" if change == "identity" else "1")], tmp_path / "kept")
    assert not end.kept
    assert make.runs() == ["one", "one"]
    assert (tmp_path / "reports" / "one" / "one.txt").read_text() == "1"


def test_how_a_script_ended_is_said_in_its_own_last_line_or_in_words(make, tmp_path):
    scripts = [
        make("dumb", "sys.exit(7)"),
        make("killed", f"os.kill(os.getpid(), {int(signal.SIGKILL)})"),
        make("idle", f"os.unlink(pathlib.Path(sys.argv[1], {'idle'!r} + '.txt'))"),
    ]
    ends = run_scripts(scripts, tmp_path / "kept")
    assert [end.failure for end in ends] == [
        "it ended with status 7", "it was killed by signal 9", "it wrote no results",
    ]  # fmt: skip


def test_an_interruption_ends_what_is_at_work_and_keeps_what_is_finished(make, tmp_path):
    quick, slow = make("quick"), make("slow", "import time; time.sleep(600)")

    def interrupt(done, total, what):
        assert total == 2
        if done == 1:
            assert what == "slow"
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run_scripts([quick, slow], tmp_path / "kept", at_once=2, progress=interrupt)
    assert [path.name for path in (tmp_path / "kept").iterdir()] == ["quick.json"]
    ends = run_scripts([quick, make("slow", identity="2")], tmp_path / "kept")
    assert [end.kept for end in ends] == [True, False]
    assert make.runs().count("quick") == 1


def test_a_run_killed_in_the_middle_goes_on_where_it_was(make, tmp_path):
    gate = tmp_path / "gate"
    wait = f"import time\nwhile not os.path.exists({str(gate)!r}): time.sleep(0.02)"
    scripts = [make("first"), make("second", wait), make("third")]
    job = tmp_path / "job.py"
    job.write_text(
        "from pathlib import Path\nfrom flycontrol.jobs.scripts import Script, run_scripts\n"
        f"run_scripts([Script(Path(p), Path(f), '1') for p, f in {[(str(s.path), str(s.folder)) for s in scripts]!r}], "
        f"Path({str(tmp_path / 'kept')!r}))\n"
    )
    paths = os.pathsep.join([str(ROOT), os.environ.get("PYTHONPATH", "")])
    process = subprocess.Popen([sys.executable, str(job)], env=os.environ | {"PYTHONPATH": paths})
    deadline = time.monotonic() + 60
    while make.runs() != ["first", "second"]:
        assert time.monotonic() < deadline
        time.sleep(0.02)
    process.kill()
    process.wait()
    gate.touch()  # the orphan ends too
    ends = run_scripts(scripts, tmp_path / "kept")
    assert [end.kept for end in ends] == [True, False, False]
    assert make.runs() == ["first", "second", "second", "third"]


def test_two_runs_do_not_share_a_folder_and_two_scripts_no_name(make, tmp_path):
    with locked_folder(tmp_path / "kept"), pytest.raises(OutputError, match="in use by another process"):
        run_scripts([make("one")], tmp_path / "kept")
    with pytest.raises(InvalidParameterError, match="different names"):
        run_scripts([make("one"), make("one")], tmp_path / "kept")
    assert make.runs() == []


def test_one_hash_of_many_files_sees_names_and_bytes_and_no_caches(tmp_path):
    for name in ("a.py", "b/c.py", "__pycache__/a.pyc", ".hidden"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(name)
    files = files_below(tmp_path)
    assert sorted(files) == ["a.py", "b/c.py"]
    same = digest_of(dict(reversed(files.items())))
    assert same == digest_of(files)
    assert digest_of({"a.py": files["a.py"], "b/d.py": files["b/c.py"]}) != same
    (tmp_path / "a.py").write_text("changed")
    assert digest_of(files) != same


KILLED = """
import sys
from pathlib import Path
from flycontrol.jobs.scripts import Script, run_scripts
folder = Path(sys.argv[1])
run_scripts([Script(folder / "long.py", folder / "reports", "1")], folder / "kept")
"""
LONG = """
import os, subprocess, sys, time
own = subprocess.Popen([sys.executable, "-c", "import time; time.sleep(60)"])
with open({pids!r} + ".part", "w") as file: file.write(f"{{os.getpid()}} {{own.pid}}")
os.rename({pids!r} + ".part", {pids!r})
time.sleep(60)
"""


@pytest.mark.parametrize("end", [signal.SIGKILL, signal.SIGTERM])
def test_no_script_goes_on_for_nobody(tmp_path, end):
    pids = tmp_path / "pids"
    (tmp_path / "long.py").write_text(LONG.format(pids=str(pids)))
    paths = os.pathsep.join([str(ROOT), os.environ.get("PYTHONPATH", "")])
    asking = subprocess.Popen([sys.executable, "-c", KILLED, tmp_path], env={**os.environ, "PYTHONPATH": paths})
    wait_until(pids.exists)
    asking.send_signal(end)
    assert asking.wait(30) == -end
    wait_until(lambda: not any(is_alive(int(pid)) for pid in pids.read_text().split()))
