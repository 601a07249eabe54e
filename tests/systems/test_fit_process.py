"""`flycontrol fit` as a whole process: the same bytes whoever works, killed anywhere, on a disk that is full."""

import os
import resource
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from flycontrol.identify.gains.synthetic import synthetic_experiment
from flycontrol.io.example_files import example_files

ROOT = Path(__file__).parents[2]
OPTIONS = ("--no-compare", "--bootstrap", "60", "--fix", "initial_yaw=0", "--fix", "initial_rate=0")
PAGES = ("index.html", "result.json", "estimates.csv", "table.md")

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def demo(tmp_path_factory):
    """The example's files of two flies."""
    folder, made = tmp_path_factory.mktemp("demo"), synthetic_experiment(0, 2)
    for name, text in example_files(made.trials, made.flies, made.impulses, 0).items():
        (folder / name).write_text(text)
    return folder


def started(demo, *arguments, **settings):
    """The command as its own process group, so that a kill reaches its workers too."""
    paths = os.pathsep.join([str(ROOT), os.environ.get("PYTHONPATH", "")])
    command = [sys.executable, "-m", "flycontrol", "fit", *sorted(demo.glob("*.csv")), "--mapping",
               demo / "mapping.toml", *OPTIONS, *arguments]  # fmt: skip
    return subprocess.Popen(
        list(map(str, command)), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True,
        env=os.environ | {"PYTHONPATH": paths}, **settings,
    )  # fmt: skip


def contents(folder):
    """Bytes of every file by its path in the folder."""
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def finished(process):
    printed, said = process.communicate(timeout=300)
    return process.returncode, printed, said


@pytest.fixture(scope="module")
def whole(demo, tmp_path_factory):
    """The folder of a run that nothing disturbed, and what it printed."""
    out = tmp_path_factory.mktemp("whole")
    status, printed, said = finished(started(demo, "--out", out, "--json", "--workers", "1"))
    assert status == 0, said
    return out, printed


def test_two_workers_write_and_print_the_bytes_that_one_does(demo, whole, tmp_path):
    folder, alone = whole
    status, printed, said = finished(started(demo, "--out", tmp_path, "--json", "--workers", "2"))
    assert status == 0, said
    assert printed == alone
    assert contents(tmp_path) == contents(folder)


@pytest.mark.parametrize("after", ["fits-by-fly", "fly2/bootstrap"])
def test_killed_while_a_part_is_made_it_goes_on_with_finished_chunks_and_ends_with_the_same_bytes(
    demo, whole, tmp_path, after
):
    process = started(demo, "--out", tmp_path, "--workers", "2")
    part = tmp_path / "unfinished" / after
    while process.poll() is None and not any(part.glob("chunk-*")):
        time.sleep(0.005)
    assert process.poll() is None, process.communicate()
    os.killpg(process.pid, signal.SIGKILL)
    process.communicate()
    kept = {path: path.stat().st_mtime_ns for path in tmp_path.glob("unfinished/**/chunk-*")}
    assert kept
    assert not any((tmp_path / name).exists() for name in PAGES)
    again = started(demo, "--out", tmp_path, "--workers", "2")
    touched = set()
    while again.poll() is None:
        touched |= {path for path, then in kept.items() if path.exists() and _modified(path) not in (then, None)}
        time.sleep(0.02)
    status, _, said = finished(again)
    assert status == 0, said
    assert not touched  # no finished chunk was written a second time
    assert contents(tmp_path) == contents(whole[0])  # hence nothing unfinished is left either


def _modified(path):
    try:
        return path.stat().st_mtime_ns
    except FileNotFoundError:
        return None


def test_a_file_that_finds_no_room_ends_in_a_sentence_and_leaves_the_earlier_report(demo, tmp_path):
    for name in PAGES:
        (tmp_path / name).write_text("earlier")
    room = 100_000  # bytes a file may have: chunks fit, the page does not

    def little_room():
        resource.setrlimit(resource.RLIMIT_FSIZE, (room, room))

    process = started(demo, "--out", tmp_path, "--workers", "1", preexec_fn=little_room)
    status, printed, said = finished(process)
    assert status == 2, said
    assert not printed
    assert said.strip().splitlines()[-1].startswith("flycontrol: ")
    assert "Traceback" not in said
    assert {name: (tmp_path / name).read_text() for name in PAGES} == dict.fromkeys(PAGES, "earlier")
    assert not list(tmp_path.glob("*.partial*"))
