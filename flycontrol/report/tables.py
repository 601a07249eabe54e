"""The rows of the page's tables: every number already written as a reader sees it."""

from __future__ import annotations

import math
from dataclasses import dataclass

from flycontrol.model.chain import Link
from flycontrol.model.gains import ChosenGains
from flycontrol.model.parameters import Parameters, Sourced
from flycontrol.model.study import StabilityStudy
from flycontrol.report.chain import DRAG_SLOPE, MU, STROKE, LoopChain
from flycontrol.report.numbers import fixed, milliseconds, root, significant, typeset
from flycontrol.report.result import pade_error
from flycontrol.report.verdict import own_row
from flycontrol.units import ms

_NAMES: dict[str, tuple[str, str]] = {
    "inertia": ("inertia about the vertical", "<i>I</i>"),
    "damping": ("flapping counter-torque", "β"),
    "wingbeat_frequency": ("wingbeat frequency", "<i>f</i>"),
    "proportional_gain": ("proportional gain over inertia", "<i>K</i><sub>P</sub>/<i>I</i>"),
    "derivative_gain": ("derivative gain over inertia", "<i>K</i><sub>D</sub>/<i>I</i>"),
    "delay": ("reaction delay", "<i>T</i>"),
    "pulse_duration": ("pulse duration", ""),
    "pulse_peak": ("peak deflection of the nominal pulse", "ψ<sub>max</sub>"),
    "tolerance": ("half width of the recovery band", ""),
    "deadline": ("recovery time that is held against", ""),
    "paddling_gain": ("paddling torque by paddling angle", "γ"),
    "damping_low": ("low end of the damping range", "β/<i>I</i>"),
    "damping_high": ("high end of the damping range", "β/<i>I</i>"),
}


@dataclass(frozen=True, slots=True, kw_only=True)
class ParameterRow:
    """One sourced number, or one that follows from others."""

    words: str
    symbol: str  #: HTML of this module's own making
    value: str
    source: str = ""
    giver: str = "user"  #: who gave it, where there is no source
    certainty: str = ""
    note: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class LinkRow:
    """One element of the chain."""

    name: str
    reads: str
    gives: str
    formula: str


@dataclass(frozen=True, slots=True, kw_only=True)
class ModeRow:
    """One mode."""

    pole: str
    time: str
    frequency: str
    ratio: str
    error: str


