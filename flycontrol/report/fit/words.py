"""How estimates are written: words, symbols, everyday units, as many digits as their error deserves."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass

import numpy as np

from flycontrol.identify.gains.apart import differ
from flycontrol.identify.gains.model import GAINS
from flycontrol.identify.gains.result import Estimate, FitResult
from flycontrol.identify.gains.ridge import Ridge
from flycontrol.identify.gains.study import FitStudy
from flycontrol.report.numbers import ABSENT, counted, fixed, significant
from flycontrol.units import deg, ms

#: Words, symbol in HTML, unit as written, and its size in the unit of the estimate.
KINDS: dict[str, tuple[str, str, str, float]] = {
    "kp": ("proportional gain over inertia", "<i>K</i><sub>P</sub>/<i>I</i>", "1/s²", 1.0),
    "kd": ("derivative gain over inertia", "<i>K</i><sub>D</sub>/<i>I</i>", "1/s", 1.0),
    "ki": ("integral gain over inertia", "<i>K</i><sub>I</sub>/<i>I</i>", "1/s³", 1.0),
    "delay": ("reaction delay", "<i>T</i>", "ms", ms),
    "damping": ("yaw damping over inertia", "β/<i>I</i>", "1/s", 1.0),
    "limit": ("largest torque of paddling over inertia", "<i>N</i><sub>max</sub>/<i>I</i>", "1/s²", 1.0),
    "impulse": ("angular impulse of the perturbation over inertia", "∫<i>N</i><sub>ext</sub>/<i>I</i>", "rad/s", 1.0),
    "onset_shift": ("shift of the onset", "Δ<i>t</i>", "ms", ms),
    "initial_yaw": ("yaw at the first sample", "ψ(0)", "deg", deg),
    "initial_rate": ("yaw rate at the first sample", "ψ̇(0)", "rad/s", 1.0),
    "heading": ("heading that the fly keeps", "ψ<sub>0</sub>", "deg", deg),
    "paddling_gain": ("paddling torque by angle, over inertia", "γ/<i>I</i>", "1000/s² per rad", 1e3),
}
_MOST_OF_IT = 0.5  #: share of a ridge's window from which there is no valley in it
_TERMS = {"kp": "K_P psi", "kd": "K_D psi'", "ki": "K_I integral of psi"}
OF_THE_LOOP = ("kp", "kd", "ki", "delay", "damping", "limit", "paddling_gain")


@dataclass(frozen=True, slots=True, kw_only=True)
class EstimateRow:
    """One estimate, ready to be read."""

    words: str
    symbol: str  #: HTML of this module's own making
    plain: str  #: the symbol as text
    owner: str  #: fly or recording; empty: all share it
    value: str
    interval: str
    error: str
    unit: str
    note: str


def estimate_rows(result: FitResult, *, of_the_loop: bool = True) -> list[EstimateRow]:
    """Estimates of the loop, or those of single recordings; what was fixed comes after."""
    rows = [_row(e) for e in result.estimates if (e.kind in OF_THE_LOOP) == of_the_loop]
    known = result.problem.model.known
    return rows + [_fixed_row(name, known[name]) for name in known if (name in OF_THE_LOOP) == of_the_loop]


def _row(e: Estimate) -> EstimateRow:
    words, symbol, unit, size = KINDS[e.kind]
    digits = digits_for(e.standard_error / size, e.value / size)
    ends = [fixed(end / size, digits) if math.isfinite(end) else "open" for end in (e.low, e.high)]
    notes = [e.open_because] if e.open_because else []
    notes += ["at its bound"] if e.at_bound else []
    return EstimateRow(
        words=words, symbol=symbol, plain=plain(symbol), owner=owner(e), value=_value(e, size, digits),
        interval=_ends(ends), error=fixed(e.standard_error / size, digits) if _finite(e) else ABSENT, unit=unit,
        note="; ".join(notes),
    )  # fmt: skip


def _ends(ends: list[str]) -> str:
    return "open" if ends == ["open", "open"] else " to ".join(ends)


def _value(e: Estimate, size: float, digits: int) -> str:
    if e.undetermined:
        return ABSENT
    return fixed(e.value / size, digits) if math.isfinite(e.value) else "none reached"


def _finite(e: Estimate) -> bool:
    return math.isfinite(e.standard_error)


def _fixed_row(name: str, value: float) -> EstimateRow:
    words, symbol, unit, size = KINDS[name]
    return EstimateRow(
        words=words, symbol=symbol, plain=plain(symbol), owner="", value=significant(value / size, 6),
        interval="fixed", error=ABSENT, unit=unit, note="",
    )  # fmt: skip


def owner(e: Estimate) -> str:
    """Fly or recording that an estimate belongs to; empty if all share it."""
    return e.name[len(e.kind) + 1 : -1]


def digits_for(error: float, value: float) -> int:
    """Digits after the point that show two of the error's digits; four of the value's where there is no error."""
    size = error if math.isfinite(error) and error > 0 else abs(value) / 100
    if not (math.isfinite(size) and size > 0):
        return 1
    return min(max(1 - math.floor(math.log10(size)), 0), 9)


def in_symbols(text: str) -> str:
    """A sentence of the fit with gains written as in the tables: K_P/I for kp."""
    return re.sub(r"\b(kp|kd|ki)\b", lambda name: plain(KINDS[name[1]][1]), text)


def plain(symbol: str) -> str:
    """Turn a symbol in HTML into text: K_P."""
    for tag, text in (("<sub>", "_"), ("</sub>", ""), ("<i>", ""), ("</i>", "")):
        symbol = symbol.replace(tag, text)
    return symbol


def differing_flies(study: FitStudy) -> str:
    """What pooled intervals leave out where the flies differ: means over flies with their intervals; else empty."""
    flies = study.flies
    if flies is None or not differ(flies):
        return ""
    said: list[str] = []
    for effect in flies.effects:
        _, symbol, unit, size = KINDS[effect.kind]
        digits = digits_for((effect.mean_high - effect.mean_low) / 4 / size, effect.mean / size)
        mean, low, high, spread = (
            fixed(v / size, digits) for v in (effect.mean, effect.mean_low, effect.mean_high, effect.deviation)
        )
        said.append(f"{plain(symbol)} {mean} {unit} ({low} to {high}, standard deviation between flies {spread})")
    return (
        "The flies differ, so the intervals of the pooled fit are not those of a population; "
        f"over {flies.effects[0].count if flies.effects else 0} flies: {'; '.join(said)}."
    )


def paper_table(study: FitStudy) -> str:
    """A table to paste in a paper, in Markdown: what all recordings share, with intervals and units."""
    result = study.result
    level = f"{100 * result.level:g} % interval"
    lines = [
        f"| parameter | symbol | estimate | {level} | standard error | unit |",
        "|---|---|---|---|---|---|",
    ]
    for row in estimate_rows(result):
        cells = (f"{row.words} {row.owner}".strip(), row.plain, row.value, row.interval, row.error, row.unit)
        lines.append(f"| {' | '.join(cells)} |")
    trials, flies = result.problem.trials, {trial.fly for trial in result.problem.trials}
    terms = " + ".join(_TERMS[gain] for gain in GAINS[result.controller])
    who = f"{counted(len(trials), 'recording')} of {counted(len(flies), 'fly', 'flies')}"
    foot = (
        f"{result.controller} control of the yaw angle, N_fly = -({terms})(t - T), restoring gains positive, fitted "
        f"to {who}. Status: {in_symbols(result.status)}"
    )
    return "\n".join([*lines, "", " ".join([foot, differing_flies(study)]).strip()]) + "\n"


def ridge_words(ridge: Ridge) -> str:
    """What a ridge shows, in sentences without markup."""
    (one, other), inside = ridge.names, ridge.inside
    ends = []
    for name, axis, held in ((one, ridge.first, inside.any(axis=1)), (other, ridge.second, inside.any(axis=0))):
        words, _, unit, size = KINDS[name]
        reached = axis[held] / size
        step = float(axis[1] - axis[0]) / size
        digits = digits_for(step, float(np.abs(reached).max()))
        ends.append(f"{words} from {fixed(float(reached[0]), digits)} to {fixed(float(reached[-1]), digits, unit)}")
    further = [
        f"{'smaller' if side.endswith('down') else 'larger'} {KINDS[side.split()[0]][0]}" for side in ridge.open_ends
    ]
    edge = f" It goes on beyond the window, towards {' and '.join(further)}." if further else ""
    together = ", as long as both move together" if inside.mean() < _MOST_OF_IT else ": almost any pair will do"
    return (
        "Shaded: the least deviance over two unknowns, all others fitted again at each point; line: the threshold that "
        "an interval ends at; black dots: the floor of the valley; red square: the estimate. Right: the floor’s depth. "
        f"The data go along with {ends[0]} and {ends[1]}{together}.{edge}"
    )
