"""A Lyapunov-Krasovskii functional with Legendre projections, and the matrices that prove stability if positive.

The loop is x' = A x + B w, w_i(t) = z_i(t - h_i), z = C x. With v_i(theta, t) = z_i(t - h_i theta), 0 <= theta <= 1,
the past is a transport line, h v_t = -v_theta, v(0) = z, v(1) = w. Let L_k be the Legendre polynomials shifted to
[0, 1], L_k(1) = 1, L_k(0) = (-1)^k, int L_k^2 = 1 / (2 k + 1), and t0 a unit of time, r = h / t0. The functional

    V = X' P X + sum_i r_i int (v' S v + (1 - theta) v_theta' R v_theta),
    X = (x, r zeta_0, ..., r zeta_(N-1)),  zeta_k = int L_k v,

with S and R coupling only signals of the same delay, is that of Seuret & Gouaisbaut 2015 ("Hierarchy of LMI conditions
for the stability analysis of time-delay systems", Systems & Control Letters 81, 1-7, Theorem 5) with the state's whole
history replaced by the signals z through which alone it acts. C = I, B = A_d is the theorem itself.

Integration by parts gives eta_k = int L_k v_theta = -h zeta_k' from the ends and lower projections,

    eta_k = w - (-1)^k z - sum_(j < k, j + k odd) 2 (2 j + 1) zeta_j,

and the same for the two integrals, so that along every solution, with Bessel's inequality in the last step,

    t0 V' = 2 X' P (t0 X') + z' S z - w' S w + (h z_t)' R (h z_t) - int v_theta' R v_theta
         <= 2 X' P (t0 x', -eta) + z' S z - w' S w + (r C t0 x')' R (r C t0 x') - sum_(k <= N) (2 k + 1) eta_k' R eta_k.

The right side is a quadratic form -xi' Q xi in xi = (x, w, zeta_0, ..., zeta_(N-1)). Bessel's inequality for int v' S v
gives V >= X' Theta X with Theta = P + diag(0, S / r, 3 S / r, ..., (2 N - 1) S / r). Hence

    Theta > 0, S > 0, R > 0, Q > 0   prove that every characteristic root has a negative real part:

a root s with Re s >= 0 has a solution exp(s t) x0, x0 != 0, along which the Hermitian extension of V is
exp(2 Re(s) t) V(0) with V(0) >= 0, so V' >= 0; but t0 V' <= -xi' Q xi < 0. A system of retarded type with all roots on
the left is exponentially stable.

**Intervals.** X is linear in r, its derivative (x', -eta / t0) does not contain r, and the R term is a square in r with
R > 0. So -Q is convex in r, and one P, S, R with Q > 0 at both ends of a segment of delays has Q > 0 all along it, as
at the vertices of a polytope (Boyd, El Ghaoui, Feron & Balakrishnan 1994, "Linear Matrix Inequalities in System and
Control Theory", section 5.1). Theta only falls with r: check it at the upper end. An interval may begin at h = 0:
there w = z, eta = 0, V = x' P11 x, and Theta > 0 has P11 > 0. All of this holds for constant delays, not varying ones.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flycontrol.delay.certificate.definite import rounding
from flycontrol.delay.certificate.history import DelayedSignals
from flycontrol.delay.system import FloatArray


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Readings:
    """What the form reads from xi = (x, w, zeta_0, ..., zeta_(N-1)), m entries, for q signals and given delays."""

    state: FloatArray  #: X, shape (n + N q, m)
    rate: FloatArray  #: t0 X', shape (n + N q, m)
    entry: FloatArray  #: z, shape (q, m)
    exit: FloatArray  #: w, shape (q, m)
    slope: FloatArray  #: h z' = r C t0 x', shape (q, m)
    slope_size: FloatArray  #: r |C| |t0 x'|, which bounds the terms of that product, shape (q, m)
    modes: tuple[FloatArray, ...]  #: eta_0 ... eta_N, each (q, m)


def readings(signals: DelayedSignals, delays: FloatArray, unit: float, order: int) -> Readings:
    """The readings at `delays` (one for each group of signals) [s], with time in `unit` t0 [s]."""
    n, q = signals.B.shape
    ratio = signals.each(delays / unit)[:, None]
    parts = np.split(np.eye(n + q + order * q), [n + k * q for k in range(order + 1)])
    x, w, zeta = parts[0], parts[1], parts[2:]
    z = signals.C @ x
    velocity = unit * (signals.A @ x + signals.B @ w)
    modes = tuple(
        w - (-1) ** k * z - sum(2 * (2 * j + 1) * zeta[j] for j in range(k) if (j + k) % 2) for k in range(order + 1)
    )
    return Readings(
        state=np.vstack([x, *[ratio * projection for projection in zeta]]),
        rate=np.vstack([velocity, *[-mode for mode in modes[:order]]]),
        entry=z,
        exit=w,
        slope=ratio * (signals.C @ velocity),
        slope_size=ratio * (np.abs(signals.C) @ np.abs(velocity)),
        modes=modes,
    )


def dissipation(r: Readings, P: FloatArray, S: FloatArray, R: FloatArray) -> FloatArray:
    """Q, shape (m, m), linear in P, S and R; stacks of them, shapes (k, ., .), give a stack."""
    storing = r.state.T @ P @ r.rate
    form = r.exit.T @ S @ r.exit - r.entry.T @ S @ r.entry - r.slope.T @ R @ r.slope - storing
    form = form - np.swapaxes(storing, -1, -2)
    return form + sum((2 * k + 1) * (mode.T @ R @ mode) for k, mode in enumerate(r.modes))


def dissipation_error(r: Readings, P: FloatArray, S: FloatArray, R: FloatArray) -> FloatArray:
    """A bound on the rounding in every entry of Q: gamma_k times the same sum with all terms positive."""
    P, S, R = np.abs(P), np.abs(S), np.abs(R)
    storing = np.abs(r.state.T) @ P @ np.abs(r.rate)
    size = r.exit.T @ S @ r.exit + np.abs(r.entry.T) @ S @ np.abs(r.entry) + r.slope_size.T @ R @ r.slope_size
    size = size + storing + storing.T
    size = size + sum((2 * k + 1) * (np.abs(mode.T) @ R @ np.abs(mode)) for k, mode in enumerate(r.modes))
    return rounding(_operations(r)) * size


def storage(r: Readings, ratio: FloatArray, P: FloatArray, S: FloatArray) -> FloatArray:
    """Theta, shape (n + N q, n + N q), with the delays over t0 of all signals, shape (q,)."""
    q, order = len(ratio), len(r.modes) - 1
    shared = S @ np.diag(1.0 / ratio)  # symmetric: signals that S couples share their delay
    places = np.split(np.eye(len(r.state)), [len(r.state) - (order - k) * q for k in range(order)])[1:]
    return P + sum((2 * k + 1) * (place.T @ shared @ place) for k, place in enumerate(places))


def storage_error(r: Readings, ratio: FloatArray, P: FloatArray, S: FloatArray) -> FloatArray:
    """A bound on the rounding in every entry of Theta."""
    return rounding(_operations(r)) * storage(r, ratio, np.abs(P), np.abs(S))


def _operations(r: Readings) -> int:
    """More roundings than any entry of Q or Theta collects.

    Two sums over X or over the signals, one over terms, and two readings; a reading collects at most a sum over x,
    products with t0 and r, and the last places of B, C and the delays.
    """
    return 4 * (len(r.state) + len(r.entry) + len(r.modes) + 20)
