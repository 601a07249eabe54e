"""How wrong is each Pade order for a loop with a reaction delay, and which order is enough?

Run with `python analyses/pade_or_exact.py [FOLDER]`; the note with its answer, the numbers and the figure go to
reports/pade_or_exact unless a folder is given. It takes about two minutes.
"""

import io
import json
import math
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import control
import numpy as np
from _by_hand import REPORTS, folder_named
from scipy.optimize import brentq, least_squares

from flycontrol.delay import DelayLTI, delay, feedback, margins, pade, response, rightmost_roots
from flycontrol.io.parameters import read_parameters
from flycontrol.jobs.files import write_files_atomically
from flycontrol.model.parameters import Parameters
from flycontrol.model.recovery import pulse_for_peak
from flycontrol.model.yaw import YawLoop
from flycontrol.units import deg, ms

if TYPE_CHECKING:
    from matplotlib.axes import Axes

FOLDER = REPORTS / "pade_or_exact"
ORDERS = tuple(range(1, 9))
DOUBLING = (4, 8, 16, 32)  # orders at which responses show their power law
SEED = 20_240
NOISE = 0.5  # of the fly's yaw in each frame [deg]
RECORDINGS = 16

# ## The question
#
# Most tools for linear control have no delay. They replace exp(-s T) by a rational function, Pade's [n/n], which has
# the right modulus at every frequency and the right phase up to some frequency that rises with n. Everything that
# follows is then computed without error, of another loop. Here the exact loop stands beside its approximations, so
# that each error can be read off: in stability margins, in the rightmost pole, in a response, and in what a fit makes
# of a recording.
#
# ## Four loops
#
# The published fly's yaw, and three loops that any course on delays knows. Their theory is elementary: the delayed
# integrator is stable up to k T = pi / 2; a stick of length l leans by theta'' = a theta + u, a = 3 g / (2 l), and can
# be balanced by PD up to T = sqrt(2 / a) (docs/tutorial.md derives it); a lag with dead time under PI stands for most
# of process control. The gains of these three are ours, chosen to be ordinary: gain margins from 1.2 to 2.6.


@dataclass(frozen=True, slots=True, kw_only=True)
class Loop:
    """A loop with its parameters, the delay the last of them [s]."""

    name: str
    words: str
    disturbance: str  #: d in words
    units: tuple[str, ...]  #: of the parameters, then of the measured output
    parameters: dict[str, float]  #: free in a fit
    plant: Callable[..., DelayLTI]  #: L(s) from parameters, negative unit feedback closes it
    disturbed: Callable[..., DelayLTI]  #: closed loop from disturbance to the measured output, from parameters
    edges: tuple[float, ...]  #: the disturbance's breakpoints [s]
    values: tuple[float, ...]  #: and its values from there on
    horizon: float  #: length of the recording [s]

    @property
    def truth(self) -> np.ndarray:
        """The parameters as a vector."""
        return np.array(list(self.parameters.values()))

    @property
    def delay(self) -> float:
        """T [s]."""
        return float(self.truth[-1])

    def with_delay(self, T: float) -> DelayLTI:
        """The closed loop at another delay."""
        return self.disturbed(*self.truth[:-1], T)


def second_order(stiffness: float, damping: float) -> control.StateSpace:
    """x'' = -stiffness x - damping x' + u, with outputs x and x'."""
    return control.ss([[0.0, 1.0], [-stiffness, -damping]], [[0.0], [1.0]], np.eye(2), np.zeros((2, 1)))


def reaction(kp: float, kd: float, T: float) -> DelayLTI:
    """kp x + kd x', a delay later."""
    return delay(T) * np.array([[kp, kd]])


def under_pd(plant: control.StateSpace, **fields: Any) -> Loop:
    """A second-order plant under delayed PD, its position measured."""
    position = np.array([[1.0, 0.0]])
    return Loop(
        **fields,
        plant=lambda kp, kd, T: reaction(kp, kd, T) * plant,
        disturbed=lambda kp, kd, T: position * feedback(plant, reaction(kp, kd, T)),
    )  # fmt: skip


