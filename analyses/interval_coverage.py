"""How often do 95 % intervals of gains, delay and damping hold the truth, and how far off are the estimates on average?

Run with `python analyses/interval_coverage.py [FOLDER]`; figure and numbers go to reports/coverage unless a folder is
given. It takes about ten minutes on two free cores; an interrupted run goes on where it was.
"""

import hashlib
import io
import json
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import scipy.signal
import scipy.stats
from _by_hand import REPORTS, ROOT, folder_named
from _opened import opened

from flycontrol.identify.gains.fit import fit_gains
from flycontrol.identify.gains.model import gain_model
from flycontrol.identify.gains.response import yaw_response
from flycontrol.jobs.checkpoint import Checkpoint
from flycontrol.jobs.files import write_files_atomically
from flycontrol.jobs.seeded_map import seeded_map
from flycontrol.jobs.work import Work
from flycontrol.model.trial import Pulse, Trial
from flycontrol.units import deg, ms

if TYPE_CHECKING:
    from matplotlib.axes import Axes

FOLDER = REPORTS / "coverage"
RECORDINGS = 5000

# ## The question
#
# An interval is a promise: of all 95 % intervals, 95 % hold the truth. A fit that breaks it misleads the more the more
# carefully it is read. The promise is kept or broken by the noise model as much as by the solver, so the recordings
# here come with two kinds of noise: white, and coloured as tracking noise is.
#
# Each recording is the nominal fly, knocked by a 4.5 ms pulse after 10 ms of rest and filmed for 100 ms at 8 kHz: 801
# samples with noise of 0.3 deg. Coloured noise has a correlation of 0.9 between neighbouring samples, hence a
# correlation time of 1.2 ms. Recording number s has seed s; nothing was left out.

TRUTH = {"kp": 3050.0, "kd": 45.0, "delay": 13.6 * ms, "damping": 69.0, "impulse": 35.0}
PULSE = Pulse(onset=10 * ms, duration=4.5 * ms)
TIMES = np.arange(801) / 8000
DEVIATION = 0.3 * deg
KINDS = {"white": 0.0, "coloured": 0.9}
SHARED = ("kp", "kd", "delay", "damping")


def recording(seed: int, correlation: float) -> Trial:
    """The nominal fly with noise of its own."""
    innovations = np.random.default_rng(seed).standard_normal(len(TIMES) + 1000)
    noise = scipy.signal.lfilter([np.sqrt(1 - correlation**2)], [1, -correlation], innovations)[1000:]
    yaw = yaw_response(TRUTH, TIMES, PULSE).yaw + DEVIATION * noise
    return Trial(name="fly", time=TIMES, yaw=yaw, rate=8000.0, perturbation=PULSE)


# ## The fits
#
# Gains, delay, the pulse's impulse and the heading are unknown; damping is either unknown too, or fixed at the truth as
# if it had been measured. Nothing else is told to the fit: no starting values, no kind of noise, no order of its model.


def fitted(kind: str, free: bool, seed: int, rng: np.random.Generator) -> np.ndarray:
    """Least-squares value, estimate, standard error, ends of the interval and whether a profile gave it (4, 6)."""
    del rng  # the recording's seed is its number
    known = {"initial_yaw": 0.0, "initial_rate": 0.0} | ({} if free else {"damping": TRUTH["damping"]})
    found = fit_gains([recording(seed, KINDS[kind])], gain_model(fixed=known))
    rows = np.full((len(SHARED), 6), np.nan)
    for row, name in zip(rows, SHARED, strict=True):
        if name in found.problem.names and found.converged:
            e = found[name]
            row[:] = e.value + e.bias, e.value, e.standard_error, e.low, e.high, e.method == "profile"
    return rows


