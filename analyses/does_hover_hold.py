"""Does hover hold when nobody steers, and does averaging over the wingbeat see whether it does?

Run with `python analyses/does_hover_hold.py [FOLDER]`; measured strokes are looked for in $FLYCONTROL_DATA, else in
../shared/data, and left out where there are none. The note, the numbers and the figure go to reports/does_hover_hold
unless a folder is given. It takes half a minute.
"""

import io
import json
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from _by_hand import DATA, REPORTS, folder_named
from _opened import opened
from numpy.typing import NDArray

from flycontrol.flight.body_coordinates import PITCH, ROLL, coordinates_of, state_at
from flycontrol.flight.flapping_fly import FlappingFly
from flycontrol.flight.flight_modes import FlightMode
from flycontrol.flight.floquet import FloquetModes, floquet_modes
from flycontrol.flight.linearised_flight import LinearisedFlight, linearised_flight
from flycontrol.flight.periodic_orbit import FINE, periodic_orbit
from flycontrol.flight.quasi_steady import QuasiSteadyModel
from flycontrol.flight.simulate import simulate_flight
from flycontrol.flight.state_vector import packed, unpacked
from flycontrol.flight.stroke_derivatives import StrokeDerivatives, stroke_derivatives
from flycontrol.flight.trim import HoverTrim, hover_trim
from flycontrol.io.morphology import read_morphology_table
from flycontrol.io.series_conventions import CONVENTIONS
from flycontrol.io.series_files import read_series_file
from flycontrol.jobs.files import write_files_atomically
from flycontrol.model.morphology import Morphology, drosophila_hydei, morphology_from_table
from flycontrol.model.stroke_kinematics import StrokeKinematics, hover_stroke
from flycontrol.model.wing_stroke import fourier_stroke
from flycontrol.units import deg, mm, ms

if TYPE_CHECKING:
    from matplotlib.axes import Axes

FloatArray = NDArray[np.float64]
FOLDER = REPORTS / "does_hover_hold"

# ## The question
#
# The review says that flies must suppress intrinsic instabilities, and treats heading, which is neutral: a fly that is
# nudged off its heading stays off it. What would happen to a fly that beats its wings as in hover and does nothing
# else? The wings are prescribed, the body is free, the air is quasi-steady with all its terms. Reduced models of
# flapping flight average forces over the wingbeat; here the average can be held against the flight itself.

FREQUENCY, AMPLITUDE, GAIN = "frequency", "stroke_amplitude", "stroke_gain"
MEASURED_HOVER, MEASURED_MEAN = "D. melanogaster, measured hover", "D. hydei, measured mean wingbeat"
ROLL_MODE, PITCH_MODE = "roll and sideways divergence", "pitch and fore-aft growing oscillation"


@dataclass(frozen=True, slots=True, kw_only=True)
class Case:
    """A fly and how it is trimmed."""

    name: str
    fly: FlappingFly
    stroke: StrokeKinematics = field(default_factory=hover_stroke)  #: where the search begins
    moves: tuple[str, str, str] = (FREQUENCY, "stroke_offset", "pitch_offset")


@dataclass(frozen=True, slots=True, kw_only=True)
class Hover:
    """A case in hover: trimmed, and what becomes of small disturbances."""

    case: Case
    trim: HoverTrim
    floquet: FloquetModes
    at_rest: StrokeDerivatives  #: averaged to first order about a body at rest
    along: LinearisedFlight  #: linearised along the orbit

    @property
    def fastest_lateral(self) -> complex:
        """Exponent of the lateral mode that grows most [1/s]."""
        return next(mode.exponent for mode in self.floquet.modes if not mode.name.startswith(("pitch", "vert")))

    @property
    def fastest_longitudinal(self) -> complex:
        """Exponent of the longitudinal mode that grows most [1/s]."""
        return next(mode.exponent for mode in self.floquet.modes if mode.name.startswith(("pitch", "vert")))


# ## Trim
#
# First a stroke that hovers. The built-in stroke is moved in three of its parameters until a wingbeat of the free body
# ends where it began and as it began: seven equations for three parameters and four coordinates of the body. The same
# balance with the body held, three equations, lies close by: a fly that bobs and nods with its wings needs 0.3 % more
# frequency.