def fly_loop(fly: Parameters) -> Loop:
    """The nominal fly after the pulse that turns it by 20 deg; yaw in degrees."""
    kp, kd, T = fly.proportional_gain.value, fly.derivative_gain.value, fly.delay.value
    exact = YawLoop.from_rates(b=fly.damping_rate, kp=kp, kd=kd, delay=T)
    pulse = pulse_for_peak(exact, fly.pulse_duration.value, fly.pulse_peak.value)
    return under_pd(
        second_order(0.0, fly.damping_rate), name="fly",
        words=f"psi'' = -b psi' - (kp psi + kd psi')(t - T) + d, b = {fly.damping_rate:.4g} 1/s",
        disturbance=f"d constant for {pulse.duration / ms:.3g} ms, so that the yaw psi peaks at 20 deg",
        units=("1/s^2", "1/s", "s", "deg"), parameters={"kp": kp, "kd": kd, "T": T},
        edges=(0.0, pulse.duration), values=(pulse.torque / deg, 0.0), horizon=100 * ms,
    )  # fmt: skip


def textbook_loops() -> list[Loop]:
    """A delayed integrator, a stick, a lag with dead time under PI."""
    integrator, lag = control.tf([1.0], [1.0, 0.0]), control.tf([1.0], [1.0, 1.0])

    def pi(Kp: float, Ti: float) -> control.TransferFunction:
        return control.tf([Kp * Ti, Kp], [Ti, 0.0])

    return [
        Loop(
            name="integrator", words="x' = -k x(t - T) + d", disturbance="d = 1 1/s for 0.5 s",
            units=("1/s", "s", ""), parameters={"k": 0.7, "T": 1.0},
            plant=lambda k, T: k * integrator * delay(T),
            disturbed=lambda k, T: feedback(integrator, k * delay(T)),
            edges=(0.0, 0.5), values=(1.0, 0.0), horizon=12.0,
        ),
        under_pd(
            second_order(-1.5 * 9.81, 0.0), name="stick",
            words="theta'' = a theta - (kp theta + kd theta')(t - T) + d, a = 14.715 1/s^2 (a stick of 1 m)",
            disturbance="d = 0.1 rad/s^2 for 0.5 s", units=("1/s^2", "1/s", "s", "rad"),
            parameters={"kp": 18.0, "kd": 5.0, "T": 0.2}, edges=(0.0, 0.5), values=(0.1, 0.0), horizon=5.0,
        ),
        Loop(
            name="process", words="(1 s) x' = -x - Kp (x + int x / Ti)(t - T) + d", disturbance="d = 1 from 0 on",
            units=("", "s", "s", ""), parameters={"Kp": 0.8, "Ti": 1.2, "T": 1.0},
            plant=lambda Kp, Ti, T: pi(Kp, Ti) * lag * delay(T),
            disturbed=lambda Kp, Ti, T: feedback(lag, pi(Kp, Ti) * delay(T)),
            edges=(0.0,), values=(1.0,), horizon=20.0,
        ),
    ]  # fmt: skip


# ## What is compared
#
# The note that this file writes defines each quantity (METHOD, below). The approximated loop has a largest delay of its
# own, found by letting its T grow.


@dataclass(frozen=True, slots=True, kw_only=True)
class Wrong:
    """How far one approximation is off; exact values where `order` is 0."""

    order: int
    gain_margin: float  #: exact: the factor; else relative error
    largest_delay: float  #: exact: [s]; else relative error
    delay_margin: float  #: exact: [s]; else relative error
    pole: float  #: exact: |s| [1/s]; else relative distance
    response: float  #: exact: largest |y|; else relative error
    fit: dict[str, float]  #: exact: the truth; else fitted less true parameter, relative


def largest_delay(loop: Loop, order: int) -> float:
    """The delay at which the loop, or its approximation, turns unstable [s]."""

    def abscissa(T: float) -> float:
        system = loop.with_delay(T)
        return rightmost_roots(pade(system, order) if order else system, 2, certify=False).abscissa

    T = loop.delay
    while abscissa(1.1 * T) < 0:
        T *= 1.1
    return float(brentq(abscissa, T, 1.1 * T, xtol=1e-14, rtol=1e-13))


def recorded(loop: Loop, parameters: np.ndarray, times: np.ndarray, order: int = 0) -> np.ndarray:
    """The measured output, exact or with a Pade delay of this order."""
    system = loop.disturbed(*parameters)
    model = pade(system, order) if order else system
    return response(model, loop.horizon, loop.edges, np.array(loop.values)[:, None])(times)[0]


