"""Does the paddling alone tell how far a fly turns, and what is gamma/beta, the slope, made of?

Run with `python analyses/turn_angle_from_paddling.py [FOLDER]`; real flights and measured strokes are looked for in
$FLYCONTROL_DATA, else in ../shared/data, and left out where there are none. The note, the numbers and the figure go to
reports/turn_angle_from_paddling unless a folder is given. It takes a minute.
"""

import io
import json
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from _by_hand import DATA, REPORTS, folder_named
from _opened import opened
from numpy.typing import NDArray

from flycontrol.flight.flapping_fly import FlappingFly
from flycontrol.flight.hinge_fit import at_pitch_axis, fitted_spring
from flycontrol.flight.hinge_motion import passive_wingbeat, sprung
from flycontrol.flight.hinge_transmission import hinge_transmission
from flycontrol.flight.multibody.freedoms import FREE, YAW_ONLY
from flycontrol.flight.settings import MarchSettings
from flycontrol.flight.simulate import simulate_flight
from flycontrol.flight.trim import HoverTrim, hover_trim
from flycontrol.identify.flight import analyse_flight
from flycontrol.identify.turns import identify_turns
from flycontrol.io.morphology import read_morphology_table
from flycontrol.io.recordings import read_recording
from flycontrol.io.series_conventions import CONVENTIONS
from flycontrol.io.series_files import read_series_file
from flycontrol.jobs.files import write_files_atomically
from flycontrol.model.hinge import DampedSpring
from flycontrol.model.morphology import drosophila_hydei, morphology_from_table
from flycontrol.model.recording import Recording, WingAngles
from flycontrol.model.stroke import WingMotion
from flycontrol.model.stroke_kinematics import StrokeKinematics, hover_stroke
from flycontrol.model.trajectory import Trajectory
from flycontrol.model.turn import PaddlingTurn
from flycontrol.model.wing_stroke import ModulatedStroke, Modulation, WingStroke, fourier_stroke, paddling
from flycontrol.reduce.beside_published import beside_published
from flycontrol.reduce.half_life import YawDecay, yaw_decay
from flycontrol.reduce.reduced_yaw import ReducedYaw, reduced_yaw
from flycontrol.reduce.torque_curves import TorqueCurve, damping_curve, paddling_curve
from flycontrol.reduce.turn_gain import TurnGain, turn_gain
from flycontrol.reduce.yaw_torque import YawExperiment
from flycontrol.units import deg, ms

if TYPE_CHECKING:
    from matplotlib.axes import Axes

FloatArray = NDArray[np.float64]
FOLDER = REPORTS / "turn_angle_from_paddling"

MEASURED_HOVER = "D. melanogaster, measured hover"

# ## The question
#
# Eq. 4 and 5 of the review: once a turn is over, Delta psi = (gamma/beta) * integral of d_alpha, and gamma/beta is
# omega, the mean angular speed of the wings. So the stronger and the longer a fly paddles, the farther it turns, and
# nothing else counts. Fig. 5c shows it for ten turns. Here turns are simulated with all terms of a quasi-steady air, by
# a fly that can do nothing but yaw, as on a magnetic tether, and by one that flies freely and does not steer. The
# slope comes from elsewhere: torques on a fly that is held, turned at a steady rate and made to paddle.

AMPLITUDES_AND_LENGTHS = (
    (1, 3), (2, 3), (4, 3), (6, 3), (9, 3), (1, 6), (2, 6), (3, 6), (4, 6), (-3, 6), (1, 10), (2, 10), (3, 10), (-2, 10)
)  # fmt: skip
RAMP = 1.0  # wingbeats, up and down again; the length runs from half up to half down
BEFORE, AFTER = 3, 10  # wingbeats


@dataclass(frozen=True, slots=True, kw_only=True)
class SimulatedTurn:
    """A turn by a bump of paddling; angles from before the bump until the fly is still again [rad]."""

    amplitude: float  #: d_alpha at the top [rad]
    length: float  #: between half up and half down [wingbeats]
    integral: float  #: of d_alpha [rad s]
    tethered: float  #: turned when only yaw is free
    flying: float  #: turned about the stroke plane's normal in free flight
    tilt: float  #: of the stroke plane at the end of the free flight
    windowed: PaddlingTurn  #: the tethered turn as a recording is read: between low yaw rates


def bump(stroke: WingStroke, modulation: Modulation, length: float) -> ModulatedStroke:
    """Into the modulation and out again."""
    rise = ModulatedStroke(stroke=stroke, after=modulation, ramp=(BEFORE, BEFORE + RAMP))
    back = replace(modulation, pitch_offset=-modulation.pitch_offset)
    return ModulatedStroke(stroke=rise, after=back, ramp=(BEFORE + length, BEFORE + length + RAMP))