@dataclass(frozen=True, slots=True, kw_only=True)
class GainsRow:
    """Best P and PD at one damping."""

    b: str
    own: bool
    cells: tuple[str, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class PadeRow:
    """The rightmost pole with the delay approximated."""

    order: int
    pole: str
    error: str


def parameter_rows(parameters: Parameters) -> list[ParameterRow]:
    """All numbers of the parameter file, then those of the chain."""
    rows = [_sourced(*_NAMES[name], number) for name, number in parameters.sourced().items()]
    chain = (("transmission of the hinge", "μ", MU), ("stroke amplitude", "Φ", STROKE))
    slope = ("slope of the drag coefficient", "<i>C</i>′<sub>D</sub>/2<i>C</i><sub>D</sub>", DRAG_SLOPE)
    return rows + [_sourced(*row) for row in (*chain, slope)]


def _sourced(words: str, symbol: str, number: Sourced) -> ParameterRow:
    return ParameterRow(
        words=words,
        symbol=symbol,
        value=typeset(number.text) or significant(number.value, 6, number.unit),
        source=number.source,
        giver={"fit": "this fit", "fixed": "this fit"}.get(number.certainty, "user"),
        certainty=number.certainty,
        note=typeset(number.note),
    )


def derived_rows(study: StabilityStudy, parameters: Parameters, chain: LoopChain) -> list[ParameterRow]:
    """Quantities that follow from the parameters."""
    loop, pulse = study.result.loop, study.result.pulse
    torque = None if pulse is None else pulse.torque
    rows = [
        ("yaw damping over inertia", "β/<i>I</i>", fixed(loop.plant.damping_rate, 1, "1/s")),
        ("proportional gain", "<i>K</i><sub>P</sub>", significant(loop.controller.proportional, 3, "N m/rad")),
        ("derivative gain", "<i>K</i><sub>D</sub>", significant(loop.controller.derivative, 3, "N m s/rad")),
        ("reaction delay", "<i>T f</i>", fixed(parameters.delay_in_wingbeats, 2, "wingbeats")),
        ("torque of the nominal pulse", "<i>N</i><sub>ext</sub>", significant(torque, 3, "N m")),
        ("mean angular speed of the wings", "ω = 2 Φ <i>f</i>", fixed(chain.omega, 0, "rad/s")),
    ]  # fmt: skip
    if parameters.paddling_gain is None:
        by_drag = "γ = β ω <i>C</i>′<sub>D</sub>/2<i>C</i><sub>D</sub>"
        rows.append(("paddling torque by paddling angle", by_drag, significant(chain.gamma, 3, "N m/rad")))
    return [ParameterRow(words=words, symbol=symbol, value=value) for words, symbol, value in rows]


def link_rows(chain: LoopChain) -> list[LinkRow]:
    """Elements of the chain in order."""
    return [
        LinkRow(name=link.name.partition(" (")[0], reads=link.reads, gives=link.gives, formula=_formula(link))
        for link in chain.chain.links
    ]


def _formula(link: Link) -> str:
    top, bottom = _polynomial(link.numerator), _polynomial(link.denominator)
    ratio = top if bottom == "1" else f"{_bracketed(top)} / {_bracketed(bottom)}"
    return ratio + (f" · exp(−s {milliseconds(link.delay)})" if link.delay else "")


def _polynomial(coefficients: tuple[float, ...]) -> str:
    terms: list[str] = []
    for k, c in enumerate(coefficients):
        power = len(coefficients) - 1 - k
        if c == 0:
            continue
        symbol = ("", "s", "s²")[power]
        number = "" if c == 1 and symbol else significant(c, 3)
        terms.append(" ".join(part for part in (number, symbol) if part))
    return " + ".join(terms) or "0"


def _bracketed(text: str) -> str:
    return f"({text})" if "+" in text else text


def mode_rows(study: StabilityStudy) -> list[ModeRow]:
    """The listed modes, slowest first."""
    result = study.result
    errors = [float(e) for pole, e in zip(result.poles, result.pole_errors, strict=True) if pole.imag >= 0]
    return [
        ModeRow(
            pole=root(mode.root, 2), time=fixed(mode.time_constant / ms, 2), frequency=fixed(mode.frequency, 1),
            ratio=fixed(mode.damping_ratio, 3), error=significant(error, 1),
        )
        for mode, error in zip(result.modes, errors, strict=True)
    ]  # fmt: skip


def damping_rows(study: StabilityStudy) -> list[GainsRow]:
    """Best P and PD at each damping."""
    mine = own_row(study)
    return [
        GainsRow(
            b=fixed(row.b, 1), own=row is mine,
            cells=(*_gains(row.proportional, derivative=False), *_gains(row.derivative, derivative=True)),
        )
        for row in study.damping_table
    ]  # fmt: skip


def _gains(chosen: ChosenGains, *, derivative: bool) -> tuple[str, ...]:
    kd = (fixed(chosen.kd, 1),) if derivative else ()
    times = (milliseconds_only(chosen.recovery_time), milliseconds_only(chosen.nearby))
    return (fixed(chosen.kp, 0), *kd, *times, fixed(chosen.modulus_margin, 3))


def milliseconds_only(seconds: float) -> str:
    """Write a time given in seconds as a number of ms, for a column whose head has the unit."""
    return fixed(seconds / ms, 1)


def pade_rows(study: StabilityStudy) -> list[PadeRow]:
    """Rightmost pole of the Pade loop by order."""
    return [
        PadeRow(order=order, pole=root(complex(poles[0]), 4), error=significant(pade_error(study, poles), 2))
        for order, poles in sorted(study.pade_poles.items())
    ]


def exact_pole(study: StabilityStudy) -> str:
    """Rightmost exact pole."""
    return root(complex(study.result.poles[0]), 4)


def exact_error(study: StabilityStudy) -> str:
    """Estimate of its error: the last Newton step."""
    return significant(float(study.result.pole_errors[0]), 1) + " (estimated)"


def poles_check(study: StabilityStudy) -> str:
    """Say whether a count by the argument principle found other poles as far right."""
    status = study.result.poles_status
    if status == "certified":
        return "Certified: a count by the argument principle found no other pole as far right as these."
    if status.startswith("certified"):
        return f"{status[0].upper()}{status[1:]}."
    return f"The count by the argument principle does not confirm that none is missing: {status}."


def delay_check(study: StabilityStudy) -> str:
    """Set the closed form of the largest stable delay against the number from the margins."""
    closed, result = study.closed_form_largest_delay, study.result
    if closed is None:
        return "The closed form of the largest stable delay does not apply: it needs a positive "
        "proportional gain and a positive sum of derivative gain and damping."
    form = f"The closed form for PD control puts the largest stable delay at {milliseconds(closed, 4)}"
    if result.margins is None:
        return f"{form}, below this loop’s {milliseconds(result.loop.delay, 4)}: unstable, as found from the poles."
    numeric = result.loop.delay + result.margins.delay_margin
    return (
        f"{form}; delay plus delay margin, by root-finding on the frequency response, give {milliseconds(numeric, 4)}: "
        f"they agree within {significant(_bound(numeric - closed, closed) / ms, 1, 'ms')}."
    )


def _bound(difference: float, size: float) -> float:
    """The power of ten next above a difference, but not below what rounding leaves open."""
    return 10.0 ** math.ceil(math.log10(max(abs(difference), 1e-12 * size)))


def chart_check(study: StabilityStudy) -> str:
    """Say where the loop lies among all gains, and how often count and closed form agree on the chart."""
    plane, slice_ = study.plane, study.delay_slice
    if plane is None:
        return "Without a delay no gain is too high, so no stability chart is drawn."
    charts = [plane, *([] if slice_ is None else [slice_])]
    points, agreeing = sum(part.chart.stable.size for part in charts), sum(part.agreeing for part in charts)
    rate = -float(study.result.poles[0].real)
    place = (
        f"The slowest mode of this loop decays at {fixed(rate, 1, '1/s')}; over all gains the fastest that it could be "
        f"is {fixed(plane.fastest_rate, 1, '1/s')}, a closed form, with a proportional gain over inertia of "
        f"{fixed(plane.fastest[0], 0, '1/s²')} and a derivative gain over inertia of "
        f"{fixed(plane.fastest[1], 1, '1/s')}, where three real roots meet."
        if rate > 0
        else f"These gains lie outside the stable region; the fastest decay that gains could give this plant is "
        f"{fixed(plane.fastest_rate, 1, '1/s')}."
    )
    same = "every one" if agreeing == points else f"{agreeing}"
    return (
        f"{place} Unstable roots were counted by the argument principle at {points} points of the chart: at {same} of "
        "them the count and the closed form for PD control give the same verdict on stability."
    )