# ## Fits
#
# The experimenter's question runs the other way: given a recording, what are the gains and the delay? The recording is
# the exact response, and the model of the fit holds a Pade delay. A plain least-squares fit then bends the parameters
# until the wrong model looks right. The plant and the disturbance are taken as known, the start is 10 % off.


def fitted(loop: Loop, data: np.ndarray, times: np.ndarray, order: int) -> np.ndarray:
    """Least-squares estimate of the loop's parameters."""
    truth = loop.truth

    def residuals(ratio: np.ndarray) -> np.ndarray:
        return recorded(loop, ratio * truth, times, order) - data

    start = np.where(np.arange(len(truth)) % 2, 1.1, 0.9)
    found = least_squares(residuals, start, bounds=(0.2, 5.0), xtol=1e-12, ftol=1e-12, gtol=1e-12, diff_step=1e-6)
    return found.x * truth


def sample_times(loop: Loop) -> np.ndarray:
    """A hundred frames of the recording: for the fly 1 kHz."""
    return np.linspace(0.0, loop.horizon, 101)


def exact(loop: Loop) -> Wrong:
    """The values that the approximations are judged by."""
    T_max = largest_delay(loop, 0)
    y = recorded(loop, loop.truth, np.linspace(0.0, loop.horizon, 2001))
    return Wrong(
        order=0, gain_margin=margins(loop.plant(*loop.truth)).gain_margin, largest_delay=T_max,
        delay_margin=T_max - loop.delay, pole=float(abs(rightmost_roots(loop.with_delay(loop.delay), 2).roots[0])),
        response=float(np.abs(y).max()), fit=dict(loop.parameters),
    )  # fmt: skip


def approximated(loop: Loop, truth: Wrong, order: int) -> Wrong:
    """One order's errors."""
    T_max = largest_delay(loop, order)
    times = sample_times(loop)
    pole = rightmost_roots(loop.with_delay(loop.delay), 2).roots[0]
    its_poles = rightmost_roots(pade(loop.with_delay(loop.delay), order), 2).roots
    estimate = fitted(loop, recorded(loop, loop.truth, times), times, order)
    factor = margins(pade(loop.plant(*loop.truth), order)).gain_margin
    return Wrong(
        order=order, gain_margin=factor / truth.gain_margin - 1, largest_delay=T_max / truth.largest_delay - 1,
        delay_margin=(T_max - loop.delay) / truth.delay_margin - 1,
        pole=float(np.abs(its_poles - pole).min() / abs(pole)), response=response_error(loop, order),
        fit=dict(zip(loop.parameters, estimate / loop.truth - 1, strict=True)),
    )  # fmt: skip


def response_error(loop: Loop, order: int) -> float:
    """max |y_n - y| / max |y| over 2001 instants of the recording."""
    times = np.linspace(0.0, loop.horizon, 2001)
    truth = recorded(loop, loop.truth, times)
    return float(np.abs(recorded(loop, loop.truth, times, order) - truth).max() / np.abs(truth).max())


def compare(loop: Loop) -> list[Wrong]:
    """The exact loop, then every order."""
    truth = exact(loop)
    return [truth, *[approximated(loop, truth, order) for order in ORDERS]]


# ## On the fly in particular
#
# The gain that a designer would turn up is kd, with kp as it is; the recovery time is the report's headline; and real
# recordings are noisy, so that one may ask whether the bias hides in the scatter: 0.5 deg of white noise in each of
# 101 frames, the same sixteen noisy recordings for every model.


@dataclass(frozen=True, slots=True, kw_only=True)
class FlyWrong:
    """What one model says of the fly; the exact one where `order` is 0."""

    order: int
    critical_kd: float  #: largest stable kd [1/s]
    recovery: float  #: last entry into the band [s]
    delay: float  #: T fitted to the clean recording [s]
    noisy_delay: float  #: its mean over the noisy recordings [s]
    noisy_spread: float  #: and standard deviation [s]