def hover(case: Case) -> Hover:
    """Trim a case and examine it."""
    trim = hover_trim(case.fly, case.stroke, case.moves)
    orbit = periodic_orbit(case.fly, trim.kinematics, trim.start)
    return Hover(
        case=case,
        trim=trim,
        floquet=floquet_modes(orbit),
        at_rest=stroke_derivatives(case.fly, trim.kinematics),
        along=linearised_flight(orbit),
    )


def melanogaster(**changes: Any) -> Morphology:
    """The published fly, some entries of its table changed."""
    return morphology_from_table({**read_morphology_table(), **changes}, "Drosophila melanogaster", 220.0)


# ## What is uncertain
#
# The hinge lies 0.35 to 0.40 mm above the centre of mass, and the stroke plane stands 45 to 55 deg to the body. Other
# coefficients of lift and drag are in use, and models leave out terms of the air. The stroke's shape is calibrated; two
# were measured, one in hover (fry2005) and one as the mean of free flight (flycity). All are trimmed anew, the measured
# strokes by a change of amplitude, which keeps their frequency.


def cases() -> list[Case]:
    """The published fly first, the larger species second, then what might be otherwise."""
    fly = FlappingFly(morphology=melanogaster())
    forward, side, _ = (float(value) for value in np.atleast_1d(read_morphology_table()["right_hinge"]))
    air = {
        "lift and drag of Wang et al. 2004": QuasiSteadyModel(coefficients="wang2004"),
        "lift and drag of Whitney & Wood 2010": QuasiSteadyModel(coefficients="whitney2010"),
        "no rotational lift": QuasiSteadyModel(terms=("translational", "added_mass", "dissipative")),
        "no added mass": QuasiSteadyModel(terms=("translational", "rotational", "dissipative")),
        "translation alone": QuasiSteadyModel(terms=("translational",)),
    }
    body = {
        "hinge 0.35 mm above": melanogaster(right_hinge=(forward, side, -0.35 * mm)),
        "hinge 0.40 mm above": melanogaster(right_hinge=(forward, side, -0.40 * mm)),
        "stroke plane at 45 deg": melanogaster(stroke_plane_angle=45 * deg),
    }
    return [
        Case(name="D. melanogaster", fly=fly),
        Case(name="D. hydei", fly=FlappingFly(morphology=drosophila_hydei()), stroke=hover_stroke(189.0)),
        Case(name="trimmed by amplitude", fly=fly, moves=(AMPLITUDE, "stroke_offset", "pitch_offset")),
        *(Case(name=name, fly=replace(fly, morphology=each)) for name, each in body.items()),
        *(Case(name=name, fly=replace(fly, air=each)) for name, each in air.items()),
        *measured(),
    ]


def measured() -> list[Case]:
    """Hover of *D. melanogaster* and the mean wingbeat of *D. hydei*, where their data are."""
    hovering = DATA / "kinematics_fourier" / "Drosophila_hovering_fry.json"
    mean = DATA / "muijres_mean_wingbeats" / "steady_free_flight.csv"
    if not (hovering.is_file() and mean.is_file()):
        return []
    table = np.genfromtxt(mean, delimiter=",", names=True)[:-1]  # phases 0 and 1 are both there
    angles = np.stack([-table["stroke_mean_deg"], table["dev_mean_deg"], 180 - table["pitch_mean_deg"]], axis=1) * deg
    own = {
        MEASURED_HOVER: (melanogaster(), read_series_file(hovering, CONVENTIONS["hovering fruit fly"]), 218.0),
        MEASURED_MEAN: (drosophila_hydei(), fourier_stroke(np.arange(len(table)) / len(table), angles, 12), 189.0),
    }
    return [
        Case(
            name=name,
            fly=FlappingFly(morphology=morphology),
            stroke=StrokeKinematics.symmetric(stroke, frequency),
            moves=(GAIN, "stroke_offset", "pitch_offset"),
        )
        for name, (morphology, stroke, frequency) in own.items()
    ]


# ## Is it what the simulator does?
#
# Each growing mode is set off with a small amplitude and flown by the ordinary simulator. Nothing in the flight knows
# of multipliers.


