"""One core and one thread for everybody; the table of all rows at the end, kept under reports/bench."""

import json
import os
import platform
from pathlib import Path

import pytest

THREADS = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS"), "1")
os.environ.update(THREADS)  # before numpy is imported; subprocesses inherit them

import scoreboard  # noqa: E402

ROWS = pytest.StashKey[list]()
FOLDER = Path(__file__).resolve().parents[1] / "reports" / "bench"
FOOTNOTE = """
Every tool ran on the same single core in the same run, in one thread. Times are CPU times, which on a quiet machine are
wall times; commands show both. Setup precedes the first run and can be kept (compiling, building the loop); median and
least are of repeated runs after warm-up, without the garbage collector. For each use of a peer: its fastest setting
within each level of error. The last column is a time over that of flycontrol's first row of the job, whose error is
below every level, so that a row at a coarser error flatters the peer. Roots and charts are timed from the loop's
constants to the answer.
"""


def pytest_configure(config):
    config.stash[ROWS] = []
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})


@pytest.fixture
def rows(request):
    return request.config.stash[ROWS]


def pytest_terminal_summary(terminalreporter, config):
    rows = config.stash[ROWS]
    if rows:
        table = scoreboard.as_markdown(rows)
        terminalreporter.section("speed, with peers in the same run")
        terminalreporter.write(table + FOOTNOTE)
        FOLDER.mkdir(parents=True, exist_ok=True)
        machine = {"python": platform.python_version(), "processor": _processor(), "load": os.getloadavg()}
        place = f"{_processor()}, {os.cpu_count()} cores, load {machine['load'][2]:.0f}, Python {machine['python']}."
        (FOLDER / "table.md").write_text(f"# Speed\n\n{place}\n\n{table}{FOOTNOTE}")
        (FOLDER / "bench.json").write_text(json.dumps({"machine": machine, "rows": scoreboard.as_json(rows)}, indent=1))


def _processor():
    info = Path("/proc/cpuinfo")
    models = [line for line in info.read_text().splitlines() if line.startswith("model name")] if info.exists() else []
    return models[0].split(":")[1].strip() if models else platform.machine()
