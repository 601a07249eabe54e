"""The wing level by hand in C, compiled on the spot: the same equations, one fly or flies side by side."""

import ctypes
import json
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import stopwatch

SOURCE = Path(__file__).with_name("wing_kernel.c")
FLAGS = ["-O3", "-march=native", "-ffast-math", "-Wno-psabi", "-shared", "-fPIC"]


def compiled(width, lanes):
    library = Path(f"wing_kernel_{width}_{lanes}.so").resolve()
    began = time.perf_counter()
    sizes = [f"-DWIDTH={width}", f"-DLANES={lanes}"]
    subprocess.run(["cc", *FLAGS, *sizes, SOURCE, "-o", library, "-lm"], check=True)
    return ctypes.CDLL(str(library)).march, time.perf_counter() - began


def at(array):
    return array.ctypes.data_as(ctypes.POINTER(ctypes.c_double))


def flight(problem, march):
    """A function that flies all wingbeats and returns the state at the end."""
    arrays = {name: np.array(problem[name]) for name in ("drive", "step", "gravity", "body", "wings", "blades")}
    polynomials, start = np.array(problem["polynomials"]), np.array(problem["y"])
    steps, samples, lanes = problem["steps"], problem["samples"], problem["lanes"]
    outside, room = np.zeros(steps * 6 * lanes), np.empty(samples * 19 * lanes)
    drive, step, gravity, body, wings, blades = map(at, arrays.values())
    long = ctypes.c_long

    def fly():
        y = start.copy()
        for _ in range(problem["wingbeats"]):
            march(
                at(y), drive, step, at(outside), long(steps), long(steps // samples), gravity, body, wings, blades,
                long(problem["nodes"]), at(polynomials), at(room),
            )  # fmt: skip
        return y

    fly.keeps = (arrays, polynomials, outside, room)
    return fly


def measure(problem):
    lanes, end = problem["lanes"], np.array(problem["end"])
    beats = lanes * problem["wingbeats"]
    for width in (1,) if lanes == 1 else (1, 4, 8):
        march, compile_s = compiled(width, lanes)
        fly = flight(problem, march)
        error = float(np.max(np.abs(fly() - end)))
        timing = stopwatch.timed(fly)
        use = "in scalars" if width == 1 else f"in vectors of {width}"
        each = {name: timing[name] / beats for name in ("run_s", "best_s")}
        setting = f"cc {' '.join(FLAGS[:3])}"
        yield {"use": use, "setting": setting, "setup_s": compile_s, "error": error, **each}


def compiler():
    return subprocess.run(["cc", "-dumpfullversion"], capture_output=True, text=True, check=True).stdout.strip()


if __name__ == "__main__":
    stopwatch.write("C by hand", f"(gcc {compiler()})", measure(json.load(sys.stdin)))