@dataclass(frozen=True, slots=True, kw_only=True)
class Growth:
    """One mode set off and flown."""

    mode: FlightMode
    period: float  #: of the wingbeat [s]
    coordinate: int  #: the angle that is followed
    flown: FloatArray  #: (N,) its deviation from the orbit, wingbeat by wingbeat [rad]
    begin: complex  #: of the mode's angle [rad]

    def said(self, time: FloatArray) -> FloatArray:
        """What the exponent says at times (M,) [rad]."""
        return np.real(self.begin * np.exp(self.mode.exponent * time))


def growth(found: Hover, name: str, coordinate: int, angle: float, wingbeats: int) -> Growth:
    """Set off a mode so that one angle begins at `angle`, and fly."""
    mode = next(mode for mode in found.floquet.modes if mode.name == name)
    orbit, kinematics = found.floquet.orbit, found.trim.kinematics
    shape = mode.shape * (angle / mode.shape[coordinate])
    begin = unpacked(state_at(kinematics, orbit.coordinates + np.real(shape) * orbit.scales))
    flight = simulate_flight(
        found.case.fly, kinematics, wingbeats, start=begin, settings=replace(FINE, samples=1)
    )  # fmt: skip
    states = np.array([coordinates_of(packed(flight.state(k))) for k in range(wingbeats + 1)])
    return Growth(
        mode=mode,
        period=found.floquet.period,
        coordinate=coordinate,
        flown=(states - orbit.coordinates)[:, coordinate],
        begin=complex(shape[coordinate]),
    )


# ## What averaging loses
#
# Moving sideways, a fly meets a roll and a yaw torque that change sign between half strokes and are several times their
# own mean. They shake the body, the shaking is in quadrature with them, and in the next moment the shaken body meets
# the alternating torques again: the product has a mean. Averaging to first order, which is what stroke-averaged
# derivatives do, drops it. The second order keeps it: <A~ U>, with A~ what alternates in the equations of motion and U
# its integral. Here it adds two thirds to the roll torque by sideways motion, which is what drives the divergence.


@dataclass(frozen=True, slots=True, kw_only=True)
class RollBySideslip:
    """Roll acceleration by sideways velocity, the coefficient that makes roll diverge [1/s, natural units]."""

    mean: float
    alternating: float  #: root mean square of what averages out
    rectified: float  #: what the second order adds


def roll_by_sideslip(found: Hover) -> RollBySideslip:
    """Of a hovering fly."""
    scales = found.floquet.orbit.scales
    unit = scales[1] / scales[3]
    each = found.along.matrices[:, 3, 1] * unit
    second = found.along.second_order[3, 1] * unit
    mean = float(each.mean())
    return RollBySideslip(mean=mean, alternating=float(each.std()), rectified=float(second - mean))


@dataclass(frozen=True, slots=True, kw_only=True)
class Findings:
    """All that the note states."""

    hovers: tuple[Hover, ...]
    roll: Growth
    pitch: Growth
    sideslip: RollBySideslip

    @property
    def fly(self) -> Hover:
        """The published one."""
        return self.hovers[0]


def findings() -> Findings:
    """Everything."""
    hovers = tuple(hover(case) for case in cases())
    return Findings(
        hovers=hovers,
        roll=growth(hovers[0], ROLL_MODE, ROLL, 0.05 * deg, 28),
        pitch=growth(hovers[0], PITCH_MODE, PITCH, 1.0 * deg, 28),
        sideslip=roll_by_sideslip(hovers[0]),
    )


# ## The figure
#
# Left: both growing modes flown (marks) and as their exponents say (lines). Right: the exponents of flight itself and
# of flight averaged over the wingbeat, upper half plane.

DARK, WARM, RED = "#0b3954", "#e08a00", "#c8323c"


def draw(found: Findings) -> dict[str, bytes]:
    """The figure as SVG, and as PNG for a quick look."""
    from flycontrol.report.style import in_house_style, new_figure

    with in_house_style():
        figure = new_figure(3.2)
        left, right = figure.subplots(1, 2, width_ratios=[1.0, 1.15])
        draw_growth(left, found)
        draw_exponents(right, found.fly)
        return {name: _saved(figure, name.split(".")[1]) for name in ("does_hover_hold.svg", "does_hover_hold.png")}