@dataclass(frozen=True, slots=True, kw_only=True)
class Account:
    """Of one unknown under one kind of noise."""

    noise: str
    damping: str  #: "free" or "fixed"
    name: str
    recordings: int  #: that gave an interval
    inside: int  #: of them held the truth
    bias: float  #: mean error of the estimates, in standard errors
    bias_of_least_squares: float  #: the same before the correction
    bias_error: float  #: standard error of both
    deviation: float  #: standard deviation of the estimates over their root mean squared standard error
    profiles: int  #: intervals that came from the profile likelihood

    @property
    def coverage(self) -> float:
        """Share of intervals that held the truth."""
        return self.inside / self.recordings

    @property
    def interval(self) -> tuple[float, float]:
        """Of the coverage, Clopper and Pearson's at 95 %."""
        found = scipy.stats.binomtest(self.inside, self.recordings).proportion_ci(0.95)
        return float(found.low), float(found.high)


def account(kind: str, free: bool, name: str, rows: np.ndarray) -> Account:
    """Count what one unknown's fits (n, 6) say."""
    rows = rows[np.isfinite(rows[:, 1])]
    raw, value, error, low, high, profiled = rows.T
    truth, size = TRUTH[name], np.sqrt(np.mean(error[np.isfinite(error)] ** 2))
    return Account(
        noise=kind, damping="free" if free else "fixed", name=name, recordings=len(rows),
        inside=int(np.sum((low <= truth) & (truth <= high))), bias=float(np.mean(value - truth) / size),
        bias_of_least_squares=float(np.mean(raw - truth) / size),
        bias_error=float(np.std(value) / size / np.sqrt(len(rows))), deviation=float(np.std(value) / size),
        profiles=int(profiled.sum()),
    )  # fmt: skip


def source() -> str:
    """Hash of the code that the fits depend on, so that no unfinished run goes on with fits of another version."""
    files = sorted((ROOT / "flycontrol" / "identify" / "gains").rglob("*.py"))
    return hashlib.sha256(b"".join(path.read_bytes() for path in files)).hexdigest()


def accounts(recordings: int, workers: int, kept: Path) -> list[Account]:
    """Every kind of noise, damping fixed and free."""
    found: list[Account] = []
    for kind in KINDS:
        for free in (False, True):
            work = Work(
                task=partial(fitted, kind, free), items=range(recordings), seed=0, chunk=50,
                name=f"recordings with {kind} noise, damping {'free' if free else 'fixed'}",
            )  # fmt: skip
            checkpoint = Checkpoint(kept / f"{kind}-{'free' if free else 'fixed'}-{recordings}", identity=source())
            rows = np.array(seeded_map(work, workers, checkpoint))
            checkpoint.remove()
            asked = SHARED if free else SHARED[:3]
            found += [account(kind, free, name, rows[:, SHARED.index(name)]) for name in asked]
    return found


# ## What is asked of them
#
# With 5,000 recordings the share of intervals that hold the truth is known to 0.3 %. White noise is in the model, so
# its coverage must lie between 93.5 and 96.5 %. Coloured noise must be recognised first, and its correlation estimated
# from the residuals of one recording: at least 92 % is asked. The bias must stay under a tenth of a standard error.
# Least squares alone would break that for kd, whose curvature pushes it up; the estimates have the second-order bias
# taken off.

COLUMNS = ("noise", "damping", "unknown", "coverage [%]", "95 % interval [%]", "bias [standard errors]",
           "before correction", "deviation / standard error", "profiles")  # fmt: skip


def as_text(found: list[Account], recordings: int) -> str:
    """The numbers as a page of Markdown."""
    head = (
        f"# Coverage of 95 % intervals over {recordings} recordings a row\n\n"
        "Nominal fly, 801 samples at 8 kHz, noise 0.3 deg; coloured: correlation 0.9 between neighbouring samples, a "
        "correlation time of 1.2 ms.\n\n"
        f"| {' | '.join(COLUMNS)} |\n|{'---|' * len(COLUMNS)}\n"
    )
    rows = [
        f"| {a.noise} | {a.damping} | {a.name} | {100 * a.coverage:.1f} | {100 * a.interval[0]:.1f} to "
        f"{100 * a.interval[1]:.1f} | {a.bias:+.3f} +- {a.bias_error:.3f} | {a.bias_of_least_squares:+.3f} | "
        f"{a.deviation:.3f} | {a.profiles} |"
        for a in found
    ]
    return head + "\n".join(rows) + "\n\n![Coverage and bias](coverage.svg)\n"


