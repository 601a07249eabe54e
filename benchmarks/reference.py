"""Answers that every timed tool is measured against, in 40 digits and by none of the methods that are timed.

Response: between breakpoints (multiples of the delay, and the pulse's end shifted by them) the recovery is analytic,
and its Taylor coefficients about the left end follow from those of the segment one delay earlier: no Runge-Kutta, no
collocation, no matrix exponential, no interpolation. Roots: mpmath's secant iteration on the characteristic equation.
Stability: the largest stable delay in closed form, from the loop's one gain crossover.
"""

from bisect import bisect_right

import mpmath
from mpmath import mp, mpf

mp.dps = 40
TERMS = 60  # rates times the longest segment are below 2: the last term is below 1e-90


class Recovery:
    """psi'' = -b psi' - kp psi(t - T) - kd psi'(t - T) + a on [0, pulse), rest before; 0 < pulse < T."""

    def __init__(self, loop, pulse, acceleration, end):
        b, kp, kd, T = (mpf(loop[name]) for name in ("b", "kp", "kd", "T"))
        periods = range(int(end / T) + 1)
        self.starts = sorted([k * T for k in periods] + [k * T + mpf(pulse) for k in periods])
        self.series = []
        angle, rate = mpf(0), mpf(0)
        for i in range(len(self.starts)):
            past = self.series[i - 2] if i >= 2 else [mpf(0)] * (TERMS + 2)  # two breakpoints a delay
            c = [angle, rate]
            for n in range(TERMS):
                curve = -b * (n + 1) * c[n + 1] - kp * past[n] - kd * (n + 1) * past[n + 1]
                if n == 0 and i == 0:
                    curve += mpf(acceleration)
                c.append(curve / ((n + 1) * (n + 2)))
            self.series.append(c)
            if i + 1 < len(self.starts):
                angle, rate = self(self.starts[i + 1], i), self.rate(self.starts[i + 1], i)

    def __call__(self, t, segment=None):
        i, s = self._locate(t, segment)
        return horner(self.series[i], s)

    def rate(self, t, segment=None):
        i, s = self._locate(t, segment)
        return horner([n * c for n, c in enumerate(self.series[i])][1:], s)

    def _locate(self, t, segment):
        i = bisect_right(self.starts, mpf(t)) - 1 if segment is None else segment
        return i, mpf(t) - self.starts[i]

    def peak(self):
        """Largest angle: the first zero of the rate after the pulse."""
        step = (self.starts[2] - self.starts[0]) / 64
        t = self.starts[1]
        while self.rate(t + step) > 0:
            t += step
        return self(mpmath.findroot(self.rate, (t, t + step), solver="anderson"))


def least_squares(problem, yaw, noise):
    """Minimiser of the squares over kp, kd, T, and its standard errors at the given noise, as numbers."""
    x = mpmath.matrix([problem["loop"][name] for name in ("kp", "kd", "T")])
    step = mpf(10) ** -14
    for _ in range(8):
        centre = _angles(problem, x)
        slopes = mpmath.matrix(len(yaw), 3)
        for j in range(3):
            moved = x.copy()
            moved[j] *= 1 + step
            slopes[:, j] = (_angles(problem, moved) - centre) / (step * x[j])
        normal = slopes.T * slopes
        move = mpmath.lu_solve(normal, slopes.T * (mpmath.matrix(yaw) - centre))
        x += move
        if all(abs(move[j]) < mpf(10) ** -13 * x[j] for j in range(3)):
            break
    covariance = normal**-1
    return [float(v) for v in x], [float(noise * mpmath.sqrt(covariance[j, j])) for j in range(3)]


def _angles(problem, x):
    loop = problem["loop"] | dict(zip(("kp", "kd", "T"), x, strict=True))
    answer = Recovery(loop, problem["pulse"], problem["acceleration"], problem["end"])
    return mpmath.matrix([answer(t) for t in problem["times"]])


def horner(coefficients, s):
    """Polynomial with rising powers."""
    value = mpf(0)
    for c in reversed(coefficients):
        value = value * s + c
    return value


def root_near(loop, guess):
    """The root of s^2 + b s + (kp + kd s) exp(-s T) next to a guess."""
    b, kp, kd, T = (mpf(loop[name]) for name in ("b", "kp", "kd", "T"))
    return complex(
        mpmath.findroot(lambda s: s * s + b * s + (kp + kd * s) * mpmath.exp(-s * T), mpmath.mpmathify(guess))
    )


def largest_stable_delay(b, kp, kd):
    """T up to which s^2 + b s + (kp + kd s) exp(-s T) has all roots left of the axis; 0 if it has none there."""
    b, kp, kd = mpf(b), mpf(kp), mpf(kd)
    if not (kp > 0 and b + kd > 0):
        return mpf(0)
    fall = kd**2 - b**2
    crossover = mpmath.sqrt((fall + mpmath.sqrt(fall**2 + 4 * kp**2)) / 2)
    return (mpmath.atan(kd * crossover / kp) + mpmath.atan(b / crossover)) / crossover
