"""Speed against named peers at measured errors. Times are reported, never asserted; errors are."""

import json
import math
import os
import subprocess
import sys
import time
from importlib.metadata import version
from pathlib import Path

import loops
import numpy as np
import problems
import pytest
from scoreboard import Row, against

HERE = Path(__file__).parent
sys.path.append(str(HERE / "peers"))
import stopwatch  # noqa: E402 (the errors of flycontrol and of peers come out of the same functions)

FLYCONTROL = Path(sys.executable).with_name("flycontrol")
US = f"flycontrol {version('flycontrol')}"

# what a peer's most accurate setting reaches when it is used well: a larger error means that the bench wrongs the peer
STATED = {
    "jitcdde_response": 1e-8, "control_response": 5e-3, "scipy_response": 1e-9, "ddeint_response": 1.0,
    "control_roots": 1e-10, "tdcpy_roots": 1e-9, "qpmr_roots": 1e-10, "control_chart": 1, "tdcpy_chart": 1,
    "numpy_hull": 1, "c_wing": 1e-6, "mujoco_wing": 0.06,  # rad that wings are off the stroke
    "jitcdde_fit": 1e-2, "control_fit": 0.1, "lmfit_fit": 1e4,  # lmfit's defaults are shown as they end
}  # fmt: skip


def run_peer(peer, problem, ours, folder):
    """Rows of a peer measured in a process of its own, or one row that says why there are none.

    In an empty folder, since JiTCDDE calls setuptools, which would read a pyproject.toml beside it.
    """
    try:
        done = subprocess.run(
            [sys.executable, HERE / "peers" / f"{peer}.py"],
            input=json.dumps(problem), capture_output=True, text=True, timeout=1200, check=False, cwd=folder,
        )  # fmt: skip
    except subprocess.TimeoutExpired:
        return [Row(job=ours.job, tool=peer.split("_")[0], not_run="no answer within 20 minutes")]
    if done.returncode:
        reason = (done.stderr.strip().splitlines() or [f"exit status {done.returncode}"])[-1]
        return [Row(job=ours.job, tool=peer.split("_")[0], not_run=reason)]
    answer = json.loads(done.stdout)
    best = min((row["error"] for row in answer["rows"] if row["error"] is not None), default=math.inf)
    assert best < STATED[peer], f"{peer} was not used as well as it can be: error {best:.1e}"
    return list(against(ours, f"{answer['tool']} {answer['version']}", answer["rows"]))


def first_call_in_a_new_process(problem, cache):
    done = subprocess.run(
        [sys.executable, HERE / "first_call.py"], input=json.dumps(problem), capture_output=True, text=True, check=True,
        env=os.environ | {"NUMBA_CACHE_DIR": str(cache)},
    )  # fmt: skip
    return json.loads(done.stdout)


@pytest.mark.benchmark(disable_gc=True, warmup=True)
def test_the_response_of_one_recovery_is_exact_to_a_billionth_of_a_degree(benchmark, rows, tmp_path):
    problem = problems.recovery()
    compiling = first_call_in_a_new_process(problem, tmp_path)["first_call_s"]
    cached = first_call_in_a_new_process(problem, tmp_path)["first_call_s"]
    system, times = loops.closed_loop(problem["loop"]), np.array(problem["times"])
    angles = benchmark(loops.recover, problem, system, times)
    error = stopwatch.angle_error(problem, angles)
    ours = Row(
        job="response of one recovery", tool=US, setting=f"kernels from the cache; first compiled in {compiling:.3g} s",
        setup_s=cached, run_s=benchmark.stats.stats.median, best_s=benchmark.stats.stats.min, error=error, unit="deg",
    )  # fmt: skip
    rows.append(ours)
    for peer in ("jitcdde_response", "control_response", "scipy_response", "ddeint_response"):
        rows.extend(run_peer(peer, problem, ours, tmp_path))
    assert error < 1e-9


def own_row(job, setting, timing, **more):
    return Row(job=job, tool=US, setting=setting, run_s=timing["run_s"], best_s=timing["best_s"], **more)