def draw_growth(ax: "Axes", found: Findings) -> None:
    """Angles after a small disturbance."""
    for grown, name, colour, mark, line in (
        (found.roll, "roll, from 0.05 deg", DARK, "o", "-"),
        (found.pitch, "pitch, from 1 deg", WARM, "s", (0, (4, 2))),
    ):
        time = np.arange(len(grown.flown)) * grown.period
        fine = np.linspace(0.0, time[-1], 400)
        ax.plot(fine / ms, grown.said(fine) / deg, color=colour, linewidth=1.3, linestyle=line)
        ax.plot(time / ms, grown.flown / deg, mark, color=colour, markersize=3.2, label=name)
    ax.axhline(0.0, color="#7d7d7d", linewidth=0.7, linestyle=(0, (1, 2)))
    ax.set(xlabel="time [ms]", ylabel="angle off the orbit [deg]", xlim=(0, 126))
    ax.set_title("Flown (marks) and by exponent (lines)", fontsize=8)
    ax.legend(loc="upper left", handlelength=1.0)


def draw_exponents(ax: "Axes", found: Hover) -> None:
    """Exponents in the complex plane; the fast subsidence of yaw lies outside."""
    looks: tuple[tuple[str, tuple[FlightMode, ...], dict[str, Any]], ...] = (
        ("first order, at rest", found.at_rest.modes, {"marker": "s", "color": WARM, "markersize": 6}),
        ("second order", found.along.modes(2), {"marker": "x", "color": RED, "markersize": 6.5}),
        ("flight itself", found.floquet.modes, {"marker": "o", "color": DARK, "markersize": 3.5}),
    )
    ax.axvspan(0, 60, color="#f1efec", zorder=0)
    for label, modes, look in looks:
        inside = [mode.exponent for mode in modes if mode.exponent.real > -100]
        hollow = "none" if look["marker"] == "s" else look["color"]
        ax.plot(
            [z.real for z in inside], [z.imag for z in inside], linestyle="none", label=label, markeredgewidth=1.2,
            markerfacecolor=hollow, zorder=3, **look,
        )  # fmt: skip
    for text, place in (
        ("roll and sideways", (-38.0, 37.5)), ("pitch and fore-aft", (14.7, 37.5)), ("roll", (31.5, 3.0)),
        ("vertical", (-3.8, 3.0)), ("pitch", (-43.0, 3.0)),
    ):  # fmt: skip
        ax.annotate(text, place, ha="center", fontsize=7.5)
    yaw = found.floquet.modes[-1].exponent.real
    ax.annotate(f"yaw, {yaw:.0f} ", (-62, 0.0), (-57, 10.0), fontsize=7.5, arrowprops={"arrowstyle": "->", "lw": 0.7})
    ax.set(xlim=(-62, 56), ylim=(-1.5, 57), xlabel="growth rate [1/s]", ylabel="angular frequency [rad/s]")
    ax.set_title("Exponents; growing on the right, shaded", fontsize=8)
    ax.legend(loc="upper center", ncols=3, columnspacing=0.8, handletextpad=0.2, fontsize=7.2)


def _saved(figure: Any, kind: str) -> bytes:
    buffer = io.BytesIO()
    metadata = {"Date": None, "Creator": None} if kind == "svg" else {"Software": None}
    figure.savefig(buffer, format=kind, dpi=150, metadata=metadata)
    return buffer.getvalue()


# ## The answer
#
# **No. Roll goes first: it doubles every 19.3 ms, 4.4 wingbeats, while the fly slides off sideways; pitch swings ever
# wider with the fly's fore-aft motion and doubles every 47.2 ms, 10.8 wingbeats.** Climbing and sinking die out slowly,
# yaw within a wingbeat, and heading stays where it is put. Flies answer before that matters: with the published
# latencies of 5 ms in roll (beatus2015) and 10 ms in pitch (whitehead2015), a disturbance grows by 20 % and 16 % before
# the wings respond. The axis that is lost sooner has the shorter latency.
#
# Averaging sees the pitch mode to 0.5 %, but roll at three quarters of its rate: 26.4 where flight says 35.8 1/s. With
# the second order it is 36.1. Roll is also where the air model matters: without rotational lift the divergence is less
# than half as fast, and by translation alone there is next to none. Where hinge and stroke plane lie within what is
# published, or which coefficients of lift and drag are taken, changes both modes by a few per cent.
#
# The calibrated stroke has the pitch mode of the one that was measured in hover, 14.7 against 14.8 1/s, but its roll
# diverges faster, 35.8 against 25.7 1/s, of which averaging sees 15.9. The mean wingbeat of *D. hydei*, which is no
# hover, halves the growth in pitch. So that hover is lost in both, and sooner in roll, stands; how fast depends on the
# stroke. So does the damping of yaw: 41.8e-12 N m s with the calibrated stroke, 26.1e-12 with the measured hover, where
# 21e-12 (cheng2010) and 54e-12 (hesselberg2007) are published. What is left out: wings whose pitch is passive, and the
# wake.


