"""The problems that flycontrol and its peers are timed on, as plain values that travel as JSON."""

import math
import random
from functools import cache

import reference

NOMINAL = {"b": 69.0, "kp": 3050.0, "kd": 45.0, "T": 3 / 220}
BENCHMARK = {"b": 20.0, "kp": 900.0, "kd": 55.0, "T": 13.6e-3}

PEAK = math.radians(20.0)
END = 0.1  # [s]
NOISE = math.radians(0.3)
RATE = 8000  # samples a second; neither the pulse's end nor the delay falls on a sample


@cache
def recovery():
    """Recovery of the nominal loop from a torque pulse of a third of the delay that turns the fly by 20 deg."""
    pulse = NOMINAL["T"] / 3
    unit = reference.Recovery(NOMINAL, pulse, 1.0, END)
    acceleration = float(PEAK / unit.peak())
    times = [k / RATE for k in range(int(END * RATE) + 1)]
    exact = reference.Recovery(NOMINAL, pulse, acceleration, END)
    return {
        "loop": NOMINAL,
        "pulse": pulse,
        "acceleration": acceleration,
        "end": END,
        "times": times,
        "reference": [float(exact(t)) for t in times],
    }


@cache
def fit():
    """One recording of the recovery at 0.3 deg of white noise; kp, kd and T are asked, the rest is known.

    The minimiser is that of 40-digit responses, by Gauss and Newton's steps with differences in the 14th digit.
    """
    noise, problem = random.Random(1), recovery()
    yaw = [angle + noise.gauss(0.0, NOISE) for angle in problem["reference"]]
    minimiser, standard_errors = reference.least_squares(problem, yaw, NOISE)
    return {
        "b": NOMINAL["b"],
        "start": [2400.0, 35.0, 0.0115],  # a peer's; flycontrol gets none
        "yaw": yaw,
        "minimiser": minimiser,
        "standard_errors": standard_errors,
        **{name: problem[name] for name in ("pulse", "acceleration", "end", "times")},
    }


@cache
def roots(name):
    """The rightmost roots of a loop in the closed upper half plane, and a box that holds no other ones."""
    loop, guesses = {
        "benchmark loop": (BENCHMARK, (-15.3, -39.8 + 86.8j)),
        "nominal loop": (NOMINAL, (-49.3 + 72.6j, -66.0)),
    }[name]
    exact = [reference.root_near(loop, guess) for guess in guesses]
    return {"loop": loop, "roots": [[z.real, z.imag] for z in exact], "box": [-100.0, 10.0, 0.0, 300.0]}


@cache
def chart():
    """20 x 20 gains over the nominal plant, row by row in kd: is the loop stable, by the closed form?"""
    b, T = NOMINAL["b"], NOMINAL["T"]
    kp, kd = ([low + (high - low) * k / 19 for k in range(20)] for low, high in ((-500.0, 12000.0), (-90.0, 200.0)))
    largest = [reference.largest_stable_delay(b, x, y) for y in kd for x in kp]
    return {"b": b, "T": T, "kp": kp, "kd": kd, "stable": [limit > T for limit in largest]}