@pytest.mark.benchmark(disable_gc=True, warmup=True)
@pytest.mark.parametrize("name", ["benchmark loop", "nominal loop"])
def test_rightmost_roots_are_exact_to_twelve_digits(benchmark, rows, tmp_path, name):
    problem = problems.roots(name)
    job = f"rightmost roots, {name}"
    found = benchmark(loops.roots, problem["loop"], 3, certify=False)
    error = stopwatch.root_error(problem, found.roots)
    ours = Row(
        job=job, tool=US, setting="3 roots, error of each estimated",
        run_s=benchmark.stats.stats.median, best_s=benchmark.stats.stats.min, error=error, unit="relative",
    )  # fmt: skip
    certified = loops.roots(problem["loop"], 3, certify=True)
    timing = stopwatch.timed(lambda: loops.roots(problem["loop"], 3, certify=True))
    error_certified = stopwatch.root_error(problem, certified.roots)
    rows.append(ours)
    rows.append(
        own_row(
            job,
            "and certified: no other root right of a line",
            timing,
            error=error_certified,
            unit="relative",
            ratio=timing["run_s"] / ours.run_s,
            ratio_of_best=timing["best_s"] / ours.best_s,
        )
    )
    for peer in ("control_roots", "tdcpy_roots", "qpmr_roots"):
        rows.extend(run_peer(peer, problem, ours, tmp_path))
    assert max(error, error_certified) < 1e-12
    assert certified.status == "certified"


@pytest.mark.benchmark(disable_gc=True, warmup=True)
def test_the_stability_chart_of_400_gains_has_the_verdicts_of_the_closed_form(benchmark, rows, tmp_path):
    problem, job = problems.chart(), "stability chart, 400 points"
    stable = benchmark(loops.chart, problem, loops.as_blocks, batched=True)
    ours = Row(
        job=job, tool=US, setting="blocks of a row of points a call", unit="wrong verdicts",
        run_s=benchmark.stats.stats.median, best_s=benchmark.stats.stats.min,
        error=stopwatch.wrong_verdicts(problem, stable),
    )  # fmt: skip
    rows.append(ours)
    for setting, system_at in (("blocks of a point a call", loops.as_blocks), ("a DelayLTI a point", loops.as_systems)):
        wrong = stopwatch.wrong_verdicts(problem, loops.chart(problem, system_at))
        timing = stopwatch.timed(lambda system_at=system_at: loops.chart(problem, system_at))
        ratios = {"ratio": timing["run_s"] / ours.run_s, "ratio_of_best": timing["best_s"] / ours.best_s}
        rows.append(own_row(job, setting, timing, error=wrong, unit="wrong verdicts", **ratios))
    for peer in ("control_chart", "tdcpy_chart"):
        rows.extend(run_peer(peer, problem, ours, tmp_path))
    assert all(row.error == 0 for row in rows if row.job == job and not row.not_run)
    assert 50 < sum(problem["stable"]) < 350


@pytest.mark.benchmark(disable_gc=True, warmup=True)
@pytest.mark.parametrize("order", [1, 3])
def test_a_lyapunov_krasovskii_functional_proves_the_benchmark_loop_stable(benchmark, rows, order):
    proof = benchmark(loops.proof, problems.BENCHMARK, order)
    stats = benchmark.stats.stats
    rows.append(
        own_row(
            "proof of stability, benchmark loop",
            f"order {order}, matrices checked afterwards",
            {"run_s": stats.median, "best_s": stats.min},
        )
    )
    assert proof.proved


class Command:
    """A command in new processes: wall and CPU time of each."""

    def __init__(self, *arguments, **environment):
        self.arguments, self.environment = [str(FLYCONTROL), *map(str, arguments)], os.environ | environment
        self.wall, self.cpu = [], []

    def __call__(self):
        began = time.perf_counter()
        process = subprocess.Popen(
            self.arguments, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, env=self.environment
        )
        complaint = process.stderr.read().decode()
        _, status, used = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        self.wall.append(time.perf_counter() - began)
        self.cpu.append(used.ru_utime + used.ru_stime)
        process.stderr.close()
        assert process.returncode == 0, complaint

    def row(self, setting):
        best = min(self.wall)
        return Row(
            job=" ".join(["flycontrol", self.arguments[1]]), tool=US, setting=setting,
            run_s=float(np.median(self.wall)), cpu_s=float(np.median(self.cpu)), best_s=best,
        )  # fmt: skip


def test_the_command_answers_help(benchmark, rows):
    command = Command("--help")
    benchmark.pedantic(command, rounds=15, warmup_rounds=1)
    rows.append(command.row("new process"))


def test_the_report_is_written_from_a_cold_start(benchmark, rows, tmp_path):
    first = Command("report", "--out", tmp_path / "first", NUMBA_CACHE_DIR=str(tmp_path / "cache"))
    first()
    command = Command("report", "--out", tmp_path / "report", NUMBA_CACHE_DIR=str(tmp_path / "cache"))
    benchmark.pedantic(command, rounds=3)
    rows.append(command.row("new process, kernels in the cache"))
    rows.append(first.row("first run on a machine: kernels compile"))
    assert (tmp_path / "report" / "index.html").stat().st_size > 0
