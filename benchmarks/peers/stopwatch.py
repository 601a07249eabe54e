"""What every peer program shares: a problem on stdin, medians after warm-up, results as JSON on stdout.

Times are CPU times: every tool runs in one thread, and a busy machine would add its waiting to wall times.
"""

import gc
import json
import math
import statistics
import sys
import time
from importlib.metadata import version

MISSED = 1e-3  # relative distance beyond which a root counts as not found


def timed(call, budget=0.3, fewest=9):
    """Median and least time of a call [s], without the garbage collector, over at least `fewest` repetitions."""
    for _ in range(fewest // 3):
        call()
    gc.collect()
    gc.disable()
    clock, times = time.process_time, []
    stop = clock() + budget
    while len(times) < fewest or (clock() < stop and len(times) < 2000):
        start = clock()
        call()
        times.append(clock() - start)
    gc.enable()
    return {"run_s": statistics.median(times), "best_s": min(times), "repetitions": len(times)}


def angle_error(problem, angles):
    """Largest error of a response [deg]."""
    return math.degrees(max(abs(x - y) for x, y in zip(angles, problem["reference"], strict=True)))


def estimate_error(problem, x):
    """Largest distance of an estimate from the least-squares minimiser [standard errors]."""
    return max(
        abs(float(mine) - best) / error
        for mine, best, error in zip(x, problem["minimiser"], problem["standard_errors"], strict=True)
    )


def root_error(problem, found):
    """Largest relative distance from a wanted root to the nearest one found; infinite if one was missed."""
    worst = 0.0
    for re, im in problem["roots"]:
        z = complex(re, im)
        distance = min((abs(w - z) / abs(z) for w in found), default=math.inf)
        worst = max(worst, distance if distance < MISSED else math.inf)
    return worst


def wrong_verdicts(problem, stable):
    """At how many points of a chart, row by row, the verdict is not that of the reference."""
    return sum(bool(x) != y for x, y in zip(stable, problem["stable"], strict=True))


def main(tool, measure):
    """Measure the problem on stdin; a measurement is a list of dictionaries with use, setting, error, run_s, best_s."""
    write(tool, version(tool), measure(json.load(sys.stdin)))


def write(tool, release, measured):
    rows = []
    for row in measured:
        row["error"] = row["error"] if math.isfinite(row["error"]) else None
        rows.append(row)
    json.dump({"tool": tool, "version": release, "rows": rows}, sys.stdout)