def as_numbers(found: list[Account]) -> str:
    """The numbers as JSON."""
    rows = [
        {"noise": a.noise, "damping": a.damping, "unknown": a.name, "recordings": a.recordings, "inside": a.inside,
         "bias_standard_errors": round(a.bias, 4), "bias_of_least_squares_standard_errors":
         round(a.bias_of_least_squares, 4), "bias_error_standard_errors": round(a.bias_error, 4),
         "deviation_over_standard_error": round(a.deviation, 4), "profiles": a.profiles}
        for a in found
    ]  # fmt: skip
    return json.dumps(rows, indent=2) + "\n"


LOOK = {
    ("white", "fixed"): {"color": "#0b3954", "marker": "o", "label": "white, damping fixed"},
    ("white", "free"): {"color": "#0b3954", "marker": "s", "markerfacecolor": "white", "label": "white, damping free"},
    ("coloured", "fixed"): {"color": "#e08a00", "marker": "^", "label": "coloured, damping fixed"},
    ("coloured", "free"): {"color": "#e08a00", "marker": "v", "markerfacecolor": "white",
                           "label": "coloured, damping free"},
}  # fmt: skip


def draw(found: list[Account]) -> bytes:
    """Coverage and bias of every unknown, as SVG."""
    from flycontrol.report.style import in_house_style, new_figure

    with in_house_style():
        figure = new_figure(3.2)
        left, right = figure.subplots(1, 2)
        left.axhspan(93.5, 96.5, color="#e6edf1", zorder=0)
        left.axhline(92.0, color="#c8323c", linewidth=0.9, linestyle=(0, (4, 2)))
        right.axhspan(-0.1, 0.1, color="#e6edf1", zorder=0)
        for k, (case, look) in enumerate(LOOK.items()):
            mine = [a for a in found if (a.noise, a.damping) == case]
            x = np.array([SHARED.index(a.name) for a in mine]) + 0.16 * (k - 1.5)
            draw_case(left, right, mine, x, look)
        for ax in (left, right):
            ax.set_xticks(range(len(SHARED)), SHARED)
        left.set(ylabel="95 % intervals that hold the truth [%]", ylim=(91.4, 98.2), title="Coverage")
        right.set(ylabel="mean error [standard errors]", title="Bias, corrected; crosses: not")
        left.legend(loc="upper center", ncols=2, columnspacing=0.9, handletextpad=0.3, fontsize=7)
        buffer = io.BytesIO()
        figure.savefig(buffer, format="svg", metadata={"Date": None})
        return buffer.getvalue()


def draw_case(left: "Axes", right: "Axes", mine: list[Account], x: np.ndarray, look: dict[str, Any]) -> None:
    """One kind of noise with one kind of damping."""
    coverage = np.array([a.coverage for a in mine])
    ends = np.array([a.interval for a in mine]).T
    style = {**look, "linestyle": "none", "markersize": 5, "elinewidth": 1.1}
    left.errorbar(x, 100 * coverage, 100 * np.abs(ends - coverage), **style)
    right.errorbar(x, [a.bias for a in mine], [1.96 * a.bias_error for a in mine], **style)
    right.plot(x, [a.bias_of_least_squares for a in mine], "x", color=look["color"], markersize=4)


# ## The answer
#
# The promise is kept. White noise: 95.0 to 95.5 % of the intervals hold the truth, whether damping is known or not.
# Coloured noise: 94.9 to 96.0 %. No bias exceeds 0.02 standard errors, each known to 0.014; least squares alone puts kd
# 0.26 standard errors too high when the noise is coloured and damping free, and 0.07 when it is white. In the former
# case likelihoods are so bent that most intervals of kd and damping come from their profiles.


def main(folder: Path = FOLDER, recordings: int = RECORDINGS, workers: int = 2) -> list[Account]:
    """Fit, count, draw and write."""
    found = accounts(recordings, workers, ROOT / ".cache" / "coverage")
    text = opened(__file__, as_text(found, recordings))
    write_files_atomically(
        folder, {"coverage.md": text, "coverage.json": as_numbers(found), "coverage.svg": draw(found)}
    )
    print(text)
    return found


if __name__ == "__main__":
    main(folder_named(__file__, __doc__, FOLDER))