def fly_says(loop: Loop, band: float, order: int) -> FlyWrong:
    """One model's account of the fly; the band in degrees."""
    kp, kd, T = loop.truth
    times = sample_times(loop)
    clean = recorded(loop, loop.truth, times)

    def model(damping: float) -> DelayLTI:
        system = loop.disturbed(kp, damping, T)
        return pade(system, order) if order else system

    def abscissa(damping: float) -> float:
        return rightmost_roots(model(damping), 2, certify=False).abscissa

    draw = np.random.default_rng(SEED)
    noisy = [clean + NOISE * draw.normal(size=len(times)) for _ in range(RECORDINGS)]
    delays = np.array([fitted(loop, data, times, order)[-1] for data in noisy])
    yaw = response(model(kd), 2 * loop.horizon, loop.edges, np.array(loop.values)[:, None])
    return FlyWrong(
        order=order, critical_kd=float(brentq(abscissa, kd, 10 * kd, xtol=1e-12)),
        recovery=yaw.last_time_outside(band), delay=float(fitted(loop, clean, times, order)[-1]),
        noisy_delay=float(delays.mean()), noisy_spread=float(delays.std(ddof=1)),
    )  # fmt: skip


# ## The other trap: how the same rational function is written down
#
# python-control's `pade` gives numerator and denominator; in companion form, with time in seconds, their coefficients
# span dozens of decades. Poles survive that, a simulation does not. `flycontrol.delay.pade` realises the same function
# as a lossless ladder with time in units of the delay.


@dataclass(frozen=True, slots=True, kw_only=True)
class Realisation:
    """Errors of the fly's response to a constant torque, relative to its largest yaw; NaN where numbers overflow."""

    order: int
    ladder: float
    companion: float


def realisation(loop: Loop, damping_rate: float, order: int) -> Realisation:
    """The same approximant, twice."""
    times = np.linspace(0.0, loop.horizon, 2001)
    kp, kd, T = loop.truth

    def step(system: DelayLTI) -> np.ndarray:
        return response(system, loop.horizon, inputs=[[loop.values[0]]])(times)[0]

    truth = step(loop.with_delay(T))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of overflow: that is what is being shown
        lag = control.ss(control.tf(*control.pade(T, order)))
        closed = control.feedback(second_order(0.0, damping_rate), lag * control.ss([], [], [], [[kp, kd]]))
        theirs = control.forced_response(closed, times, np.full_like(times, loop.values[0])).outputs[0]
        companion = float(np.abs(theirs - truth).max() / np.abs(truth).max())
    ladder = float(np.abs(step(pade(loop.with_delay(T), order)) - truth).max() / np.abs(truth).max())
    return Realisation(order=order, ladder=ladder, companion=companion)


# ## The figure
#
# Errors of the gain margin and of the rightmost pole fall exponentially with the order, errors of responses only
# algebraically. Fits lie between.

LOOKS: dict[str, dict[str, Any]] = {
    "fly": {"color": "#0b3954", "marker": "o", "linestyle": "-", "markersize": 7, "markerfacecolor": "none"},
    "integrator": {"color": "#f0a830", "marker": "s", "markersize": 3.5, "linestyle": "--"},
    "stick": {"color": "#b8303a", "marker": "^", "markersize": 3.5, "linestyle": "-."},
    "process": {"color": "#3f93d0", "marker": "D", "markersize": 3.5, "linestyle": ":"},
}
PANELS: dict[str, Callable[[Wrong], float]] = {
    "Gain margin, overstated by": lambda w: w.gain_margin,
    "Delay margin, overstated by": lambda w: w.delay_margin,
    "Rightmost pole, off by": lambda w: w.pole,
    "Response, off by at most": lambda w: w.response,
    "Fitted delay, off by": lambda w: abs(w.fit["T"]),
}
LEAST = 1e-6  # relative error that is drawn


def draw(loops: list[Loop], found: dict[str, list[Wrong]]) -> bytes:
    """Errors against the order for the four loops, and the fly's yaw less exact as low orders have it."""
    from flycontrol.report.style import in_house_style, new_figure

    with in_house_style():
        figure = new_figure(4.9)
        axes = figure.subplots(2, 3).ravel()
        for ax, (title, error) in zip(axes, PANELS.items(), strict=False):
            draw_errors(ax, title, error, found)
        draw_responses(axes[5], loops[0])
        figure.legend(*axes[0].get_legend_handles_labels(), loc="outside upper left", ncols=4, handlelength=3.2)
        buffer = io.BytesIO()
        figure.savefig(buffer, format="svg", metadata={"Date": None, "Creator": None})
    return buffer.getvalue()