def mode_rows(found: Hover) -> str:
    """Rows of Markdown: every mode by flight itself and by averaging."""
    rest, second = found.at_rest.modes, found.along.modes(2)
    rows = []
    for mode, error in zip(found.floquet.modes, found.floquet.errors, strict=True):
        time = mode.doubling_time
        multiplier = np.exp(mode.exponent * found.floquet.period)
        rows.append(
            f"| {mode.name} | {_complex(complex(multiplier), 4)} | {_complex(mode.exponent, 2)} | {error:.3f} | "
            f"{'doubles' if time > 0 else 'halves'} in {abs(time) / ms:.1f} ms | {_complex(_near(mode, rest), 2)} | "
            f"{_complex(_near(mode, second), 2)} |"
        )
    return "\n".join(rows)


def _near(mode: FlightMode, others: tuple[FlightMode, ...]) -> complex:
    return min((other.exponent for other in others), key=lambda z: abs(z - mode.exponent))


def _complex(z: complex, digits: int) -> str:
    return f"{z.real:.{digits}f}" + (f" +- {z.imag:.{digits}f} i" if z.imag else "")


def case_rows(found: Findings) -> str:
    """Rows of Markdown: trim and growing modes of every case."""
    rows = []
    for each in found.hovers:
        stroke, values = each.trim.kinematics.right, each.trim.values
        angles = stroke(np.arange(400) / 400).angles[:, 0]
        first = max(mode.exponent.real for mode in each.at_rest.modes if not mode.name.startswith(("pitch", "vert")))
        swing = (angles.max() - angles.min()) / deg
        rows.append(
            f"| {each.case.name} | {each.trim.kinematics.frequency:.1f} | "
            f"{swing:.1f} | {values['stroke_offset'] / deg:.2f} | "
            f"{values['pitch_offset'] / deg:.2f} | {_complex(each.fastest_lateral, 1)} | {first:.1f} | "
            f"{_complex(each.fastest_longitudinal, 1)} | {each.at_rest.yaw_damping * 1e12:.1f} |"
        )
    return "\n".join(rows)


def as_text(found: Findings) -> str:
    """The answer as a page of Markdown."""
    fly, slip = found.fly, found.sideslip
    left, drift = fly.trim.balance, fly.floquet.orbit.drift_W
    held = fly.trim.held_values
    off = {g.mode.name: float(np.max(np.abs(g.flown - g.said(np.arange(len(g.flown)) * g.period)))) / float(
        np.max(np.abs(g.flown))) for g in (found.roll, found.pitch)}  # fmt: skip
    return (
        "# Does hover hold?\n\n"
        f"Trim of {fly.case.name}: {fly.trim.kinematics.frequency:.2f} Hz, stroke offset "
        f"{fly.trim.values['stroke_offset'] / deg:.3f} deg, pitch offset {fly.trim.values['pitch_offset'] / deg:.3f} "
        f"deg; body held: {held['frequency']:.2f} Hz, {held['stroke_offset'] / deg:.3f} deg, "
        f"{held['pitch_offset'] / deg:.3f} deg. Net loads left: {left.largest_load:.0e} of the weight; with four times "
        f"the steps the fly drifts by {np.linalg.norm(drift) * 1e6:.1f} um/s.\n\n"
        "## Modes\n\n"
        "Multipliers of the wingbeat map, exponents f ln mu, and those of flight averaged over the wingbeat [1/s]; "
        "position and heading have the multiplier 1.\n\n"
        "| mode | multiplier | exponent | its error | time | first order, body at rest | second order |\n"
        "|---|---|---|---|---|---|---|\n"
        f"{mode_rows(fly)}\n\n"
        f"Set off and flown for {len(found.roll.flown) - 1} wingbeats, the growing modes depart from their exponents "
        f"by {100 * off[ROLL_MODE]:.1f} % (roll, to {np.max(np.abs(found.roll.flown)) / deg:.1f} deg) and "
        f"{100 * off[PITCH_MODE]:.1f} % (pitch, to {np.max(np.abs(found.pitch.flown)) / deg:.1f} deg) of the largest "
        "angle.\n\n"
        f"Roll acceleration by sideways velocity (natural units, 1/s): mean {slip.mean:.1f}, alternating "
        f"{slip.alternating:.0f} (rms), rectified {slip.rectified:+.1f}.\n\n"
        "## What is uncertain\n\n"
        "| case | frequency [Hz] | amplitude, peak to peak [deg] | stroke offset [deg] | pitch offset [deg] "
        "| fastest lateral mode [1/s] | by first order | fastest longitudinal mode [1/s] "
        "| yaw damping [1e-12 N m s] |\n"
        "|---|---|---|---|---|---|---|---|---|\n"
        f"{case_rows(found)}\n\n"
        "Published for *D. melanogaster*: 218 to 250 Hz, 140 to 145 deg, yaw damping 21 (cheng2010) to 54 "
        "(hesselberg2007). Offsets of measured strokes "
        "(fry2005, flycity) are changes.\n\n"
        "![Growing modes as flown, and exponents against those of averaged flight](does_hover_hold.svg)\n"
    )


