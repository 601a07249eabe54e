"""What a real flight says, ready for the page: figures, tables and sentences from a FlightAnalysis."""

from __future__ import annotations

from dataclasses import dataclass

from flycontrol.identify.conventions import ConventionEvidence
from flycontrol.identify.flight import FlightAnalysis
from flycontrol.identify.turns import TurnIdentification, turn_sentence
from flycontrol.identify.yaw_plant import Estimate, YawPlantFit
from flycontrol.report.figures.turn_angles import turn_angles
from flycontrol.report.figures.turning import turning
from flycontrol.report.figures.wing_motion import wing_motion
from flycontrol.report.numbers import ABSENT, degrees, fixed, sentence
from flycontrol.report.page_figures import PageFigure
from flycontrol.report.style import svg
from flycontrol.units import deg, ms


@dataclass(frozen=True, slots=True, kw_only=True)
class ConventionRow:
    """One convention with its evidence."""

    convention: str
    measure: str
    as_mapped: str
    turned: str
    difference: str
    finding: str


@dataclass(frozen=True, slots=True, kw_only=True)
class PlantRow:
    """One coefficient of Eq. 3: as it stands, with the coupling to roll, and by blade elements."""

    words: str
    symbol: str  #: HTML of this module's own making
    plain: str
    coupled: str
    blades: str