def draw_errors(ax: "Axes", title: str, error: Callable[[Wrong], float], found: dict[str, list[Wrong]]) -> None:
    """One quantity's relative error for every loop; smaller ones leave through the bottom."""
    for name, wrongs in found.items():
        # rounding, which differs between machines, stays below the panel
        values = np.maximum([error(w) for w in wrongs[1:]], LEAST / 30)
        ax.semilogy(ORDERS, values, linewidth=1.2, label=name, **LOOKS[name])
    ax.axhline(0.01, color="#7d7d7d", linewidth=0.7)
    ax.annotate("1 %", (8.3, 0.01), (0, 2), textcoords="offset points", ha="right", fontsize=7.5, color="#555555")
    ax.set(title=title, xlabel="Padé order n [1]", xlim=(0.7, 8.4), ylim=(LEAST, 2.0), xticks=ORDERS)
    ax.set_yticks([1e-6, 1e-4, 1e-2, 1.0], ["0.0001 %", "0.01 %", "1 %", "100 %"])
    ax.minorticks_off()


def draw_responses(ax: "Axes", loop: Loop) -> None:
    """The fly's yaw after the pulse as orders 1, 2 and 3 have it, less the exact one."""
    times = np.linspace(0.0, loop.horizon, 1001)
    truth = recorded(loop, loop.truth, times)
    styles = {1: ("#f0a830", (0, (4, 2)), 1.4), 2: ("#b8303a", "-", 1.4), 3: ("#0b3954", (0, (1, 1)), 1.6)}
    for order, (colour, dashes, width) in styles.items():
        error = recorded(loop, loop.truth, times, order) - truth
        ax.plot(times / ms, error, color=colour, linestyle=dashes, linewidth=width, label=f"order {order}")
    ax.axhline(0.0, color="#7d7d7d", linewidth=0.7, zorder=0)
    ax.set(title="The fly's yaw less exact", xlabel="time [ms]", ylabel="error of yaw [deg]", xlim=(0, 100))
    ax.legend(loc="lower right")


# ## The note
#
# What a reader gets: question, method, definitions, answer, figure, tables. Every number in the answer is put there by
# what was found; the tests hold the words around them.

QUESTION = """# How wrong is each Padé order for a loop with a reaction delay, and which order is enough?

Most tools for linear control have no delay. They replace exp(-s T) by Padé's [n/n], a rational function with the right
modulus at every frequency and the right phase up to some frequency that rises with its order n. What follows is then
computed without error, of another loop. How far is that loop from the one that was meant: in its margins, its rightmost
pole, its responses, and in what a fit makes of a recording?
"""
METHOD = """## Method

Four loops: the published fly's yaw under PD (calibrated gains), and three of any course on delays, with ordinary gains
of our choice: a delayed integrator, a stick balanced by PD, a lag with dead time under PI. Each is computed with its
exact delay T and with [n/n] in its place, n = 1 to 8, by the same routines. Exact values agree with closed forms where
there are some.

| quantity | meaning | error |
|---|---|---|
| gain margin [1] | factor on the whole loop gain at which stability ends | relative; + overstates |
| largest delay [s] | T at which stability ends, in [n/n] as well | relative; + overstates |
| delay margin [s] | largest delay less T | relative; + overstates |
| pole [1/s] | rightmost pole s of the closed loop | distance to the nearest pole with [n/n], over the modulus of s |
| response | measured output y(t) after a disturbance d, from rest | max abs(y_n - y) / max abs(y) in the recording |
| fitted parameters | least squares on 101 samples of the exact y without noise, with [n/n] in the model; plant and \
disturbance known, start 10 % off | relative; + too large |
"""
ANSWER = """## Answer

**Order 4 is enough for margins, poles and fits of loops like these; order 1 misleads everywhere; responses want more.**

- **Order 1** overstates the gain margin by {gain} and the delay margin by {delay}, moves the rightmost pole by
  {pole}, and calls loops stable that are not: the fly's largest stable kd comes out {critical} too high. A fit with it
  finds a delay too long by {fitted}, for the fly by {late}. With {noise} of noise a single recording's
  estimate scatters by {scatter}: that is bias, and no amount of data mends it.
- **Orders 2 and 3** leave at most {margins_2} and {margins_3} in margins, {fits_2} and {fits_3} in fitted delays.
- **Order 4** has all margins right to {margins_4}, fitted delays to {fits_4}, and the fly's recovery time
  to 0.01 ms.
- **Responses** are off by {response_4} at order 4 and by {response_8} at order 8.

**Why responses lag behind.** A disturbance that sets in or stops at once leaves a corner in what the controller sees,
and the delay repeats it at T and at T after its end. [n/n] follows the delay up to w T of about 2 n and no further. The
spectrum of the corner, once through the plant, falls as w^-3 for integrator and process and, with one integration more,
as w^-4 for fly and stick, so what is missed falls as n^-2 and n^-3: no floor, but unevenly, as the two ends of a
pulse ring in or out of step. The integrator's stretch from order 6 to 8 is such a step, as the doubled orders show.

**What it holds for.** w T is at most 1.7 at the phase crossovers of these loops. The phase of [n/n] errs by
(w T)^(2n+1) n!^2 / ((2n)! (2n+1)!), so a loop with more lag to spend needs more. High orders must not be simulated in
companion form: at order 12 the fly's response is lost, its coefficients having run out of digits, while the same
function as a ladder goes on converging. And no approximation can say how wrong it is: that took the exact loop.

![Errors against the order](pade_or_exact.svg)

Relative errors of the four loops against the order; lines that leave through the bottom go on below 0.0001 %. Last
panel: yaw of the fly after the pulse (peak 20 deg) with orders 1, 2 and 3, less the exact yaw.
"""