def simulated_turn(fly: FlappingFly, trim: HoverTrim, amplitude: float, length: float) -> SimulatedTurn:
    """On the tether and in the air."""
    left, right = paddling(amplitude)
    hover = trim.kinematics
    stroke = replace(hover, left=bump(hover.left, left, length), right=bump(hover.right, right, length))
    beats = round(BEFORE + length + RAMP + AFTER)
    tethered = simulate_flight(replace(fly, body=YAW_ONLY), stroke, beats)
    # in free flight roll diverges without steering: the turn is read as soon as yaw has come to rest
    settings = MarchSettings(estimate_error=False)
    free = simulate_flight(replace(fly, body=FREE), stroke, beats - AFTER + 4, start=trim.start, settings=settings)
    windowed = max(identify_turns(recorded(tethered), fly.morphology).turns, key=lambda turn: abs(turn.angle))
    return SimulatedTurn(
        amplitude=amplitude,
        length=length,
        integral=amplitude * length / hover.frequency,
        tethered=float(tethered.yaw[-1] - tethered.yaw[0]),
        flying=yaw_integral(free),
        tilt=tilt_of(free.q_WS[-1]),
        windowed=windowed,
    )


def yaw_integral(flight: Trajectory) -> float:
    """Integral of the yaw rate about the stroke plane's normal [rad]."""
    return float(np.trapezoid(flight.angular_velocity_S[:, 2], flight.time))


def tilt_of(q_WS: FloatArray) -> float:
    """Angle between the stroke plane and the horizon [rad]."""
    _, x, y, _ = q_WS
    return float(np.arccos(min(1.0, 2 * (x * x + y * y) - 1.0)))


def recorded(flight: Trajectory) -> Recording:
    """The flight as a camera would hold it, so that it is read as a real one is."""
    return Recording(
        name="simulated turn",
        rate=flight.frequency * flight.samples_per_wingbeat,
        time=flight.time.copy(),
        source_sha256="",
        angular_velocity_S=flight.angular_velocity_S.copy(),
        left=_angles(flight.left),
        right=_angles(flight.right),
    )


def _angles(motion: WingMotion) -> WingAngles:
    return WingAngles(stroke=motion.stroke.copy(), deviation=motion.deviation.copy(), pitch=motion.pitch.copy())


# ## Real turns
#
# Three real flights, read as `flycontrol report --recording` reads them. Their zero of the pitch angle is not certain,
# so that the paddling angle may carry an offset; with the flight's median paddling as zero, another offset goes in.


@dataclass(frozen=True, slots=True, kw_only=True)
class RealTurn:
    """One turn of a real flight, and the slope that blade elements give at that flight's mean stroke."""

    flight: str
    turn: PaddlingTurn
    slope: float  #: gamma / (beta omega)


def real_turns() -> list[RealTurn]:
    """All turns of at least 5 deg."""
    table = read_morphology_table("drosophila_hydei")
    fly = morphology_from_table(table, "Drosophila hydei", 189.0)
    found = []
    for path in sorted((DATA / "muijres_freeflight").glob("2*.txt")):
        analysis = analyse_flight(read_recording(path, "muijres_freeflight"), fly)
        assert analysis.blade_elements is not None
        slope = analysis.blade_elements.turn_gain_over_wing_speed
        found += [RealTurn(flight=path.stem, turn=turn, slope=slope) for turn in analysis.turning.turns]
    return found


# ## The slope, taken apart
#
# Eq. 5's slope is omega only if wings sweep at constant speed at 45 deg with a drag like sine squared, hinged on the
# yaw axis. Real wings are let in part by part, and each part multiplies the slope by a factor.


@dataclass(frozen=True, slots=True, kw_only=True)
class Stroke:
    """A stroke, its slope taken apart, the reduced model that it makes, and the flight after a kick on the tether."""

    name: str
    experiment: YawExperiment
    gain: TurnGain
    model: ReducedYaw
    decay: YawDecay


def studied(name: str, fly: FlappingFly, kinematics: StrokeKinematics) -> Stroke:
    """Everything about one stroke."""
    experiment = YawExperiment(fly=fly, kinematics=kinematics)
    return Stroke(
        name=name,
        experiment=experiment,
        gain=turn_gain(experiment),
        model=reduced_yaw(fly, kinematics),
        decay=yaw_decay(fly, kinematics),
    )


def measured_strokes(fly: FlappingFly) -> list[Stroke]:
    """Hover of *D. melanogaster* and mean wingbeat of *D. hydei*, whose file counts stroke and pitch the other way."""
    found = []
    hover = DATA / "kinematics_fourier" / "Drosophila_hovering_fry.json"
    if hover.is_file():
        stroke = read_series_file(hover, CONVENTIONS["hovering fruit fly"])
        found.append(studied(MEASURED_HOVER, fly, StrokeKinematics.symmetric(stroke, 218.0)))
    mean = DATA / "muijres_mean_wingbeats" / "steady_free_flight.csv"
    if mean.is_file():
        table = np.genfromtxt(mean, delimiter=",", names=True)[:-1]
        columns = [-table["stroke_mean_deg"], table["dev_mean_deg"], 180 - table["pitch_mean_deg"]]
        stroke = fourier_stroke(np.arange(len(table)) / len(table), np.stack(columns, axis=1) * deg, 12)
        hydei = FlappingFly(morphology=drosophila_hydei(189.0))
        found.append(studied("D. hydei, measured mean wingbeat", hydei, StrokeKinematics.symmetric(stroke, 189.0)))
    return found