@dataclass(frozen=True, slots=True, kw_only=True)
class TurnRow:
    """One turn."""

    number: int
    time: str
    wingbeats: str
    cells: tuple[str, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class FlightPart:
    """The page's part on one recording."""

    name: str
    status: str  #: the finding in one sentence
    sentences: tuple[str, ...]  #: what tables and figures do not say
    notes: dict[str, str]  #: what the mapping says of the recording
    figures: dict[str, PageFigure]
    conventions: list[ConventionRow]
    plant: list[PlantRow]
    turns: list[TurnRow]


def flight_part(analysis: FlightAnalysis) -> FlightPart:
    """Draw and write down one analysis."""
    found = analysis.turning
    shown = {found.status, *(turn_sentence(turn) for turn in found.turns)}
    if analysis.conventions is not None:
        shown |= {test.sentence for test in analysis.conventions.tests}
    figures = [_wings(analysis), _turning(found), *([_angles(found)] if found.turns else [])]
    return FlightPart(
        name=analysis.recording.name,
        status=sentence(found.status),
        sentences=tuple(sentence(said) for said in analysis.verdicts if said not in shown),
        notes=dict(analysis.recording.notes),
        figures={figure.name: figure for figure in figures},
        conventions=[] if analysis.conventions is None else _convention_rows(analysis.conventions),
        plant=_plant_rows(analysis),
        turns=_turn_rows(found),
    )


def _wings(analysis: FlightAnalysis) -> PageFigure:
    beats = analysis.beats
    caption = (
        f"Mean and standard deviation over {beats.count} wingbeats at {fixed(beats.mean_frequency, 0, 'Hz')}; a "
        "wingbeat begins at the dorsal reversal, the dotted line is the ventral one. Stroke positive forward, "
        "deviation positive above the stroke plane, pitch between chord and stroke plane, 90° with the chord vertical."
    )
    title = "Wing angles of the recorded flight"
    return PageFigure(
        name="flight-wings", title=title, caption=caption, drawing=svg(wing_motion(analysis), "flight-wings", title)
    )


def _turning(found: TurnIdentification) -> PageFigure:
    plant = found.plant
    finding = (
        sentence(found.status)
        if plant is None or plant.paddling is None
        else f"Simulated from the paddling alone, Eq. 3 explains {plant.r2_simulated:.0%} of the yaw rate’s variance, "
        f"and {plant.r2_acceleration:.0%} of the acceleration’s from paddling and measured rate (negative: worse "
        "than the mean)."
    ).replace("-", "−")
    caption = (
        f"{finding} Each dot is a wingbeat; bars are the scatter of Δα from one wingbeat to the next, "
        f"{degrees(found.d_alpha_noise)}. Shaded and numbered: turns."
    )
    title = "Paddling, yaw rate and yaw acceleration of the recorded flight"
    return PageFigure(
        name="flight-turning", title=title, caption=caption, drawing=svg(turning(found), "flight-turning", title)
    )


def _angles(found: TurnIdentification) -> PageFigure:
    off = [abs(turn.by_wing_speed - turn.angle) / deg for turn in found.turns]
    caption = (
        f"After Fig. 5c of the review: each of the {len(off)} turns, by its number, at its measured angle. Eq. 5 "
        f"misses by {fixed(min(off), 0)}° to {fixed(max(off), 0)}°."
        if len(off) > 1
        else f"After Fig. 5c of the review, for the only turn. Eq. 5 misses it by {fixed(off[0], 0)}°."
    )
    caption += " Grey lines mark the measured angles, the diagonal a perfect prediction."
    title = "Turn angles, measured against predicted"
    return PageFigure(
        name="flight-angles",
        title=title,
        caption=caption,
        drawing=svg(turn_angles(found.turns), "flight-angles", title),
    )


def _convention_rows(evidence: ConventionEvidence) -> list[ConventionRow]:
    return [
        ConventionRow(
            convention=test.convention,
            measure=test.measure,
            as_mapped=fixed(test.as_mapped, 2),
            turned=f"{fixed(test.turned, 2)} {sentence(test.alternative)}",
            difference=f"{fixed(test.difference_low, 2)} to {fixed(test.difference_high, 2)}",
            finding=test.finding,
        )
        for test in evidence.tests
    ]


def _plant_rows(analysis: FlightAnalysis) -> list[PlantRow]:
    plain, coupled = analysis.turning.plant, analysis.turning.plant_with_coupling
    blades, inertia = analysis.blade_elements, analysis.morphology.yaw_inertia
    predicted = (None, None, None) if blades is None else (
        blades.damping / inertia, blades.paddling / inertia, blades.turn_gain,
    )  # fmt: skip
    rows = (
        ("yaw damping [1/s]", "β/<i>I</i>", "damping", 0, predicted[0]),
        ("paddling [1/s² per rad]", "γ/<i>I</i>", "paddling", -2, predicted[1]),
        ("turn gain [1/s]", "γ/β", "turn_gain", 0, predicted[2]),
    )
    estimates = [
        PlantRow(
            words=words, symbol=symbol, plain=_interval(plain, name, digits), coupled=_interval(coupled, name, digits),
            blades=fixed(None if blade is None else round(blade, digits), 0),
        )
        for words, symbol, name, digits, blade in rows
    ]  # fmt: skip
    memory = PlantRow(
        words="residuals’ correlation [1]", symbol="ρ", plain=_interval(plain, "noise_correlation", 2),
        coupled=_interval(coupled, "noise_correlation", 2), blades=ABSENT,
    )  # fmt: skip
    return [*estimates, memory, *_shares(plain, coupled)]


def _shares(plain: YawPlantFit | None, coupled: YawPlantFit | None) -> list[PlantRow]:
    rows = (
        ("explained of the acceleration [1]", "r2_acceleration"),
        ("the most that Eq. 3 could explain [1]", "r2_acceleration_best"),
        ("explained of the yaw rate, simulated [1]", "r2_simulated"),
    )
    return [
        PlantRow(
            words=words, symbol="<i>R</i>²", blades=ABSENT,
            plain=fixed(None if plain is None else getattr(plain, name), 2),
            coupled=fixed(None if coupled is None else getattr(coupled, name), 2),
        )
        for words, name in rows
    ]  # fmt: skip


def _interval(fit: YawPlantFit | None, name: str, digits: int) -> str:
    estimate: Estimate | None = None if fit is None else getattr(fit, name)
    if estimate is None:
        return ABSENT if fit is None or fit.paddling is None else "not bounded"
    value, low, high = (
        fixed(round(number, digits), max(digits, 0)) for number in (estimate.value, estimate.low, estimate.high)
    )
    return f"{value} [{low}, {high}]"


def _turn_rows(found: TurnIdentification) -> list[TurnRow]:
    return [
        TurnRow(
            number=number,
            time=f"{fixed(turn.start / ms, 0)}–{fixed(turn.end / ms, 0)}",
            wingbeats=f"{turn.wingbeats}" + ("" if turn.complete else ", cut"),
            cells=tuple(
                fixed(angle / deg, 0)
                for angle in (
                    turn.angle, turn.by_wing_speed, turn.by_wing_speed_trimmed, turn.by_plant,
                    turn.rate_change_correction,
                )
            ),
        )
        for number, turn in enumerate(found.turns, start=1)
    ]  # fmt: skip