@dataclass(frozen=True, slots=True, kw_only=True)
class Findings:
    """Everything that the note finds."""

    loops: dict[str, list[Wrong]]
    fly: list[FlyWrong]
    forms: list[Realisation]
    doubling: dict[str, list[float]]  #: error of the response at the orders DOUBLING

    def at(self, order: int, error: Callable[[Wrong], float]) -> list[float]:
        """Errors of one order, loop by loop."""
        return [error(wrongs[order]) for wrongs in self.loops.values()]


def span(errors: list[float]) -> str:
    """From the smallest to the largest, in whole percent."""
    return f"{100 * min(errors):.0f} to {100 * max(errors):.0f} %"


def at_most(errors: list[float]) -> str:
    """A bound on all, rounded up to two digits."""
    largest = 100 * max(abs(e) for e in errors)
    digit = 10.0 ** (math.floor(math.log10(largest)) - 1)
    return f"{math.ceil(largest / digit) * digit:.2g} %"


def answer(found: Findings, T: float) -> str:
    """The answer with its numbers; T is the fly's delay [s]."""
    truth, first, *_ = found.fly
    of_margins = {n: found.at(n, lambda w: max(w.gain_margin, w.largest_delay, w.delay_margin)) for n in (2, 3, 4)}
    fits = {n: found.at(n, lambda w: w.fit["T"]) for n in (1, 2, 3, 4)}
    return ANSWER.format(
        gain=span(found.at(1, lambda w: w.gain_margin)),
        delay=span(found.at(1, lambda w: w.delay_margin)),
        pole=span(found.at(1, lambda w: w.pole)),
        critical=f"{100 * (first.critical_kd / truth.critical_kd - 1):.0f} %",
        fitted=span(fits[1]),
        late=f"{(first.delay - T) / ms:.2f} ms of {T / ms:.2f} ms",
        noise=f"{NOISE:g} deg",
        scatter=f"{first.noisy_spread / ms:.2f} ms",
        **{f"margins_{n}": at_most(errors) for n, errors in of_margins.items()},
        **{f"fits_{n}": at_most(fits[n]) for n in (2, 3, 4)},
        **{f"response_{n}": span_fine(found.at(n, lambda w: w.response)) for n in (4, 8)},
    )


def smallest_order(wrongs: list[Wrong], error: Callable[[Wrong], float], tolerance: float) -> int | None:
    """The smallest order from which on the error stays within the tolerance; None if none does."""
    over = [w.order for w in wrongs[1:] if not abs(error(w)) <= tolerance]
    order = max(over, default=0) + 1
    return order if order <= ORDERS[-1] else None


def span_fine(errors: list[float]) -> str:
    """From the smallest to the largest, to two digits."""
    return f"{100 * min(errors):.2g} to {100 * max(errors):.2g} %"