PUBLISHED_DAMPING = (21e-12, 54e-12)  # beta [N m s], cheng2010 and hesselberg2007


def claims(found: Findings) -> list[dict[str, str]]:
    """What the review says, what comes out here, and whether they agree."""
    low, high = PUBLISHED_DAMPING
    hovering = [each for each in found.hovers if each.case.name.startswith("D. melanogaster")]
    damping = [each.at_rest.yaw_damping for each in hovering]
    roll, pitch = found.fly.fastest_lateral.real, found.fly.fastest_longitudinal.real
    names = ["calibrated stroke", "measured hover"]
    said = ", ".join(f"{1e12 * beta:.1f} ({name})" for beta, name in zip(damping, names, strict=False))
    return [
        {"claim": "flies must suppress intrinsic instabilities to keep straight", "published": "no number",
         "ours": f"unsteered hover doubles its roll in {1e3 * np.log(2) / roll:.1f} ms and its pitch in "
                 f"{1e3 * np.log(2) / pitch:.1f} ms; heading stays where it is put",
         "agreement": "agrees" if min(roll, pitch) > 0 else "fails", "where": "section 1", "basis": "simulated"},
        {"claim": "flapping wings passively damp yaw: beta [pN m s]",
         "published": f"{1e12 * low:.0f} to {1e12 * high:.0f}", "ours": said,
         "agreement": "agrees" if all(low <= beta <= high for beta in damping) else "fails",
         "where": "section 4, Eq. 3", "basis": "simulated"},
    ]  # fmt: skip


def as_numbers(found: Findings) -> str:
    """The numbers as JSON, six digits."""
    rows = {
        each.case.name: {
            "frequency_Hz": each.trim.kinematics.frequency,
            "trim": dict(each.trim.values),
            "trim_with_body_held": dict(each.trim.held_values),
            "exponents_1_per_s": _exponents(each.floquet.modes),
            "errors_1_per_s": dict(zip(_exponents(each.floquet.modes), each.floquet.errors, strict=True)),
            "first_order_at_rest_1_per_s": _exponents(each.at_rest.modes),
            "second_order_1_per_s": _exponents(each.along.modes(2)),
            "yaw_damping_N_m_s": each.at_rest.yaw_damping,
        }
        for each in found.hovers
    }
    short = json.loads(
        json.dumps({"claims": claims(found)} | rows), parse_float=lambda text: float(f"{float(text):.6g}")
    )
    return json.dumps(short, indent=2) + "\n"


def _exponents(modes: tuple[FlightMode, ...]) -> dict[str, list[float]]:
    return {mode.name: [mode.exponent.real, mode.exponent.imag] for mode in modes}


def main(folder: Path = FOLDER) -> Findings:
    """Find, draw and write."""
    found = findings()
    text = opened(__file__, as_text(found))
    write_files_atomically(
        folder,
        {
            "does_hover_hold.md": text,
            "does_hover_hold.json": as_numbers(found),
            "does_hover_hold.svg": draw(found)["does_hover_hold.svg"],
        },
    )
    print(text)
    return found


if __name__ == "__main__":
    main(folder_named(__file__, __doc__, FOLDER))
