"""Yaw of a perturbed fly by the method of steps in power series, for complex parameters.

Between breakpoints (the start, the pulse's edges, all moved by multiples of the delay) psi is analytic in time and in
every parameter, the delay and the onset included, since breakpoints and local times move with them. So the imaginary
part of an answer, a parameter moved by i h, is h times the derivative, to rounding. No collocation, no interpolation.
"""

import numpy as np

TERMS = 40
PARTS = 6  # of a delay: series of tanh converge within them
STEP = 1e-30


def response(values, times, pulse):
    """Yaw and N_fly / I at real times (n,), complex where a value is."""
    p = {"ki": 0.0, "limit": None, "onset_shift": 0.0, "initial_yaw": 0.0, "initial_rate": 0.0, "heading": 0.0} | values
    start = min(times[0], pulse.onset)
    edges = [pulse.onset + p["onset_shift"], pulse.onset + pulse.duration + p["onset_shift"]]
    breaks = breakpoints(p["delay"], start, edges, times[-1])
    past, yaw, fly = [], np.zeros(len(times), complex), np.zeros(len(times), complex)
    psi, rate, integral = p["initial_yaw"] + 0j, p["initial_rate"] + 0j, 0j
    for i, a in enumerate(breaks):
        length = (breaks[i + 1] if i + 1 < len(breaks) else times[-1] + 1e-3) - a
        middle = (a + length / 2).real
        push = values["impulse"] / pulse.duration if edges[0].real < middle < edges[1].real else 0.0
        torque = fly_torque(p, delayed_demand(p, a, start, past))
        series = solution(p["damping"], torque, push, psi, rate)
        integrals = np.concatenate([[integral], series[:-1] / np.arange(1, len(series))])
        past.append((a, series, integrals))
        here = (times >= a.real) & (times < (a + length).real)
        yaw[here], fly[here] = horner(series, times[here] - a), horner(torque, times[here] - a)
        psi, rate, integral = horner(series, length), horner(derivative(series), length), horner(integrals, length)
    return yaw + p["heading"], fly


def derivative_by(name, values, times, pulse):
    """d yaw / d parameter and d (N_fly / I) / d parameter (n,) each."""
    moved = response(values | {name: values.get(name, 0.0) + 1j * STEP}, times, pulse)
    return [answer.imag / STEP for answer in moved]


def breakpoints(delay, start, edges, end):
    delay, found = delay + 0j, []
    for seed in [*(start + delay * j / PARTS for j in range(PARTS)), *edges]:
        first = int(np.ceil(((start - seed) / delay).real - 1e-9))
        k = first
        while (seed + k * delay).real < end:
            found.append(seed + k * delay)
            k += 1
    found.sort(key=lambda b: b.real)
    return [b for i, b in enumerate(found) if i == 0 or b.real - found[i - 1].real > 1e-12]


def delayed_demand(p, a, start, past):
    """kp psi + kd psi' + ki integral of psi, one delay ago, as a series about a."""
    then = a - p["delay"]
    if then.real < start - 1e-12:
        ago = then - start
        psi = np.array([p["initial_yaw"] + p["initial_rate"] * ago, p["initial_rate"], 0.0], complex)
        integral = np.array([(p["initial_yaw"] + p["initial_rate"] * ago / 2) * ago, psi[0], p["initial_rate"] / 2])
    else:
        _, psi, integral = next(segment for segment in past if abs(segment[0] - then) < 1e-12)
    w = np.zeros(TERMS, complex)
    for series, gain in ((psi, p["kp"]), (derivative(psi), p["kd"]), (integral, p["ki"])):
        n = min(TERMS, len(series))
        w[:n] += gain * series[:n]
    return w


def fly_torque(p, w):
    """-w, or -limit tanh(w / limit) by tanh' = 1 - tanh^2."""
    if p["limit"] is None:
        return -w
    v, y, square = w / p["limit"], np.zeros(TERMS, complex), np.zeros(TERMS, complex)
    y[0] = np.tanh(v[0])
    slopes = derivative(v)
    for n in range(TERMS - 1):
        square[n] = y[: n + 1] @ y[n::-1]
        grown = slopes[n] - square[: n + 1] @ slopes[n::-1]
        y[n + 1] = grown / (n + 1)
    return -p["limit"] * y


def solution(b, torque, push, psi, rate):
    """psi'' = -b psi' + torque + push."""
    c = np.zeros(TERMS + 2, complex)
    c[0], c[1] = psi, rate
    for n in range(TERMS):
        c[n + 2] = (-b * (n + 1) * c[n + 1] + torque[n] + (push if n == 0 else 0.0)) / ((n + 1) * (n + 2))
    return c


def derivative(series):
    return series[1:] * np.arange(1, len(series))


def horner(series, t):
    value = 0.0 * t
    for c in series[::-1]:
        value = value * t + c
    return value