def percent(value: float, floor: float = 1e-6, *, signed: bool = True) -> str:
    """Two digits, or that it is lost in rounding; a sign where there are two directions."""
    if abs(value) < floor:
        return f"< {100 * floor:g} %"
    return f"{100 * value:+.2g} %" if signed else f"{100 * value:.2g} %"


def as_text(loops: list[Loop], found: Findings) -> str:
    """The note as a page of Markdown."""
    parts = [QUESTION, METHOD, answer(found, loops[0].delay)]
    parts += [_order_table(found.loops), _doubling_table(found.doubling)]
    parts += [_loop_table(loop, found.loops[loop.name]) for loop in loops]
    parts += [_fly_table(found.fly), _form_table(found.forms)]
    return "\n".join(parts)


def with_unit(value: float, unit: str, digits: int = 4) -> str:
    """A number and its unit, if it has one."""
    return f"{value:.{digits}g} {unit}".rstrip()


def _loop_table(loop: Loop, wrongs: list[Wrong]) -> str:
    truth, names = wrongs[0], list(loop.parameters)
    given = [with_unit(value, unit, 6) for value, unit in zip(loop.parameters.values(), loop.units, strict=False)]
    head = "| order | gain margin | largest delay | delay margin | pole | response | "
    head += " | ".join(f"{name} fitted" for name in names) + " |"
    exact_row = [f"{truth.gain_margin:.4f}", with_unit(truth.largest_delay, "s", 5), with_unit(truth.delay_margin, "s")]
    exact_row += [f"modulus {truth.pole:.4g} 1/s", "max " + with_unit(truth.response, loop.units[-1], 3), *given]
    rows = ["| exact | " + " | ".join(exact_row) + " |"]
    for w in wrongs[1:]:
        cells = [percent(e) for e in (w.gain_margin, w.largest_delay, w.delay_margin)]
        cells += [percent(e, signed=False) for e in (w.pole, w.response)]
        cells += [percent(w.fit[name], 1e-5) for name in names]
        rows.append(f"| {w.order} | " + " | ".join(cells) + " |")
    return (
        f"## The {loop.name}\n\n{loop.words}; disturbance: {loop.disturbance}; recording: "
        f"{with_unit(loop.horizon, 's')}.\n\n{head}\n|{'---|' * (6 + len(names))}\n" + "\n".join(rows) + "\n"
    )


def _millionths(error: float) -> str:
    return f"{1e6 * error:.0f}" if error > 1e-5 else f"{1e6 * error:.2g}"


def _doubling_table(doubling: dict[str, list[float]]) -> str:
    rows = []
    for name, errors in doubling.items():
        power = math.log(errors[0] / errors[-1]) / math.log(DOUBLING[-1] / DOUBLING[0])
        rows.append(f"| {name} | " + " | ".join(_millionths(e) for e in errors) + f" | n^-{power:.1f} |")
    return (
        "## Error of the response at doubled orders, in millionths\n\n| | "
        + " | ".join(f"order {n}" for n in DOUBLING)
        + f" | falls as |\n{'|---' * (2 + len(DOUBLING))}|\n"
        + "\n".join(rows)
        + "\n"
    )


def _order_table(found: dict[str, list[Wrong]]) -> str:
    head = (
        "## The order that suffices for an error of at most 1 %, of at most 0.1 %\n\n| | "
        + " | ".join(found)
        + " |\n"
        + "|---" * (1 + len(found))
    )
    rows = []
    for title, error in PANELS.items():
        cells = []
        for wrongs in found.values():
            orders = [smallest_order(wrongs, error, tolerance) for tolerance in (0.01, 0.001)]
            cells.append(", ".join(f"above {ORDERS[-1]}" if n is None else str(n) for n in orders))
        rows.append(f"| {title.split(',')[0]} | " + " | ".join(cells) + " |")
    return head + "|\n" + "\n".join(rows) + "\n"