# ## Wings on springs
#
# So far the pitch is given. On the springs of `hinge_as_a_spring`, found from the measured hover with the pitch axis at
# 0.05 chords, it follows from the air, also from the air that a turning body adds.

PITCH_AXIS = 0.05  # chords from the leading edge


@dataclass(frozen=True, slots=True, kw_only=True)
class OnSprings:
    """The measured hover with wings that pitch passively."""

    spring: DampedSpring
    given: ReducedYaw  #: with the measured pitch
    passive: ReducedYaw  #: with beta, gamma and mu of the springs
    decay: YawDecay  #: on the tether, simulated with the springs


def on_springs(stroke: Stroke) -> OnSprings:
    """Find the spring, the coefficients that it makes, and how a kick dies out."""
    kinematics = stroke.experiment.kinematics
    fly = at_pitch_axis(stroke.experiment.fly, PITCH_AXIS)
    spring = fitted_spring(fly, kinematics).spring
    given = reduced_yaw(fly, kinematics)
    start = passive_wingbeat(sprung(fly, spring), kinematics).trajectory.state(0)
    return OnSprings(
        spring=spring,
        given=given,
        passive=given.through(hinge_transmission(fly, kinematics, spring)),
        decay=yaw_decay(sprung(fly, spring), kinematics, start),
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class Findings:
    """All that the note states."""

    turns: list[SimulatedTurn]
    real: list[RealTurn]
    strokes: list[Stroke]  #: the built-in hover first: the turns are simulated with it
    springs: OnSprings | None  #: None where the measured hover is not at hand
    flying: YawDecay  #: of the built-in hover with six freedoms
    paddled: TorqueCurve
    turned: TorqueCurve

    @property
    def hover(self) -> Stroke:
        """The built-in, trimmed one."""
        return self.strokes[0]

    def share(self, turn: SimulatedTurn, angle: float) -> float:
        """Turned angle over gamma/beta times the integral of d_alpha."""
        return angle / (self.hover.gain.ratio * turn.integral)


def findings() -> Findings:
    """Everything, in a minute."""
    fly = FlappingFly(morphology=morphology_from_table(read_morphology_table(), "Drosophila melanogaster", 220.0))
    trim = hover_trim(fly, hover_stroke())
    hover = studied("D. melanogaster, built-in hover", fly, trim.kinematics)
    measured = measured_strokes(fly)
    return Findings(
        turns=[simulated_turn(fly, trim, amplitude * deg, length) for amplitude, length in AMPLITUDES_AND_LENGTHS],
        real=real_turns(),
        strokes=[hover, *measured],
        springs=next((on_springs(one) for one in measured if one.name == MEASURED_HOVER), None),
        flying=yaw_decay(fly, trim.kinematics, trim.start, freedom="all"),
        paddled=paddling_curve(hover.experiment),
        turned=damping_curve(hover.experiment),
    )


# ## The figure
#
# a: turns against the paddling parameter, simulated and real. b: what is left of a turn when the slope is divided out.
# c: the slope over omega as the parts of the real wing are let in. d: half-lives by the phase of the kick.

DARK, ORANGE, RED, BLUE, GREY = "#0b3954", "#e08a00", "#c8323c", "#69add5", "#7d7d7d"
SHORT = {
    "waveform": "waveform", "pitch": "pitch", "deviation": "deviation", "hinge to the side": "hinge, side",
    "hinge ahead": "hinge, ahead", "rotational force": "rotation", "added mass": "added mass",
    "dissipative torque": "dissipation",
}  # fmt: skip


def draw(found: Findings) -> dict[str, bytes]:
    """The figure as SVG, and as PNG for a quick look."""
    from flycontrol.report.style import in_house_style, new_figure

    with in_house_style():
        figure = new_figure(6.6)
        (turns, shares), (factors, halves) = figure.subplots(2, 2, height_ratios=[1.1, 1.0])
        draw_turns(turns, found)
        draw_shares(shares, found)
        draw_factors(factors, found)
        draw_halves(halves, found)
        return {f"turn_angle_from_paddling.{kind}": _saved(figure, kind) for kind in ("svg", "png")}


def draw_turns(ax: "Axes", found: Findings) -> None:
    """Turn angle over omega times the integral of the paddling angle."""
    gain = found.hover.gain
    edge = np.array([-120.0, 170.0])
    ax.plot(edge, edge, color=GREY, linewidth=0.9, linestyle=(0, (4, 2)), label="Eq. 5")
    ax.plot(edge, edge * gain.over_wing_speed, color=DARK, linewidth=1.3, label=f"γ/β = {gain.over_wing_speed:.2f} ω")
    x = [gain.speeds.mean * turn.integral / deg for turn in found.turns]
    ax.plot(x, [t.tethered / deg for t in found.turns], "o", color=DARK, markersize=5, label="simulated, yaw only")
    ax.plot(x, [t.flying / deg for t in found.turns], "s", color=ORANGE, markersize=4.5, fillstyle="none",
            label="simulated, free flight")  # fmt: skip
    whole = [one.turn for one in found.real if one.turn.complete]
    cut = [one.turn for one in found.real if not one.turn.complete]
    for turns, style, name in ((whole, "full", "real"), (cut, "none", "real, cut by the recording")):
        if turns:
            ax.plot([t.by_wing_speed / deg for t in turns], [t.angle / deg for t in turns], "D", color=RED,
                    markersize=4.5, fillstyle=style, label=name)  # fmt: skip
    ax.set(xlabel="ω ∫ Δα dt [deg]", ylabel="turn angle [deg]", title="a  turns against paddling")
    ax.set(xlim=(-120, 170), ylim=(-120, 170), xticks=range(-100, 151, 50), yticks=range(-100, 151, 50))
    ax.legend(loc="upper left", fontsize=7, handlelength=1.6, borderaxespad=0.1, labelspacing=0.3)


def draw_shares(ax: "Axes", found: Findings) -> None:
    """What remains when the slope is divided out, over the amplitude of the paddling."""
    size = np.array([abs(t.amplitude) for t in found.turns]) / deg
    curve = found.paddled
    ax.plot(curve.inputs / deg, curve.torque / (curve.slope * curve.inputs), color=GREY, linewidth=0.9,
            linestyle=(0, (4, 2)), label="torque over its straight line")  # fmt: skip
    tethered = [found.share(t, t.tethered) for t in found.turns]
    free = [found.share(t, t.flying) for t in found.turns]
    ax.plot(size, tethered, "o", color=DARK, markersize=5, label="yaw only")
    ax.plot(size, free, "s", color=ORANGE, markersize=4.5, fillstyle="none", label="free flight")
    ax.axhline(1.0, color=GREY, linewidth=0.7, linestyle=(0, (1, 2)))
    ax.set(xlabel="amplitude of Δα [deg]", ylabel="turn angle / (γ/β) ∫ Δα dt", title="b  what the line leaves",
           xlim=(0, 10), ylim=(0.9, 1.16))  # fmt: skip
    ax.legend(loc="upper right", fontsize=7.5)


def draw_factors(ax: "Axes", found: Findings) -> None:
    """gamma/(beta omega) as parts of the wing are let in."""
    looks = ((DARK, "o", "full"), (ORANGE, "s", "full"), (RED, "D", "none"))
    for stroke, (color, marker, fill) in zip(found.strokes, looks, strict=False):
        steps = stroke.gain.drag_slope * np.cumprod([1.0, *[one.factor for one in stroke.gain.factors]])
        ax.plot(range(len(steps) + 1), [1.0, *steps], color=color, marker=marker, fillstyle=fill, markersize=4.2,
                linewidth=1.0, label=stroke.name)  # fmt: skip
    names = ["Eq. 5", "slope of C_D", *(SHORT[one.name] for one in found.hover.gain.factors)]
    ax.set_xticks(range(len(names)), names, rotation=50, ha="right", fontsize=7.5)
    ax.axhline(1.0, color=GREY, linewidth=0.7, linestyle=(0, (1, 2)))
    ax.set(ylabel="γ / (β ω)", title="c  the slope, part by part", ylim=(0.72, 1.78))
    ax.legend(loc="upper right", fontsize=7, handlelength=1.6)


def draw_halves(ax: "Axes", found: Findings) -> None:
    """Time until the yaw rate has halved, over the phase of the kick."""
    decay, model = found.hover.decay, found.hover.model
    free = np.log(2) * model.inertia.free / model.damping
    for one, color, marker, fill, name in (
        (decay, DARK, "o", "full", "yaw only"),
        (found.flying, ORANGE, "s", "none", "free flight"),
    ):
        ax.plot(one.phases, one.first_halves / ms, color=color, marker=marker, fillstyle=fill, markersize=4.5,
                linewidth=1.0, label=name)  # fmt: skip
    for level, color, text in ((model.half_life, DARK, "ln 2 I / β"), (free, ORANGE, "ln 2 I / β, free to roll")):
        ax.axhline(level / ms, color=color, linewidth=0.9, linestyle=(0, (4, 2)))
        ax.annotate(text, (0.89, level / ms), (0, 3), textcoords="offset points", ha="right", fontsize=7.5)
    ax.set(xlabel="phase of the kick [wingbeats]", ylabel="until the yaw rate has halved [ms]",
           title="d  half-life by phase", xlim=(-0.03, 0.9), ylim=(0, 6))  # fmt: skip
    ax.legend(loc="lower left", fontsize=7.5)


def _saved(figure: Any, kind: str) -> bytes:
    buffer = io.BytesIO()
    metadata = {"Date": None, "Creator": None} if kind == "svg" else {"Software": None}
    figure.savefig(buffer, format=kind, dpi=150, metadata=metadata)
    return buffer.getvalue()


# ## The answer
#
# **Of a fly that can only yaw, paddling tells the turn within 1.3 %, at 0.790 omega where Eq. 5 has omega.** Over 14
# turns of 12 to 115 deg the angle is 0.987 to 0.996 of gamma/beta times the integral of the paddling angle; 0.4 % is
# lost to averaging over the wingbeat, the rest to the cosine in C_D, which leaves its straight line by 5 % at 15.5
# deg. Yaw damping is straight far beyond any turn. In free flight nobody steers, and the fly banks by up to 56 deg as
# it paddles; about its own normal it turns by 0.92 to 1.09 of the same product. Read between low yaw rates, as
# recordings are, the slope of the tethered turns comes out as 0.80 to 0.85 omega, since the window cuts the slow end
# of a turn.
#
# The real turns scatter far more: seven of them miss their slope by 31 deg rms. Their paddling angle has an uncertain
# zero, and they roll while they turn.
#
# That gamma/beta is near omega, as in the mean wingbeat of *D. hydei* (0.987), is where larger factors meet. Speed
# that varies over the stroke gives 1.17 to 1.25, 1.23 for a sine and 1 with the speed that drag weighs in place of the
# mean; the hinge's distance to the side 0.84 to 0.86; pitch that is no square wave 0.80 to 0.94; deviation 1.00 to
# 1.22; and C_D'/(2 C_D), 0.92 at 45 deg, is 0.845 to 1.180 at the strokes' own attack angles. Rotation, added mass and
# dissipation stay within 2.1 %. Pitch and deviation interact: to a measured stroke that has its deviation already,
# pitch is 0.92 to 0.93.
#
# A kicked fly on a tether yaws half as fast after 4.36 ms, 1.00 wingbeats, with the built-in stroke and after 6.52 ms
# with the measured one; ln 2 I / beta says 4.35 and 6.50 ms. In free flight it is 2.73 ms: a fly that is free to roll
# meets a yaw torque with a third less inertia. The reduced model with I about the vertical is that of a fly whose roll
# is held, by a tether or by a faster loop. Damping lies inside the published range with both strokes. The inertia is
# 14 % below the published one, which is for a body 45 deg nose up, where this fly's stroke plane puts it at 55 deg.
#
# All this is for wings whose pitch is given. On springs they give way as the body turns: beta falls from 2.81e-11 to
# 1.36e-11 N m s, 35 % below the published range, and yaw lasts twice as long, 13.04 ms once the pitch has followed,
# where the reduced model with the springs' own beta says 13.36 ms.


def as_text(found: Findings) -> str:
    """The answer as a page of Markdown."""
    gain, model, decay = found.hover.gain, found.hover.model, found.hover.decay
    return (
        "# Turn angle from paddling\n\n"
        f"Built-in hover of *D. melanogaster*, trimmed: {gain.speeds.mean:.0f} rad/s mean wing speed omega, beta = "
        f"{model.damping:.3g} N m s, gamma = {model.paddling:.3g} N m/rad, gamma/beta = {gain.ratio:.0f} 1/s = "
        f"{gain.over_wing_speed:.3f} omega, from torques on a fly that is held.\n\n"
        "Simulated turns by a bump of paddling (length from half up to half down); angles in deg. By slope: gamma/beta "
        "times the integral of d_alpha. As read: the same tethered turn read between low yaw rates, as a recording is; "
        "Eq. 5 then has omega times the integral within that window.\n\n"
        "| amplitude [deg] | length [wingbeats] | Eq. 5: omega | by slope | yaw only | free flight | tilt at its end "
        "| as read: turn | as read: Eq. 5 |\n|---|---|---|---|---|---|---|---|---|\n"
        + "\n".join(_turn_row(found, turn) for turn in found.turns)
        + "\n\n"
        + _real_table(found)
        + "gamma/(beta omega), factor by factor; in brackets the factor if the part came last:\n\n"
        f"| | {' | '.join(stroke.name for stroke in found.strokes)} |\n|---|{'---|' * len(found.strokes)}\n"
        + _factor_rows(found)
        + "\n\nomega is the mean of the wing's angular speed. Others that one may mean [rad/s]:\n\n"
        "| stroke | mean | rms | as drag weighs it, <phi'^2>/<phi'> | largest | alpha_0 [deg] |\n"
        "|---|---|---|---|---|---|\n"
        + "\n".join(_speed_row(stroke) for stroke in found.strokes)
        + "\n\nThe yaw torque leaves its straight line by 5 % "
        + (
            f"at {found.turned.linear_range:.0f} rad/s"
            if found.turned.leaves
            else f"nowhere up to {found.turned.linear_range:.0f} rad/s"
        )
        + f" of yaw and at {found.paddled.linear_range / deg:.1f} deg of paddling; the cubic parts are "
        f"{found.turned.cubic:.3g} N m s^3 and {found.paddled.cubic:.3g} N m/rad^3, "
        f"{found.turned.share_of_cubic(36.0):.1e} of the torque at 36 rad/s and "
        f"{found.paddled.share_of_cubic(5 * deg):.1%} at 5 deg.\n\n"
        "Half-life of yaw after a short kick, and the reduced model's ln 2 I / beta, on the tether:\n\n"
        "| stroke | I, body [kg m^2] | wings | air | beta [N m s] | gamma [N m/rad] | ln 2 I / beta [ms] "
        "| simulated [ms] | [wingbeats] | by phase of the kick [ms] |\n|---|---|---|---|---|---|---|---|---|---|\n"
        + "\n".join(_half_row(stroke) for stroke in found.strokes)
        + f"\n\nIn free flight the built-in hover's yaw rate halves in {found.flying.half_life / ms:.2f} ms: body and "
        f"wings free to roll meet a yaw torque with {model.inertia.free:.3g} kg m^2 instead of "
        f"{model.inertia.total:.3g}, which makes ln 2 I / beta "
        f"{np.log(2) * model.inertia.free / model.damping / ms:.2f} ms, against "
        f"{decay.half_life / ms:.2f} ms on the tether.\n\n"
        + _springs_sentence(found)
        + "Beside published numbers of *D. melanogaster*:\n\n"
        "| stroke | quantity | ours | published | agreement | source |\n|---|---|---|---|---|---|\n"
        + _published_rows(found)
        + "\n\n![Turns against paddling, the slope taken apart, half-lives](turn_angle_from_paddling.svg)\n"
    )


def _turn_row(found: Findings, turn: SimulatedTurn) -> str:
    gain = found.hover.gain
    return (
        f"| {turn.amplitude / deg:+.0f} | {turn.length:.0f} | {gain.speeds.mean * turn.integral / deg:.1f} "
        f"| {gain.ratio * turn.integral / deg:.1f} | {turn.tethered / deg:.1f} | {turn.flying / deg:.1f} "
        f"| {turn.tilt / deg:.0f} | {turn.windowed.angle / deg:.1f} | {turn.windowed.by_wing_speed / deg:.1f} |"
    )


def _real_table(found: Findings) -> str:
    if not found.real:
        return "Real flights were not at hand.\n\n"
    rows = "\n".join(
        f"| {one.flight} | {one.turn.start / ms:.0f}-{one.turn.end / ms:.0f} | {one.turn.wingbeats} "
        f"| {'yes' if one.turn.complete else 'no'} | {one.turn.by_wing_speed / deg:.0f} "
        f"| {one.turn.by_wing_speed_trimmed / deg:.0f} | {one.slope * one.turn.by_wing_speed / deg:.0f} "
        f"| {one.turn.angle / deg:.0f} |"
        for one in found.real
    )
    return (
        "Real turns of *D. hydei* [deg], as `flycontrol report --recording` reads them; by slope: blade elements at "
        "the flight's own mean stroke.\n\n"
        "| flight | from-to [ms] | wingbeats | complete | Eq. 5: omega | less the flight's median d_alpha | by slope "
        f"| measured |\n|---|---|---|---|---|---|---|---|\n{rows}\n\n"
    )


def _factor_rows(found: Findings) -> str:
    gains = [stroke.gain for stroke in found.strokes]
    rows = ["| C_D'/(2 C_D) at alpha_0 | " + " | ".join(f"{gain.drag_slope:.3f}" for gain in gains) + " |"]
    for one in gains[0].factors:
        each = " | ".join(f"{gain[one.name].factor:.3f} ({gain[one.name].alone:.3f})" for gain in gains)
        rows.append(f"| {one.name} | {each} |")
    rows.append("| product | " + " | ".join(f"{gain.product / gain.speeds.mean:.3f}" for gain in gains) + " |")
    rows.append("| measured gamma/(beta omega) | " + " | ".join(f"{gain.over_wing_speed:.3f}" for gain in gains) + " |")
    return "\n".join(rows)


def _speed_row(stroke: Stroke) -> str:
    s = stroke.gain.speeds
    attack = stroke.gain.attack / deg
    return f"| {stroke.name} | {s.mean:.0f} | {s.rms:.0f} | {s.by_drag:.0f} | {s.largest:.0f} | {attack:.1f} |"


def _half_row(stroke: Stroke) -> str:
    model, decay = stroke.model, stroke.decay
    first, last = decay.first_halves.min() / ms, decay.first_halves.max() / ms
    return (
        f"| {stroke.name} | {model.inertia.body:.3g} | {model.inertia.wings:.2g} | {model.inertia.air:.2g} "
        f"| {model.damping:.3g} | {model.paddling:.3g} | {model.half_life / ms:.2f} | {decay.half_life / ms:.2f} "
        f"| {decay.in_wingbeats:.2f} | {first:.2f} to {last:.2f} |"
    )


def _springs_sentence(found: Findings) -> str:
    if found.springs is None:
        return ""
    one = found.springs
    return (
        f"With wings on springs (measured hover, pitch axis at {PITCH_AXIS:g} chords, kappa = "
        f"{one.spring.stiffness:.3g} N m/rad, C = {one.spring.damping:.3g} N m s/rad) beta is "
        f"{one.passive.damping:.3g} instead of {one.given.damping:.3g} N m s, gamma "
        f"{one.passive.paddling:.3g} N m/rad and mu, by torque, "
        f"{one.passive.transmission:.2f}; ln 2 I / beta is {one.passive.half_life / ms:.2f} ms, and a kicked fly on "
        f"the tether halves its yaw rate in {one.decay.late_half_life / ms:.2f} ms once the pitch has followed "
        f"({one.decay.half_life / ms:.2f} ms over the first wingbeat).\n\n"
    )


def _published_rows(found: Findings) -> str:
    models = [(stroke.name, stroke.model) for stroke in found.strokes if "melanogaster" in stroke.name]
    if found.springs is not None:
        models.append(("the same, wings on springs", found.springs.passive))
    rows = []
    for name, model in models:
        for one in beside_published(model):
            published = f"{one.low:.3g}" if one.low == one.high else f"{one.low:.3g} to {one.high:.3g}"
            sources = ", ".join(f"{p.source} ({p.certainty})" for p in one.sources)
            cells = (name, f"{one.name} [{one.unit}]", f"{one.ours:.3g}", published, one.agreement, sources)
            rows.append(f"| {' | '.join(cells)} |")
    return "\n".join(rows)


CLOSE, ROUGH = 0.10, 0.25


def graded(off: float) -> str:
    """In words: within 10 %, within 25 %, or not."""
    return "agrees" if abs(off) <= CLOSE else "roughly" if abs(off) <= ROUGH else "fails"


def claims(found: Findings) -> list[dict[str, str]]:
    """What the review says of turns, what comes out here, and whether they agree."""
    omega = found.hover.gain.speeds.mean
    said = np.array([omega * turn.integral for turn in found.turns])
    held, free = (np.array([getattr(turn, name) for turn in found.turns]) for name in ("tethered", "flying"))
    slopes = [float(said @ turned / (said @ said)) for turned in (held, free)]
    off = float(np.abs([found.share(turn, turn.tethered) - 1 for turn in found.turns]).max())
    gains = {stroke.name: stroke.gain.over_wing_speed for stroke in found.strokes}
    inertia, _, half_life = beside_published(found.hover.model)[:3]
    tethered, flying = found.hover.decay.half_life, found.flying.half_life
    inside = [half_life.low <= one <= half_life.high for one in (tethered, flying)]
    return [
        {"claim": "turn angle grows with the strength of paddling and its length, and with nothing else",
         "published": "Fig. 5c", "agreement": "agrees" if off < CLOSE else "fails",
         "ours": f"{len(found.turns)} simulated turns on a tether follow (gamma/beta) times the integral of d_alpha "
                 f"within {100 * off:.1f} %",
         "where": "section 4, Fig. 5c", "basis": "simulated"},
        {"claim": "turn angle over paddling parameter", "published": "1",
         "ours": f"{slopes[0]:.2f} on a tether, {slopes[1]:.2f} in free flight",
         "agreement": graded(max((slope - 1 for slope in slopes), key=abs)),
         "where": "section 4, Fig. 5c", "basis": "simulated"},
        *_real_claims(found),
        {"claim": "gamma/beta over omega, the mean angular speed of the wings", "published": "1",
         "ours": ", ".join(f"{gain:.2f} ({name})" for name, gain in gains.items()),
         "agreement": graded(max((gain - 1 for gain in gains.values()), key=abs)),
         "where": "section 4, Eq. 5", "basis": "simulated"},
        {"claim": "yaw torque is linear in the paddling angle", "published": "small angles",
         "ours": f"leaves its straight line by 5 % at {found.paddled.linear_range / deg:.1f} deg",
         "agreement": "agrees" if found.paddled.linear_range > 5 * deg else "fails",
         "where": "section 4, Eq. 2", "basis": "simulated"},
        {"claim": "yaw inertia about the vertical [1e-13 kg m^2]", "published": f"{1e13 * inertia.low:.2f}",
         "ours": f"{1e13 * inertia.ours:.2f}, body and wings", "agreement": graded(inertia.ours / inertia.low - 1),
         "where": "section 4, Eq. 1", "basis": "simulated"},
        {"claim": "half-life of yaw after a kick [ms]",
         "published": f"{half_life.low / ms:.1f} to {half_life.high / ms:.1f}, from published inertia and damping",
         "ours": f"{tethered / ms:.1f} on a tether, {flying / ms:.1f} in free flight",
         "agreement": "fails" if not any(inside) else "agrees" if all(inside) else "roughly: on one of the two",
         "where": "section 4, Eq. 3", "basis": "simulated"},
    ]  # fmt: skip


def _real_claims(found: Findings) -> list[dict[str, str]]:
    """The turns of real flights, where there are any."""
    turns = [one.turn for one in found.real if one.turn.complete]
    if not turns:
        return []
    said, turned = (np.array([getattr(turn, name) for turn in turns]) for name in ("by_wing_speed", "angle"))
    slope = float(said @ turned / (said @ said))
    pairs = ", ".join(f"{angle / deg:.0f} ({paddled / deg:.0f})" for angle, paddled in zip(turned, said, strict=True))
    return [
        {"claim": "turn angle over paddling parameter, recorded flights of *D. hydei*", "published": "1",
         "ours": f"{slope:.2f}; turned (by paddling) {pairs} deg",
         "agreement": graded(slope - 1) + ": evasive and banked, and the zero of paddling is not certain",
         "where": "section 4, Fig. 5c", "basis": "real data"},
    ]  # fmt: skip


def as_numbers(found: Findings) -> str:
    """The numbers as JSON, six digits."""
    rows: dict[str, Any] = {
        "claims": claims(found),
        "simulated_turns_deg": [
            {
                "amplitude": turn.amplitude / deg,
                "length_wingbeats": turn.length,
                "by_wing_speed": found.hover.gain.speeds.mean * turn.integral / deg,
                "by_slope": found.hover.gain.ratio * turn.integral / deg,
                "yaw_only": turn.tethered / deg,
                "free_flight": turn.flying / deg,
                "tilt": turn.tilt / deg,
                "as_read": {"turn": turn.windowed.angle / deg, "by_wing_speed": turn.windowed.by_wing_speed / deg},
            }
            for turn in found.turns
        ],
        "real_turns_deg": [
            {
                "flight": one.flight,
                "complete": one.turn.complete,
                "wingbeats": one.turn.wingbeats,
                "by_wing_speed": one.turn.by_wing_speed / deg,
                "by_wing_speed_trimmed": one.turn.by_wing_speed_trimmed / deg,
                "slope_over_wing_speed": one.slope,
                "measured": one.turn.angle / deg,
            }
            for one in found.real
        ],
        "strokes": {stroke.name: _stroke_numbers(stroke) for stroke in found.strokes},
        "free_flight_half_life_ms": found.flying.half_life / ms,
        "wings_on_springs": None if found.springs is None else _springs_numbers(found.springs),
        "linear_range": {
            "yaw_rate_rad_s": found.turned.linear_range if found.turned.leaves else None,
            "paddling_deg": found.paddled.linear_range / deg,
            "cubic_yaw_N_m_s3": found.turned.cubic,
            "cubic_paddling_N_m_per_rad3": found.paddled.cubic,
        },
    }
    short = json.loads(json.dumps(rows), parse_float=lambda text: float(f"{float(text):.6g}"))
    return json.dumps(short, indent=2) + "\n"


def _stroke_numbers(stroke: Stroke) -> dict[str, Any]:
    gain, model = stroke.gain, stroke.model
    return {
        "beta_N_m_s": model.damping,
        "gamma_N_m_per_rad": model.paddling,
        "inertia_kg_m2": {
            "body": model.inertia.body, "wings": model.inertia.wings, "air": model.inertia.air,
            "free_to_roll": model.inertia.free,
        },
        "omega_rad_s": {
            "mean": gain.speeds.mean, "rms": gain.speeds.rms, "by_drag": gain.speeds.by_drag,
            "largest": gain.speeds.largest,
        },
        "alpha_0_deg": gain.attack / deg,
        "turn_gain_1_s": gain.ratio,
        "turn_gain_over_omega": gain.over_wing_speed,
        "drag_slope": gain.drag_slope,
        "factors": {one.name: one.factor for one in gain.factors},
        "factors_if_last": {one.name: one.alone for one in gain.factors},
        "half_life_ms": {"reduced": model.half_life / ms, "simulated_yaw_only": stroke.decay.half_life / ms},
    }  # fmt: skip


def _springs_numbers(one: OnSprings) -> dict[str, Any]:
    return {
        "kappa_N_m_per_rad": one.spring.stiffness,
        "C_N_m_s_per_rad": one.spring.damping,
        "beta_N_m_s": one.passive.damping,
        "gamma_N_m_per_rad": one.passive.paddling,
        "mu_torque": one.passive.transmission,
        "half_life_ms": {
            "reduced": one.passive.half_life / ms,
            "simulated_late": one.decay.late_half_life / ms,
            "simulated_first_wingbeat": one.decay.half_life / ms,
        },
    }


def main(folder: Path = FOLDER) -> Findings:
    """Find, draw and write."""
    found = findings()
    text = opened(__file__, as_text(found))
    write_files_atomically(
        folder,
        {
            "turn_angle_from_paddling.md": text,
            "turn_angle_from_paddling.json": as_numbers(found),
            "turn_angle_from_paddling.svg": draw(found)["turn_angle_from_paddling.svg"],
        },
    )
    print(text)
    return found


if __name__ == "__main__":
    main(folder_named(__file__, __doc__, FOLDER))
