"""Scripts as processes: each once, what finished is kept, what fails hinders nobody."""

import hashlib
import json
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
from flycontrol.jobs.said import END
from flycontrol.jobs.scripts import Script, forget_other_scripts, run_scripts

ROOT = Path(__file__).parents[2]
FLOOD = 200_000  # lines
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


def test_the_end_of_what_a_script_printed_is_kept_even_if_it_hangs(make, tmp_path):
    scripts = [
        make("status", "print('no fly in the box'); sys.exit(3)"),
        make("dumb", "sys.exit(7)"),
        make("flood", f"sys.stdout.write('a flood\\n' * {FLOOD}); print('the end'); sys.exit(1)"),
    ]
    hangs = make("hangs", "print('half way'); print('slowly', file=sys.stderr); import time; time.sleep(600)")
    ends = [*run_scripts(scripts, tmp_path / "kept", at_once=3), *run_scripts([hangs], tmp_path / "kept", limit=4.0)]
    assert [end.failure for end in ends] == [
        "it ended with status 3", "it ended with status 7", "it ended with status 1", "it was ended after 4 s",
    ]  # fmt: skip
    logs = {name: (tmp_path / "kept" / f"{name}.log").read_text() for name in ("status", "hangs", "dumb", "flood")}
    assert logs["status"] == "no fly in the box\n"
    assert sorted(logs["hangs"].split("\n")) == ["", "half way", "slowly"]
    assert logs["dumb"] == "It said nothing: it ended with status 7.\n"
    head, _, flood = logs["flood"].partition("\n")
    assert head == f"[{8 * FLOOD + len('the end') + 1 - END} bytes before these are left out]"
    assert len(flood) == END
    assert flood.endswith("a flood\nthe end\n")


def test_a_script_that_reads_finds_an_empty_input(make, tmp_path):
    (end,) = run_scripts(
        [make("asks", "assert sys.stdin.read() == ''\nassert os.read(0, 1) == b''")], tmp_path / "kept"
    )
    assert end.failure == ""


def test_a_script_that_fails_now_leaves_no_results_of_before_but_those_that_somebody_changed(make, tmp_path):
    below = "\nos.mkdir(sys.argv[1] + '/below'); open(sys.argv[1] + '/below/old.txt', 'w')"
    once = make("once", below)
    run_scripts([once, make("other")], tmp_path / "kept")
    (once.folder / "mine.txt").write_text("by hand")
    run_scripts([make("once", "raise ValueError('no more')", "2")], tmp_path / "kept")
    assert [path.name for path in once.folder.rglob("*")] == ["mine.txt"]
    assert (tmp_path / "reports" / "other" / "other.txt").exists()
    again = make("once", identity="3")
    run_scripts([again], tmp_path / "kept")
    (again.folder / "once.txt").write_text("changed by hand")
    run_scripts([make("once", "sys.exit(1)", "4")], tmp_path / "kept")
    assert (again.folder / "once.txt").read_text() == "changed by hand"


def test_what_scripts_that_are_no_more_left_is_removed_and_nothing_else(make, tmp_path):
    kept, reports = tmp_path / "kept", tmp_path / "reports"
    run_scripts([make("gone"), make("here"), make("changed")], kept)
    (reports / "changed" / "changed.txt").write_text("by hand")
    (reports / "mine").mkdir()
    (reports / "mine" / "mine.txt").write_text("by hand")
    note = {"results": {"../here/here.txt": hashlib.sha256(b"1").hexdigest()}}
    (kept / "mine.json").write_text(json.dumps(note))
    forget_other_scripts(kept, {"here"}, reports)
    left = sorted(path.relative_to(reports).as_posix() for path in reports.rglob("*"))
    assert left == ["changed", "changed/changed.txt", "here", "here/here.txt", "mine", "mine/mine.txt"]
    assert not (kept / "gone.json").exists()
    (end,) = run_scripts([make("here")], kept)
    assert end.kept


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