def _fly_table(fly: list[FlyWrong]) -> str:
    head = (
        "## On the fly in particular\n\nCritical kd: the largest stable one at the same kp. Recovery: from the pulse's "
        "onset to the last entry into the band of +-2 deg. Noise: white, in each of 101 frames, the same "
        f"{RECORDINGS} recordings for every model; mean and standard deviation of a single estimate.\n\n"
        "| model | critical kd [1/s] | recovery [ms] | delay fitted without noise [ms] | "
        f"delay fitted with {NOISE:g} deg of noise: mean, deviation [ms] |\n|---|---|---|---|---|\n"
    )
    rows = [
        f"| {f'order {f.order}' if f.order else 'exact'} | {f.critical_kd:.2f} | {f.recovery / ms:.2f} | "
        f"{f.delay / ms:.3f} | {f.noisy_delay / ms:.2f}, {f.noisy_spread / ms:.2f} |"
        for f in fly
    ]
    return head + "\n".join(rows) + "\n"


def _form_table(forms: list[Realisation]) -> str:
    def in_words(error: float) -> str:
        # NaN is lost too; more digits than that are rounding, and differ between machines
        return "below 0.1 %" if error < 1e-3 else "below 10 %" if error < 0.1 else "lost"

    rows = [f"| {f.order} | {percent(f.ladder, signed=False)} | {in_words(f.companion)} |" for f in forms]
    return (
        "## The same approximant as a ladder and in companion form\n\nLargest error of the fly's yaw under a constant "
        "torque over 100 ms, relative to its largest yaw. Ladder: `flycontrol.delay.pade`, a lossless ladder with time "
        "in units of the delay; companion: `control.pade` turned into state space, time in seconds.\n\n"
        "| order | ladder | companion form |\n|---|---|---|\n" + "\n".join(rows) + "\n"
    )


def rounded(value: float) -> float | None:
    """Three digits above rounding, so that the same file comes out everywhere; None for what is not finite."""
    if not math.isfinite(value):
        return None
    return float(f"{value:.3g}") if abs(value) >= 1e-7 else 0.0


def as_numbers(found: dict[str, list[Wrong]], fly: list[FlyWrong]) -> str:
    """The numbers as JSON, units in the names; errors are relative."""
    loops = {
        name: {
            "exact": {"gain_margin": rounded(w[0].gain_margin), "largest_delay_s": rounded(w[0].largest_delay),
                      "delay_margin_s": rounded(w[0].delay_margin), "parameters": w[0].fit},
            "relative_errors_by_order": [
                {"order": x.order, "gain_margin": rounded(x.gain_margin), "largest_delay": rounded(x.largest_delay),
                 "delay_margin": rounded(x.delay_margin), "pole": rounded(x.pole), "response": rounded(x.response),
                 "fit": {key: rounded(v) if abs(v) >= 1e-5 else 0.0 for key, v in x.fit.items()}}
                for x in w[1:]
            ],
        }
        for name, w in found.items()
    }  # fmt: skip
    of_fly = [
        {"order": f.order, "critical_kd_1_per_s": float(f"{f.critical_kd:.6g}"),
         "recovery_s": float(f"{f.recovery:.5g}"), "fitted_delay_s": float(f"{f.delay:.5g}"),
         "noisy_delay_mean_s": rounded(f.noisy_delay), "noisy_delay_deviation_s": rounded(f.noisy_spread)}
        for f in fly
    ]  # fmt: skip
    return json.dumps({"seed": SEED, "loops": loops, "fly": of_fly}, indent=2) + "\n"


def main(folder: Path = FOLDER) -> Findings:
    """Compare, draw and write."""
    fly = read_parameters()
    loops = [fly_loop(fly), *textbook_loops()]
    found = {loop.name: compare(loop) for loop in loops}
    of_fly = [fly_says(loops[0], fly.tolerance.value / deg, order) for order in (0, 1, 2, 3, 4)]
    forms = [realisation(loops[0], fly.damping_rate, order) for order in (4, 8, 10, 12, 16)]
    doubling = {loop.name: [response_error(loop, order) for order in DOUBLING] for loop in loops}
    findings = Findings(loops=found, fly=of_fly, forms=forms, doubling=doubling)
    text = as_text(loops, findings)
    write_files_atomically(
        folder,
        {
            "pade_or_exact.md": text,
            "pade_or_exact.json": as_numbers(found, of_fly),
            "pade_or_exact.svg": draw(loops, found),
        },
    )
    print(text)
    return findings


if __name__ == "__main__":
    main(folder_named(__file__, __doc__, FOLDER))
