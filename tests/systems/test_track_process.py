"""`flycontrol track` as a whole process: killed anywhere, it goes on to the same bytes."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]

pytestmark = pytest.mark.slow


def heed_ctrl_c():
    """A process started in the background of a shell ignores Ctrl-C, and so would its children."""
    signal.signal(signal.SIGINT, signal.default_int_handler)


def started(*arguments):
    paths = os.pathsep.join([str(ROOT), os.environ.get("PYTHONPATH", "")])
    command = [sys.executable, "-m", "flycontrol", "track", "--wingbeats", "3", *arguments]
    return subprocess.Popen(
        list(map(str, command)), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True,
        env=os.environ | {"PYTHONPATH": paths}, preexec_fn=heed_ctrl_c,  # noqa: PLW1509
    )  # fmt: skip


def finished(process):
    said = process.communicate(timeout=600)[1]
    return process.returncode, said


def stopped(process, file, how):
    """Send a signal once a file is there."""
    until = time.monotonic() + 600
    while not file.exists() and process.poll() is None and time.monotonic() < until:
        time.sleep(0.05)
    process.send_signal(how)
    return finished(process)


def contents(folder):
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """The folder of a run that nothing disturbed."""
    out = tmp_path_factory.mktemp("whole") / "out"
    status, said = finished(started("--out", out))
    assert status == 0, said
    return out


@pytest.mark.parametrize("how", [signal.SIGKILL, signal.SIGINT])
def test_a_run_that_was_stopped_goes_on_to_the_same_bytes(whole, tmp_path, how):
    out = tmp_path / "out"
    status, said = stopped(started("--out", out), out / "unfinished" / "chunk-000002.npz", how)
    assert status == (-signal.SIGKILL if how == signal.SIGKILL else 130)
    assert how == signal.SIGKILL or "the same command goes on from there" in said
    assert not (out / "result.json").exists()
    other = started("--out", out, "--hull-only")
    assert finished(other)[0] == 2  # other options do not take what this run has kept
    assert finished(started("--out", out))[0] == 0
    assert contents(out) == contents(whole)
