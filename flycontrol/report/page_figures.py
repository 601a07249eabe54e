"""The page's figures, each with a caption that states what it shows, with its number."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure

from flycontrol.delay.locus import AxisCrossing
from flycontrol.model.gains import ChosenGains
from flycontrol.model.loci import MARKED_DELAYS, MARKED_FACTORS
from flycontrol.model.study import StabilityStudy
from flycontrol.report.chain import LoopChain
from flycontrol.report.figures.bode import bode
from flycontrol.report.figures.budget import budget, phase_budget
from flycontrol.report.figures.chart import gain_chart, shows_second_pair
from flycontrol.report.figures.damping import p_against_pd
from flycontrol.report.figures.locus import LocusReading, nearest_crossing, root_loci
from flycontrol.report.figures.nyquist import nyquist
from flycontrol.report.figures.recovery import recoveries
from flycontrol.report.figures.strength import recovery_against_strength
from flycontrol.report.numbers import brief, degrees, fixed, milliseconds, significant
from flycontrol.report.style import svg
from flycontrol.report.verdict import own_row
from flycontrol.units import deg, ms


@dataclass(frozen=True, slots=True, kw_only=True)
class PageFigure:
    """A drawing and its words."""

    name: str  #: unique within the page
    title: str  #: says what is drawn; read aloud in place of the drawing
    caption: str  #: states what it shows
    drawing: str  #: inline SVG


def page_figures(study: StabilityStudy, chain: LoopChain, wingbeat_frequency: float) -> dict[str, PageFigure]:
    """Draw every figure that the study has parts for, by name."""
    drawn = [
        _bode(study),
        _nyquist(study),
        _budget(study, chain),
        _gain_locus(study),
        _delay_locus(study),
        _chart(study),
        _recoveries(study, wingbeat_frequency),
        _strength(study, wingbeat_frequency),
        _damping(study),
    ]
    return {figure.name: figure for figure in drawn if figure is not None}


def _page_figure(name: str, figure: Figure, title: str, caption: str) -> PageFigure:
    return PageFigure(name=name, title=title, caption=caption, drawing=svg(figure, name, title))


def _bode(study: StabilityStudy) -> PageFigure:
    margins, shape = study.result.margins, study.shape
    agreement = (
        f"The Padé approximation of order {shape.pade_order} has the exact magnitude; its phase is off by 1° from "
        f"{fixed(shape.pade_errs_from, 1, 'rad/s')} on."
        if np.isfinite(shape.pade_errs_from)
        else f"The Padé approximation of order {shape.pade_order} has the exact magnitude; its phase is off by less "
        "than 1° here."
    )
    if margins is None:
        finding = "The closed loop is unstable, so no margins are marked. "
    else:
        finding = (
            f"The exact loop has a gain margin of {fixed(margins.gain_margin, 2)} and a phase margin of "
            f"{degrees(margins.phase_margin)}. "
        )
    figure = bode(shape, margins, study.result.loop.delay)
    return _page_figure("bode", figure, "Bode diagram of the open loop", finding + agreement)


def _nyquist(study: StabilityStudy) -> PageFigure:
    margins, found = study.result.margins, study.shape.nyquist
    figure = nyquist(study.shape, margins)
    side = "right" if study.result.loop.kp >= 0 else "left"
    ends = f"Towards ω = 0 both branches leave the picture and close through a large half circle on the {side}"
    if margins is not None:
        caption = (
            f"The loop passes −1 on the safe side at a distance of {fixed(margins.modulus_margin, 3)}, nearest at "
            f"{fixed(margins.modulus_frequency, 0, 'rad/s')}; exact and Padé curves cannot be told apart here. {ends}."
        )
    elif found.count is None:
        caption = f"The curve runs through −1, so a pole lies on the imaginary axis. {ends}."
    else:
        times = {1: "once", 2: "twice"}.get(found.count, f"{found.count} times")
        caption = (
            f"With the large half circle the curve goes round −1 {times} clockwise (counted with a certificate), and "
            f"the open loop has {found.open_loop_unstable or 'no'} unstable poles: the closed loop has "
            f"{found.closed_loop_unstable}. {ends}, since the heading integrates the yaw rate."
        )
    return _page_figure("nyquist", figure, "Nyquist diagram of the open loop", caption)


def _budget(study: StabilityStudy, chain: LoopChain) -> PageFigure | None:
    margins = study.result.margins
    if margins is None or not len(margins.gain_crossovers):
        return None
    omega = float(margins.gain_crossovers[-1])
    steps = dict(budget(chain.chain, omega))
    late, body = -steps.get("reaction delay", 0.0), -steps["body"]
    caption = (
        f"At the gain crossover, {fixed(omega, 1, 'rad/s')}, the reaction delay costs {fixed(late, 1)}° and the body "
        f"{fixed(body, 1)}°; the halteres, sensing yaw rate, give 90° back, and "
        f"{degrees(margins.phase_margin)} are left. Hinge and paddling turn no phase in this model."
    )
    figure = phase_budget(chain.chain, margins)
    return _page_figure("budget", figure, "Phase of each element at the gain crossover", caption)


def _gain_locus(study: StabilityStudy) -> PageFigure:
    reading = LocusReading(own=1.0, labels=MARKED_FACTORS, scale=1.0, unit="×")
    end = nearest_crossing(study.gain_locus, 1.0)
    bound = "" if end is None else f"{fixed(end.value, 2)} times the gains of this loop"
    low, high = study.gain_locus.values[[0, -1]]
    moved = f"both gains together go from {significant(low, 2)} to {significant(high, 3)} times this loop’s"
    caption = _locus_caption(moved, bound, end, study)
    return _page_figure("gain-locus", root_loci(study.gain_locus, reading), "Root locus in the gain", caption)


def _delay_locus(study: StabilityStudy) -> PageFigure:
    delay = study.result.loop.delay
    reading = LocusReading(own=delay, labels=MARKED_DELAYS, scale=1 / ms, unit=" ms")
    end = nearest_crossing(study.delay_locus, delay)
    bound = "" if end is None else f"a delay of {milliseconds(end.value)}"
    low, high = study.delay_locus.values[[0, -1]]
    moved = f"the reaction delay alone goes from {brief(low)} to {brief(high)}"
    caption = _locus_caption(moved, bound, end, study)
    return _page_figure("delay-locus", root_loci(study.delay_locus, reading), "Root locus in the delay", caption)


def _locus_caption(what: str, bound: str, end: AxisCrossing | None, study: StabilityStudy) -> str:
    start = f"Exact closed-loop poles as {what}, where the branches end; upper half plane. "
    if end is None:
        return start + "No pole crosses the imaginary axis in this range."
    turns = end.frequency / (2 * np.pi)
    side = "is reached" if study.result.stable else "lies"
    return (
        start + f"The boundary of stability {side} at {bound}, where the loop oscillates at {fixed(turns, 1, 'Hz')}. "
        "Right: the train of poles that the delay brings."
    )


def _chart(study: StabilityStudy) -> PageFigure | None:
    plane, slice_, delay = study.plane, study.delay_slice, study.result.loop.delay
    if plane is None:
        return None
    many = len(plane.chart.x.values)
    right = (
        "No delay is stable with these gains, so the plane of gain and delay is left out."
        if slice_ is None
        else "Right: the largest stable delay against a common factor on both gains, by the closed form"
        + ("; above the thin line a second pair of roots is unstable. " if shows_second_pair(slice_) else ". ")
    )
    caption = (
        f"Left: all PD gains at this fly’s damping and its delay of {milliseconds(delay)}; numbers count the unstable "
        "roots of a region. Exact: the heavy curve, on which a pair of roots lies on the imaginary axis "
        "(over inertia, the proportional gain ω² cos ωT + bω sin ωT and the derivative gain ω sin ωT − b cos ωT), the "
        f"line of no proportional gain, where a root lies at the origin, and the star. {right}Read between points of "
        f"a grid, {many} by {many}: shades of the decay rate, certified at each point, and the lines of equal modulus "
        "margin."
    )
    figure = gain_chart(plane, slice_, study.result.margins, delay)
    return _page_figure("chart", figure, "Stability chart", caption)


def _recoveries(study: StabilityStudy, wingbeat_frequency: float) -> PageFigure | None:
    found, result = study.recoveries, study.result
    if found is None:
        return None
    wrong = float(np.abs(found.yaw_pade - found.yaw).max())
    least = float((found.torque * result.loop.plant.inertia).min()) / 1e-9
    caption = (
        f"Pulses of one duration and several strengths, by peak deflection. The fly answers one delay, "
        f"{milliseconds(result.loop.delay)}, after the pulse begins, with up to {fixed(-least, 2, 'nN m')} against the "
        f"{fixed(found.peaks[-1] / deg, 0)}° deflection. The Padé approximation of order {found.pade_order} errs by up "
        f"to {fixed(wrong / deg, 2)}° (lowest panel, Padé less exact). Shaded: pulse, and band of "
        f"±{significant(result.task.tolerance / deg)}°."
    )
    figure = recoveries(found, result, wingbeat_frequency)
    return _page_figure("recoveries", figure, "Yaw recovery from pulses of several strengths", caption)


def _strength(study: StabilityStudy, wingbeat_frequency: float) -> PageFigure | None:
    curve, result = study.curve, study.result
    if curve is None:
        return None
    tolerance, peak = result.task.tolerance, result.task.peak
    late = slope(study, peak, 2 * peak)
    jumps = ", ".join(degrees(float(jump)) for jump in curve.jumps)
    caption = (
        f"From {degrees(peak, 0)} to {degrees(2 * peak, 0)} it takes on average {fixed(late, 2)} ms a degree more. "
    )
    if 3 * tolerance < peak:
        early = slope(study, 1.5 * tolerance, 3 * tolerance)
        shape = "A sharp rise, then a plateau: on" if late < 0.2 * early else "On"
        caption = (
            f"{shape} average {fixed(early, 2)} ms a degree from {degrees(1.5 * tolerance, 0)} to "
            f"{degrees(3 * tolerance, 0)} and {fixed(late, 2)} ms a degree from {degrees(peak, 0)} to "
            f"{degrees(2 * peak, 0)}. "
        )
    caption += (
        f"At {jumps} a later swing leaves the band and the recovery time jumps: the curve is broken there, full and "
        "open circles are the values before and after."
        if jumps
        else f"No later swing leaves the band up to {fixed(curve.peaks[-1] / deg, 0)}°: no jumps."
    )
    figure = recovery_against_strength(curve, result, wingbeat_frequency, study.deadline)
    return _page_figure("strength", figure, "Recovery time against perturbation strength", caption)


def slope(study: StabilityStudy, low: float, high: float) -> float:
    """Mean slope of recovery time between two peak deflections [rad], in ms/deg."""
    assert study.curve is not None
    first, last = np.interp([low, high], study.curve.peaks, study.curve.times)
    return float((last - first) / ms / ((high - low) / deg))


def _damping(study: StabilityStudy) -> PageFigure:
    row = own_row(study)
    need = study.proportional_suffices_from
    at_own = "" if row is None else (
        f"At this fly's damping the best P needs {milliseconds(row.proportional.recovery_time)}, and the best PD with "
        f"a modulus margin of at least 0.5 needs {milliseconds(row.derivative.recovery_time)}. "
    )  # fmt: skip
    cliff = "" if row is None else _cliff("P", row.proportional) + _cliff("PD", row.derivative)
    enough = "" if need is None else f"P alone meets {brief(study.deadline)} from β/I = {need:.0f} 1/s on."
    own = study.result.loop.plant.damping_rate
    figure = p_against_pd(study.damping_table, study.deadline, need, own)
    return _page_figure("damping", figure, "Best P against best PD over the yaw damping", at_own + cliff + enough)


def _cliff(name: str, best: ChosenGains) -> str:
    """Say that an optimum stands where recovery jumps, if it does."""
    if not best.nearby > 1.1 * best.recovery_time:
        return ""
    worse = f"takes up to {milliseconds(best.nearby)}" if np.isfinite(best.nearby) else "fails or takes far longer"
    return (
        f"That best {name} stands on a cliff: with gains 1 % off a later swing leaves the band and recovery {worse}. "
    )
