"""Is the hinge of a fly's wing a damped spring, and does biasing the spring paddle the wings?  (Fig. 6 of the review)

Run with `python analyses/hinge_as_a_spring.py [FOLDER]`; the measurements are looked for in $FLYCONTROL_DATA, else in
../shared/data. The note, the numbers and the figure go to reports/hinge_as_a_spring unless a folder is given.
"""

import io
import json
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from _by_hand import DATA, REPORTS, folder_named, measured
from numpy.typing import NDArray

from flycontrol.flight.flapping_fly import FlappingFly
from flycontrol.flight.hinge_fit import HingeFit, at_pitch_axis, fitted_spring
from flycontrol.flight.hinge_transmission import (
    BiasedWingbeat,
    HingeTransmission,
    biased_wingbeat,
    hinge_transmission,
)
from flycontrol.flight.hinge_work import PitchTorques, WorkLoop, held_wingbeat, pitch_torques, work_loop
from flycontrol.flight.multibody.inverse import inverse_dynamics
from flycontrol.flight.quasi_steady import TERMS
from flycontrol.flight.replay import inner_wingbeats, replayed
from flycontrol.flight.trim import hover_trim
from flycontrol.io.morphology import read_morphology_table
from flycontrol.io.recordings import read_recording
from flycontrol.io.series_conventions import CONVENTIONS
from flycontrol.io.series_files import read_series_file
from flycontrol.jobs.files import write_files_atomically
from flycontrol.jobs.work import generator
from flycontrol.model.hinge import PUBLISHED_STIFFNESS, PUBLISHED_TRANSMISSION
from flycontrol.model.morphology import drosophila_hydei, morphology_from_table
from flycontrol.model.stroke_kinematics import StrokeKinematics
from flycontrol.model.wing_stroke import fourier_stroke
from flycontrol.model.wingbeats import segment_wingbeats, wingbeat_mean
from flycontrol.reduce.reduced_yaw import reduced_yaw
from flycontrol.units import deg

if TYPE_CHECKING:
    from matplotlib.axes import Axes

FloatArray = NDArray[np.float64]
FOLDER = REPORTS / "hinge_as_a_spring"

# ## The question
#
# The review takes the torque that a fly exerts about the long axis of its wing, plots it against the wing's pitch and
# finds a loop that looks like a damped spring's, tau = -kappa (eta - eta_0) - C eta'. Bias the spring's rest angle
# eta_0, it says, and the wings paddle: d_alpha = mu d_eta_0 with mu = 0.6 (its caption: about one half).
#
# Assume a damped spring, simulate, plot torque against pitch, and the loop is there by construction. So the torque is
# taken here from measured motion by inverse dynamics; only then is a spring asked to make that motion.
#
# Two wingbeats were measured: the hover of *D. melanogaster* (Fry 2005, digitised by others) and the mean wingbeat of
# *D. hydei* in free flight. Fly, air and wing mass are the package's published ones: the wing an even plate of 0.22 %
# of the body's mass, translational, rotational, added-mass and dissipative terms.


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MeasuredFly:
    """A fly and its measured wingbeat."""

    name: str
    fly: FlappingFly
    stroke: StrokeKinematics


def hovering_fly() -> MeasuredFly:
    """*D. melanogaster*, hovering."""
    path, frequency = DATA / "kinematics_fourier" / "Drosophila_hovering_fry.json", 218.0
    morphology = morphology_from_table(read_morphology_table(), "Drosophila melanogaster", frequency)
    stroke = read_series_file(path, CONVENTIONS["hovering fruit fly"])
    return MeasuredFly(
        name="D. melanogaster, hover",
        fly=FlappingFly(morphology=morphology),
        stroke=StrokeKinematics.symmetric(stroke, frequency),
    )


def free_fly() -> MeasuredFly:
    """*D. hydei*, mean wingbeat of free flight; the file's stroke and pitch count the other way round."""
    path, frequency = DATA / "muijres_mean_wingbeats" / "steady_free_flight.csv", 189.0
    table = np.genfromtxt(path, delimiter=",", names=True)[:-1]
    angles = np.stack([-table["stroke_mean_deg"], table["dev_mean_deg"], 180 - table["pitch_mean_deg"]], axis=1) * deg
    return MeasuredFly(
        name="D. hydei, mean wingbeat",
        fly=FlappingFly(morphology=drosophila_hydei(frequency)),
        stroke=StrokeKinematics.symmetric(fourier_stroke(np.arange(len(table)) / len(table), angles, 12), frequency),
    )


# ## Where is the pitch axis?
#
# Nobody has told us, and nearly everything hangs on it: at a quarter of the chord the centre of pressure of a wing at
# 45 deg lies on the axis, and the steady air turns the wing hardly at all. So all is computed for axes from the leading
# edge to 0.3 chords behind it. The figures are drawn for the one at which passive pitching comes closest to both
# measured wingbeats (least sum of squares of the two rms errors) among these axes.

PITCH_AXES = (0.0, 0.05, 0.1, 0.15, 0.2, 0.25, 0.3)  # [chords from the leading edge]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class AtAxis:
    """What one fly's wingbeat says if the wing pitches about this axis."""

    fit: HingeFit  #: the spring whose passive pitching comes closest
    loop: WorkLoop  #: of the measured motion
    transmission: HingeTransmission  #: of the spring that was found


def at_axis(measured: MeasuredFly, pitch_axis: float) -> AtAxis:
    """Inverse dynamics, the closest spring, and what its bias does."""
    fly = at_pitch_axis(measured.fly, pitch_axis)
    fit = fitted_spring(fly, measured.stroke)
    return AtAxis(
        fit=fit,
        loop=work_loop(pitch_torques(fly, held_wingbeat(fly, measured.stroke))),
        transmission=hinge_transmission(fly, measured.stroke, fit.spring),
    )


def closest_axis(profiles: dict[str, list[AtAxis]]) -> int:
    """Index into PITCH_AXES."""
    return int(np.argmin(np.sum([[one.fit.rms**2 for one in profile] for profile in profiles.values()], axis=0)))


# ## What else may be wrong
#
# Wing mass and its place along the chord, and the terms of the air, at the axis that was chosen, one at a time.


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Variation:
    """The hovering fly with one thing changed."""

    name: str
    found: AtAxis


def variations(measured: MeasuredFly, pitch_axis: float) -> list[Variation]:
    """Wing mass, its spread along the chord, each term of the air beyond translation, other coefficients."""
    fly = at_pitch_axis(measured.fly, pitch_axis)
    changed = {
        "as above": fly,
        "half the wing mass": with_wing(fly, mass=0.5),
        "twice the wing mass": with_wing(fly, mass=2.0),
        "mass half as far from the axis": with_wing(fly, spread=0.5),
        "without rotational lift": without(fly, "rotational"),
        "without added mass": without(fly, "added_mass"),
        "without dissipation": without(fly, "dissipative"),
        "coefficients of whitney2010": replace(fly, air=replace(fly.air, coefficients="whitney2010")),
    }
    return [
        Variation(name=name, found=at_axis(replace(measured, fly=one), pitch_axis)) for name, one in changed.items()
    ]


def with_wing(fly: FlappingFly, mass: float = 1.0, spread: float = 1.0) -> FlappingFly:
    """Wing mass scaled, and squeezed towards the pitch axis along the chord."""
    wing = fly.morphology.wing_body
    span, chord = mass * spread**2 * wing.span_inertia, mass * wing.chord_inertia
    changed = replace(
        wing,
        mass=mass * wing.mass,
        centre=(wing.centre[0], spread * wing.centre[1]),
        span_inertia=span,
        chord_inertia=chord,
        normal_inertia=span + chord,
        product=mass * spread * wing.product,
    )
    return replace(fly, morphology=replace(fly.morphology, wing=changed))


def without(fly: FlappingFly, term: str) -> FlappingFly:
    """The fly in air without one of its terms."""
    return replace(fly, air=replace(fly.air, terms=tuple(kept for kept in fly.air.terms if kept != term)))


# ## Turning flies
#
# In hover nothing is biased. Three recordings of *D. hydei*, two of them banked turns, are replayed instead. The
# damper takes no part in a wingbeat's mean, so with kappa from the steady wingbeat's loop each wingbeat of each wing
# has the rest angle eta_0 = <eta> + <tau> / kappa, tau by inverse dynamics. Half the difference between right and left
# is the bias, and the paddling angle is weighted by phi'^2 as everywhere in the package. The regression of paddling on
# bias is too low where the bias is noisy, the inverse one too high: the truth lies between them, noise alone counted.
# Blocks of five wingbeats are drawn anew for what chance does to both.
#
# Both contain the mean pitch, so that they must agree in part whatever the hinge does. How much of it that is, torques
# of other wingbeats tell: the series of torques is moved along the flight by every number of wingbeats in turn.

FLIGHTS = ("20121009_S0003", "20121120_S0001", "20121128_S0003")
BLOCK, DRAWS, SEED = 5, 4000, 0


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FlownBias:
    """Bias and paddling of n wingbeats of a recorded flight."""

    name: str
    pitch: FloatArray  #: (n,) half of right less left mean pitch [rad]
    strain: FloatArray  #: (n,) half of right less left mean torque, over kappa [rad]
    d_alpha: FloatArray  #: (n,) [rad]

    @property
    def bias(self) -> FloatArray:
        """(n,) d_eta_0 [rad]."""
        return self.pitch + self.strain

    @property
    def correlation(self) -> float:
        """Between bias and paddling."""
        return float(np.corrcoef(self.bias, self.d_alpha)[0, 1])

    @property
    def slopes(self) -> tuple[float, float]:
        """d_alpha on bias, and bias on d_alpha turned over."""
        return slopes_of(self.bias, self.d_alpha)

    @property
    def interval(self) -> tuple[float, float]:
        """Where 95 % of the lower slopes begin and of the upper ones end, blocks of wingbeats drawn anew."""
        n = len(self.bias)
        first = generator(SEED, FLIGHTS.index(self.name)).integers(0, n, (DRAWS, -(-n // BLOCK)))
        rows = (first[:, :, None] + np.arange(BLOCK)).reshape(DRAWS, -1)[:, :n] % n
        drawn = np.array([slopes_of(self.bias[row], self.d_alpha[row]) for row in rows])
        return float(np.percentile(drawn[:, 0], 2.5)), float(np.percentile(drawn[:, 1], 97.5))

    @property
    def correlation_by_pitch(self) -> tuple[float, float]:
        """Median and 97.5th percentile of the correlation with the torques of other wingbeats."""
        moved = [self.pitch + np.roll(self.strain, k) for k in range(1, len(self.bias))]
        found = [np.corrcoef(bias, self.d_alpha)[0, 1] for bias in moved]
        return float(np.median(found)), float(np.percentile(found, 97.5))

    @property
    def slope_by_pitch(self) -> float:
        """Median of d_alpha on bias with the torques of other wingbeats."""
        moved = [self.pitch + np.roll(self.strain, k) for k in range(1, len(self.bias))]
        return float(np.median([slopes_of(bias, self.d_alpha)[0] for bias in moved]))


def slopes_of(bias: FloatArray, d_alpha: FloatArray) -> tuple[float, float]:
    """d_alpha on bias, and bias on d_alpha turned over."""
    ratio, correlation = d_alpha.std() / bias.std(), np.corrcoef(bias, d_alpha)[0, 1]
    return float(correlation * ratio), float(ratio / correlation)


def flown_bias(name: str, fly: FlappingFly, stiffness: float) -> FlownBias:
    """Wingbeat by wingbeat from one recording."""
    recording = read_recording(DATA / "muijres_freeflight" / f"{name}.txt", "muijres_freeflight")
    beats = segment_wingbeats(recording)
    flight, inner = replayed(recording, beats), inner_wingbeats(beats)
    exerted = inverse_dynamics(fly, flight)

    def mean(values: FloatArray) -> FloatArray:
        return wingbeat_mean(values, flight.time, inner)

    apart = 0.5 * (flight.right.pitch - flight.left.pitch)
    torque = 0.5 * (exerted.right_hinge[:, 2] - exerted.left_hinge[:, 2])
    weight = 0.5 * (flight.left.stroke_rate**2 + flight.right.stroke_rate**2)
    return FlownBias(
        name=name,
        pitch=mean(apart),
        strain=mean(torque) / stiffness,
        d_alpha=mean(weight * apart) / mean(weight),
    )


# ## One fly, four dampings
#
# The damping of the measured hover stands in several notes with several numbers. What differs is how its wings pitch,
# about which axis, and whether the stroke is the measured one or trimmed for hover; all by turning the body.

QUARTER = 0.25  #: chords, the package's pitch axis where pitch is given


@dataclass(frozen=True, slots=True, kw_only=True)
class Damping:
    """Beta of the measured hover, taken in one way."""

    how: str
    beta: float  #: [N m s]


def dampings(measured: MeasuredFly, pitch_axis: float, way: HingeTransmission) -> list[Damping]:
    """From springs to trimmed hover."""
    there, plain = at_pitch_axis(measured.fly, pitch_axis), at_pitch_axis(measured.fly, QUARTER)
    trim = hover_trim(plain, measured.stroke)
    return [
        Damping(how="wings on their springs", beta=way.damping),
        Damping(how="wings keep the pitch that they have on their springs", beta=way.damping_at_given_pitch),
        Damping(
            how=f"wings keep the measured pitch, axis at {pitch_axis:g} chords",
            beta=reduced_yaw(there, measured.stroke).damping,
        ),
        Damping(
            how=f"the same, axis at {QUARTER:g} chords (turn_angle_from_paddling)",
            beta=reduced_yaw(plain, measured.stroke).damping,
        ),
        Damping(
            how="the same, stroke trimmed for hover (does_hover_hold, there from the linearised fly)",
            beta=reduced_yaw(plain, trim.kinematics, body_pitch=trim.body_pitch).damping,
        ),
    ]


# ## All of it

BIASES = np.linspace(-25.0, 25.0, 11) * deg
DRAWN_BIAS = 20 * deg


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Findings:
    """All that the note states."""

    flies: tuple[MeasuredFly, ...]
    profiles: dict[str, list[AtAxis]]  #: by fly, over PITCH_AXES
    chosen: int  #: index of the axis of the figures
    torques: dict[str, PitchTorques]  #: by fly, of the measured motion about the chosen axis
    stroke_work: dict[str, float]  #: by fly, what one wing's stroke and deviation take in a wingbeat [J]
    biased: list[BiasedWingbeat]  #: of the hovering fly, over BIASES
    variations: list[Variation]
    flights: list[FlownBias]
    dampings: list[Damping]

    @property
    def pitch_axis(self) -> float:
        """Of the figures [chords]."""
        return PITCH_AXES[self.chosen]

    def at_chosen(self, fly: MeasuredFly) -> AtAxis:
        """What the fly's wingbeat says about the chosen axis."""
        return self.profiles[fly.name][self.chosen]


def findings() -> Findings:
    """Everything, in about a minute."""
    flies = (hovering_fly(), free_fly())
    hover, free = flies
    profiles = {one.name: [at_axis(one, x0) for x0 in PITCH_AXES] for one in flies}
    chosen = closest_axis(profiles)
    x0 = PITCH_AXES[chosen]
    held = {one.name: held_wingbeat(one.fly, one.stroke) for one in flies}
    there = {one.name: at_pitch_axis(one.fly, x0) for one in flies}
    spring = profiles[hover.name][chosen].fit.spring
    kappa = profiles[free.name][chosen].loop.stiffness
    return Findings(
        flies=flies,
        profiles=profiles,
        chosen=chosen,
        torques={name: pitch_torques(there[name], flight) for name, flight in held.items()},
        stroke_work={name: flapping_work(there[name], flight) for name, flight in held.items()},
        biased=[biased_wingbeat(there[hover.name], hover.stroke, spring, bias) for bias in BIASES],
        variations=variations(hover, x0),
        flights=[flown_bias(name, there[free.name], kappa) for name in FLIGHTS],
        dampings=dampings(hover, x0, profiles[hover.name][chosen].transmission),
    )


def flapping_work(fly: FlappingFly, flight: Any) -> float:
    """What stroke and deviation of one wing take in a wingbeat [J]."""
    torque, motion = inverse_dynamics(fly, flight).right_hinge, flight.right
    power = torque[:, 0] * motion.stroke_rate + torque[:, 1] * motion.deviation_rate
    return float(power.mean() / flight.frequency)


# ## The figure

DARK, ORANGE, RED, BLUE, GREY = "#0b3954", "#e08a00", "#c8323c", "#69add5", "#7d7d7d"
NANO = 1e-9


def draw(found: Findings) -> dict[str, bytes]:
    """The figure as SVG, and as PNG for a quick look."""
    from flycontrol.report.style import in_house_style, new_figure

    with in_house_style():
        figure = new_figure(8.4)
        (loop, terms), (passive, biased), (paddled, axes) = figure.subplots(3, 2)
        draw_loop(loop, found)
        draw_torques(terms, found)
        draw_passive(passive, found)
        draw_biased(biased, found)
        draw_paddling(paddled, found)
        draw_axes(axes, found)
        return {f"hinge_as_a_spring.{kind}": _saved(figure, kind) for kind in ("svg", "png")}


def draw_loop(ax: "Axes", found: Findings) -> None:
    """Fig. 6a: the torque exerted on the wing against its pitch, and the damped spring closest to it."""
    fly = found.flies[0]
    torques, loop = found.torques[fly.name], found.at_chosen(fly).loop
    pitch, tau = closed(torques.pitch) / deg, closed(torques.hinge) / NANO
    spring = -loop.stiffness * (torques.pitch - loop.rest_angle) - loop.damping * torques.pitch_rate
    ax.axhline(0, color=GREY, linewidth=0.6)
    ax.plot(pitch, tau, color=DARK, linewidth=1.7, label="inverse dynamics")
    for k in (9, 26, 118, 136):
        ax.annotate("", (pitch[k + 2], tau[k + 2]), (pitch[k], tau[k]),
                    arrowprops={"arrowstyle": "-|>", "color": DARK, "mutation_scale": 13})  # fmt: skip
    ax.plot(pitch, closed(spring) / NANO, color=ORANGE, linewidth=1.4, linestyle=(0, (4, 1.6)),
            label=f"closest damped spring, R² {loop.explained:.2f}")  # fmt: skip
    low, high = ax.get_ylim()
    ax.set(xlabel="pitch [deg]", ylabel="torque on the wing [nN m]", ylim=(low, high + 0.38 * (high - low)))
    ax.set_title("a  Work loop of a hovering fly")
    ax.legend(loc="upper left", handlelength=2.4)


def draw_torques(ax: "Axes", found: Findings) -> None:
    """Who turns the wing: hinge, air, and the wing's mass carried about."""
    torques = found.torques[found.flies[0].name]
    air = np.sum([torques.air[term] for term in TERMS], axis=0)
    phase = np.arange(len(torques.pitch)) / len(torques.pitch)
    ax.axvspan(0, forward_end(found), color="#f1efec", zorder=0)
    ax.axhline(0, color=GREY, linewidth=0.6)
    ax.plot(phase, torques.hinge / NANO, color=DARK, linewidth=1.7, label="hinge")
    ax.plot(phase, air / NANO, color=BLUE, linewidth=1.5, linestyle=(0, (4, 1.6)), label="air")
    ax.plot(phase, -torques.inertia / NANO, color=RED, linewidth=1.5, linestyle=(0, (1, 1.2)), label="wing's inertia")
    low, high = ax.get_ylim()
    ax.set(xlabel="wingbeat (shaded: forward stroke)", ylabel="torque on the wing [nN m]", xlim=(0, 1),
           ylim=(low, high + 0.25 * (high - low)))  # fmt: skip
    ax.set_title("b  Torques about the pitch axis")
    ax.legend(loc="upper left", ncols=3, handlelength=1.8, columnspacing=1.2)


def draw_passive(ax: "Axes", found: Findings) -> None:
    """Fig. 6b: measured pitch and that of the wing on its spring."""
    for fly, shift in zip(found.flies, (0.0, 135.0), strict=True):
        fit = found.at_chosen(fly).fit
        phase = fit.passive.trajectory.phase
        measured = fly.stroke.right(phase).angles[:, 2]
        ax.plot(phase, measured / deg + shift, color=DARK, linewidth=1.7)
        ax.plot(phase, fit.passive.trajectory.right.pitch / deg + shift, color=ORANGE, linewidth=1.5,
                linestyle=(0, (4, 1.6)))  # fmt: skip
        name = fly.name.split(",")[0] + (f", drawn {shift:.0f}° up" if shift else "")
        ax.annotate(f"{name}: {fit.rms / deg:.1f}° rms", (0.03, 132 + 1.5 * shift), fontsize=8)
    ax.plot([], [], color=DARK, linewidth=1.7, label="measured")
    ax.plot([], [], color=ORANGE, linewidth=1.5, linestyle=(0, (4, 1.6)), label="passive, on a spring")
    ax.axvspan(0, forward_end(found), color="#f1efec", zorder=0)
    ax.set(xlabel="wingbeat", ylabel="pitch [deg]", xlim=(0, 1), ylim=(-25, 365))
    ax.set_title("c  Passive and measured pitch")
    ax.legend(loc="lower left", bbox_to_anchor=(0.0, -0.02), ncols=2, handlelength=2.4)


def draw_biased(ax: "Axes", found: Findings) -> None:
    """Fig. 6c: both wings with their springs biased apart."""
    beat = min(found.biased, key=lambda one: abs(one.bias - DRAWN_BIAS))
    flight = beat.passive.trajectory
    hover = found.at_chosen(found.flies[0]).fit.passive.trajectory
    ax.axvspan(0, forward_end(found), color="#f1efec", zorder=0)
    ax.plot(flight.phase, flight.right.pitch / deg, color=RED, linewidth=1.6, label="right, spring up")
    ax.plot(flight.phase, hover.right.pitch / deg, color=GREY, linewidth=1.1, linestyle=(0, (1, 1.2)), label="no bias")
    ax.plot(flight.phase, flight.left.pitch / deg, color=DARK, linewidth=1.6, linestyle=(0, (4, 1.6)),
            label="left, spring down")  # fmt: skip
    ax.set(xlabel="wingbeat", ylabel="pitch [deg]", xlim=(0, 1), ylim=(0, 215))
    ax.set_title(f"d  Rest angles biased by ±{beat.bias / deg:.0f}°")
    ax.legend(loc="upper left", ncols=2, handlelength=2.2, columnspacing=1.0)


def draw_paddling(ax: "Axes", found: Findings) -> None:
    """Fig. 6d: paddling against bias, simulated, flown, and as the review has it."""
    line = np.array([-25.0, 25.0])
    low, high = PUBLISHED_TRANSMISSION
    ax.fill_between(line, low * line, high * line, color="#d9d9d9", label="review, 0.5 to 0.6")
    for flight, marker, shade in zip(found.flights, ("o", "^", "s"), (BLUE, ORANGE, GREY), strict=True):
        ax.plot(flight.bias / deg, flight.d_alpha / deg, marker, color=shade, markersize=3.2, markeredgecolor="#1a1a1a",
                markeredgewidth=0.4, linestyle="none", label=f"flight {flight.name[:8]}")  # fmt: skip
    bias, d_alpha = (np.array([getattr(one, name) for one in found.biased]) / deg for name in ("bias", "d_alpha"))
    ax.plot(bias, d_alpha, color=DARK, linewidth=1.7, label="simulated hover")
    ax.set(xlabel="bias of the rest angles [deg]", ylabel="paddling angle [deg]", xlim=(-13, 13), ylim=(-8, 12))
    ax.set_title("e  Bias paddles")
    ax.legend(loc="upper left", handlelength=1.6, fontsize=7.5, ncols=2, columnspacing=1.0)


def draw_axes(ax: "Axes", found: Findings) -> None:
    """mu over the place of the pitch axis."""
    low, high = PUBLISHED_TRANSMISSION
    ax.axhspan(low, high, color="#d9d9d9", label="mu of the review")
    looks = ((DARK, "o", "-"), (RED, "s", (0, (4, 1.6))))
    for fly, (shade, marker, dash) in zip(found.flies, looks, strict=True):
        mu = [one.transmission.mu for one in found.profiles[fly.name]]
        kappa = [one.fit.spring.stiffness / NANO for one in found.profiles[fly.name]]
        ax.plot(PITCH_AXES, mu, color=shade, marker=marker, markersize=3.5, linestyle=dash, linewidth=1.5,
                label=fly.name.split(",")[0])  # fmt: skip
        for k in (0, 2, 4):
            away = (-4, 6) if marker == "s" else (-4 - 9 * k // 2, -12)
            ax.annotate(f"κ {kappa[k]:.2g}", (PITCH_AXES[k], mu[k]), away, textcoords="offset points", fontsize=7.5)
    ax.annotate("κ of the closest spring in nN m/rad", (0.005, 0.03), fontsize=7.5)
    ax.axvline(found.pitch_axis, color=GREY, linewidth=0.7, linestyle=(0, (1, 2)))
    ax.set(xlabel="pitch axis [chords behind the leading edge]", ylabel="mu", ylim=(0, 0.86), xlim=(-0.015, 0.31))
    ax.set_title("f  It hangs on the pitch axis")
    ax.legend(loc="upper right", handlelength=2.4)


def forward_end(found: Findings) -> float:
    """Phase at which the hovering fly's forward stroke ends."""
    phase = np.arange(2000) / 2000
    return float(phase[np.argmax(found.flies[0].stroke.right(phase).angles[:, 0])])


def closed(values: FloatArray) -> FloatArray:
    """A periodic line, back to its beginning."""
    return np.append(values, values[0])


def _saved(figure: Any, kind: str) -> bytes:
    buffer = io.BytesIO()
    metadata = {"Date": None, "Creator": None} if kind == "svg" else {"Software": None}
    figure.savefig(buffer, format=kind, dpi=150, metadata=metadata)
    return buffer.getvalue()


# ## The answer
#
# It opens the note, in the words of `answer`; what its numbers are comes from `findings`.


def answer(found: Findings) -> str:
    """All paragraphs."""
    parts = (_brake(found), _who_works(found), _is_it(found), _how_stiff(found), _transmission(found), _turns(found))
    return "\n\n".join([*parts, _giving_way(found), _caveats()])


def _brake(found: Findings) -> str:
    return (
        "**It is a brake, as the review says, but a damped spring explains little more than half of its torque; mu is "
        "nearer to the caption's one half than to the text's 0.6, and all of it hangs on where the pitch axis lies.** "
        f"The figures are drawn for an axis at {found.pitch_axis:g} chords, where passive pitching comes closest to "
        "both "
        "measured wingbeats."
    )


def _who_works(found: Findings) -> str:
    fly, free = found.flies
    torques = found.torques[fly.name]
    air = {term: torques.work(of) / NANO for term, of in torques.air.items()}
    works = [-found.at_chosen(one).loop.work for one in (fly, free)]
    shares = [100 * work / found.stroke_work[one.name] for work, one in zip(works, (fly, free), strict=True)]
    half = next(one.found.loop.work for one in found.variations if one.name == "half the wing mass")
    return (
        "Who works on whom: the loop from measured motion is counter-clockwise, at every axis and whatever else is "
        f"changed. In a wingbeat the hinge takes {works[0] / NANO:.1f} nJ from the pitching wing of the hovering fly "
        "and "
        f"{works[1] / NANO:.1f} nJ from *D. hydei*'s, {shares[0]:.0f} % and {shares[1]:.0f} % of what stroke and "
        "deviation put in: the flips are passive. But it is not the fluid that pays. The wing's own inertia, flung "
        f"about by the stroke, delivers {-torques.work(torques.inertia) / NANO:.1f} nJ; the air gives "
        f"{air['added_mass']:.1f} by added mass and takes "
        f"{-(air['translational'] + air['rotational'] + air['dissipative']):.1f} by circulation and friction. With "
        "half "
        f"the wing mass the work is {-half / NANO:.1f} nJ. Here we disagree with the review's words, not with its loop."
    )


def _is_it(found: Findings) -> str:
    hover, free = (found.at_chosen(fly) for fly in found.flies)
    swing = [np.ptp(found.torques[fly.name].pitch) / deg for fly in found.flies]
    return (
        f"Is it a spring? A damped spring explains {hover.loop.explained:.2f} (hover) and {free.loop.explained:.2f} of "
        f"the torque's variance, a spring alone {hover.loop.explained_by_line:.2f} and "
        f"{free.loop.explained_by_line:.2f}. The loop is no ellipse: the hinge brakes hard after each reversal and "
        "then "
        f"lets go. A wing on the closest spring pitches to {hover.fit.rms / deg:.1f} and {free.fit.rms / deg:.1f} deg "
        "rms "
        f"of the measured {swing[0]:.0f} and {swing[1]:.0f} deg from end to end; it flips late."
    )


def _how_stiff(found: Findings) -> str:
    hover, free = (found.at_chosen(fly) for fly in found.flies)
    axes = found.profiles[found.flies[0].name]
    stiff, soft = (axes[PITCH_AXES.index(x0)] for x0 in (0.0, 0.2))
    forward = next(one.found for one in found.variations if one.name == "mass half as far from the axis")
    return (
        f"How stiff? kappa = {hover.fit.spring.stiffness / NANO:.1f} nN m/rad, C = "
        f"{1e12 * hover.fit.spring.damping:.2f} pN m s/rad for *D. melanogaster*, published are 1 to 3; "
        f"{free.fit.spring.stiffness / NANO:.1f} and {1e12 * free.fit.spring.damping:.2f} for the larger *D. hydei*. "
        "With "
        f"the axis at 0.2 chords kappa would be {soft.fit.spring.stiffness / NANO:.2f}, and the pitch alone cannot "
        "tell: "
        f"between 0 and 0.2 chords the rms goes from {stiff.fit.rms / deg:.1f} to {soft.fit.rms / deg:.1f} deg while "
        "kappa "
        f"falls {stiff.fit.spring.stiffness / soft.fit.spring.stiffness:.1f}-fold. At a given axis kappa is sharp, "
        f"{100 * hover.fit.relative_spread[0]:.0f} % for a hundredth of the rms. With the wing's mass half as far from "
        "the axis, as veins near the leading edge would have it, the miss shrinks to "
        f"{forward.fit.rms / deg:.1f} deg: an even plate is too much wing behind the axis."
    )


def _transmission(found: Findings) -> str:
    hover, free = (found.at_chosen(fly).transmission for fly in found.flies)
    quarter = [found.profiles[fly.name][PITCH_AXES.index(QUARTER)].transmission.mu for fly in found.flies]
    return (
        "mu = d(d_alpha)/d(d_eta_0), by opposite small biases of both rest angles, body held. It depends on what is "
        "called the paddling angle: half of right less left pitch, weighted by phi'^2 as everywhere in the package, "
        f"gives {hover.mu:.2f} in hover and {free.mu:.2f} for *D. hydei*; its *plain* mean over time "
        f"{hover.mu_plain:.2f} and {free.mu_plain:.2f}; at *mid-stroke* {hover.mu_mid_stroke:.2f} and "
        f"{free.mu_mid_stroke:.2f}; in yaw *torque*, torque per bias over torque per paddling of a wing whose pitch is "
        f"given, {hover.mu_torque:.2f} and {free.mu_torque:.2f}. At a quarter chord the first falls to "
        f"{quarter[0]:.2f} "
        f"and {quarter[1]:.2f}."
    )


def _turns(found: Findings) -> str:
    flights = found.flights
    slopes = ", ".join(f"{f.slopes[0]:.2f} to {f.slopes[1]:.2f}" for f in flights)
    return (
        f"In recorded flights paddling goes with the bias from inverse dynamics, with correlations of "
        f"{', '.join(f'{f.correlation:.2f}' for f in flights)} and slopes of {slopes}. But both contain the mean "
        "pitch: "
        "with the torques of other wingbeats, which know nothing of it, correlations are "
        f"{', '.join(f'{f.correlation_by_pitch[0]:.2f}' for f in flights)} (97.5 %: "
        f"{', '.join(f'{f.correlation_by_pitch[1]:.2f}' for f in flights)}) and slopes "
        f"{', '.join(f'{f.slope_by_pitch:.2f}' for f in flights)}. What the hinge adds cannot be told well enough to "
        "confirm or to refute 0.5 to 0.6."
    )


def _giving_way(found: Findings) -> str:
    hover = found.at_chosen(found.flies[0])
    return (
        "Two things that a yaw loop should know. A disturbance of pitch falls to 1/e in "
        f"{hover.fit.passive.settling:.2f} wingbeats, so that the hinge adds hardly any dynamics at the scale of "
        "wingbeats. And wings on springs give way when the body turns: beta is "
        f"{1e12 * hover.transmission.damping:.1f} pN m s where wings that keep their pitch have "
        f"{1e12 * hover.transmission.damping_at_given_pitch:.1f}; published are 21 to 54. "
        "[Recovery at two levels](../recovery_at_two_levels/recovery_at_two_levels.md) flies this spring in the loop."
    )


def _caveats() -> str:
    return (
        "Beware: nobody has told where the pitch axis lies; the wing is an even plate of 0.22 % of the body's mass; "
        "the "
        "hovering wingbeat is one, digitised by others; forces are quasi-steady; kappa, C and eta_0 are fitted to the "
        "measured pitch, mu and beta are not. Made by "
        "[analyses/hinge_as_a_spring.py](../../analyses/hinge_as_a_spring.py)."
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class Claim:
    """One sentence of the review, or a published number, and what becomes of it here."""

    claim: str
    published: str
    ours: str
    agreement: str  #: begins with agrees, roughly, fails or cannot be told
    where: str  #: in the review
    basis: str  #: simulated, or real data


CLOSE, ROUGH = 0.10, 0.25
PUBLISHED_DAMPING = (21e-12, 54e-12)  # beta [N m s]
PUBLISHED_INERTIA = 3.06e-13  # about the vertical in hover, cheng2011 [kg m^2]


def claims(found: Findings) -> list[Claim]:
    """Rows for a reader in a hurry, about the axis of the figures; nothing in them was fitted to agree."""
    return [*spring_claims(found), *transmission_claims(found)]


def spring_claims(found: Findings) -> list[Claim]:
    """Work, and how far a damped spring goes."""
    hover, free = (found.at_chosen(fly) for fly in found.flies)
    torques = found.torques[found.flies[0].name]
    air = sum(torques.work(of) for of in torques.air.values())
    inertia = -torques.work(torques.inertia)
    kappa, low_high = hover.fit.spring.stiffness, [1e9 * k for k in PUBLISHED_STIFFNESS]
    return [
        Claim(
            claim="the loop of torque against pitch is counter-clockwise: the hinge takes work",
            published="Fig. 6a",
            ours=f"work of the hinge {hover.loop.work / NANO:.1f} and {free.loop.work / NANO:.1f} nJ a wingbeat",
            agreement="agrees" if max(hover.loop.work, free.loop.work) < 0 else "fails",
            where="section 5, Fig. 6a",
            basis="real data",
        ),
        Claim(
            claim="the fluid does the work of pitching",
            published="section 5",
            ours=f"the air {air / NANO:+.1f} nJ, the wing's inertia {inertia / NANO:+.1f} nJ",
            agreement="agrees" if air > inertia else "fails: the stroke does it through the wing's mass",
            where="section 5, Fig. 6a",
            basis="real data",
        ),
        Claim(
            claim="the torque is well approximated by a damped spring",
            published="section 5",
            ours=f"R² {hover.loop.explained:.2f} and {free.loop.explained:.2f}",
            agreement=graded(1 - min(hover.loop.explained, free.loop.explained)),
            where="section 5, Fig. 6a",
            basis="real data",
        ),
        Claim(
            claim="kappa [nN m/rad]",
            published=f"{low_high[0]:g} to {low_high[1]:g}",
            ours=f"{kappa / NANO:.1f}",
            agreement=within(kappa, PUBLISHED_STIFFNESS) + ", if the axis is there",
            where="section 5, Fig. 6b",
            basis="simulated and real data",
        ),
    ]


def transmission_claims(found: Findings) -> list[Claim]:
    """What a biased spring turns, and what wings on springs damp."""
    t = found.at_chosen(found.flies[0]).transmission
    return [
        Claim(
            claim="mu, simulated hover",
            published="0.6 (text)",
            ours=f"{t.mu:.2f}",
            agreement=graded(t.mu / 0.6 - 1),
            where="section 5, Fig. 6d",
            basis="simulated",
        ),
        Claim(
            claim="mu, simulated hover",
            published="one half (caption)",
            ours=f"{t.mu:.2f}; {t.mu_torque:.2f} in yaw torque",
            agreement=graded(t.mu / 0.5 - 1),
            where="section 5, Fig. 6d",
            basis="simulated",
        ),
        flown_claim(found),
        Claim(
            claim="beta, wings that keep the pitch that they have in the measured hover [pN m s]",
            published="21 to 54",
            ours=f"{1e12 * t.damping_at_given_pitch:.1f}",
            agreement=within(t.damping_at_given_pitch, PUBLISHED_DAMPING),
            where="section 4, Eq. 3",
            basis="simulated",
        ),
        Claim(
            claim="beta, wings on the springs of the measured hover [pN m s]",
            published="21 to 54",
            ours=f"{1e12 * t.damping:.1f}",
            agreement=within(t.damping, PUBLISHED_DAMPING),
            where="section 4, Eq. 3",
            basis="simulated",
        ),
    ]


def flown_claim(found: Findings) -> Claim:
    """Mu of recorded flights: all of them, and what chance and the shared pitch leave open."""
    low, high = PUBLISHED_TRANSMISSION
    intervals = [flight.interval for flight in found.flights]
    if any(end < low or begin > high for begin, end in intervals):
        agreement = "fails in at least one flight"
    elif all(end - begin <= 2 * ROUGH * high for begin, end in intervals):
        agreement = "agrees"
    else:
        agreement = "cannot be told: bias and paddling share the mean pitch"
    return Claim(
        claim="mu, recorded flights of *D. hydei*: two turns, one nearly straight",
        published=f"{low:g} to {high:g}",
        ours=", ".join(
            f"{flight.slopes[0]:.2f} to {flight.slopes[1]:.2f} (95 % {begin:.2f} to {end:.2f})"
            for flight, (begin, end) in zip(found.flights, intervals, strict=True)
        )
        + "; the shared pitch alone makes "
        + ", ".join(f"{flight.slope_by_pitch:.2f}" for flight in found.flights),
        agreement=agreement,
        where="section 5, Fig. 6d",
        basis="real data",
    )


def graded(off: float) -> str:
    """In words: within 10 %, within 25 %, or not."""
    return "agrees" if abs(off) <= CLOSE else "roughly" if abs(off) <= ROUGH else "fails"


def within(value: float, limits: tuple[float, float]) -> str:
    """In words: inside the published range or not."""
    return "agrees" if limits[0] <= value <= limits[1] else "fails"


def claims_part(found: Findings) -> str:
    """The claims as a table."""
    head = (
        f"Pitch axis at {found.pitch_axis:g} chords. Agrees: inside the published range or within {100 * CLOSE:.0f} %; "
        f"roughly: within {100 * ROUGH:.0f} %.\n\n| claim | published | here | agreement |\n|---|---|---|---|\n"
    )
    return head + "\n".join(f"| {c.claim} | {c.published} | {c.ours} | {c.agreement} |" for c in claims(found))


def as_text(found: Findings) -> str:
    """The answer as a page of Markdown."""
    return (
        "# The hinge as a spring\n\n"
        + "\n\n".join(
            [answer(found), claims_part(found)]
            + [axis_part(found, fly) for fly in found.flies]
            + [work_part(found), variation_part(found), damping_part(found), bias_part(found), turning_part(found)]
            + ["![Work loop, passive pitch, bias and paddling](hinge_as_a_spring.svg)"]
        )
        + "\n"
    )


def axis_part(found: Findings, fly: MeasuredFly) -> str:
    """Everything over the pitch axis, one fly."""
    head = (
        f"## {fly.name}\n\n"
        "Measured motion by inverse dynamics: the damped spring closest to the torque (R^2; of a spring alone), the "
        "hinge's work on the wing. Passive motion: the spring whose pitching comes closest to the measured pitch, and "
        "what its bias does; in brackets how far kappa can go, C and eta_0 following, until the rms is 1 % larger. "
        "kappa in nN m/rad, C in pN m s/rad, angles in deg, work in nJ, beta in pN m s.\n\n"
        "| pitch axis | loop: kappa | C | eta_0 | R^2 (line) | work | passive: kappa | C | eta_0 | rms (largest) "
        "| mu (plain, mid-stroke, torque) | beta passive (pitch given) |\n"
        "|---|---|---|---|---|---|---|---|---|---|---|---|\n"
    )
    rows = [axis_row(x0, one) for x0, one in zip(PITCH_AXES, found.profiles[fly.name], strict=True)]
    mark = "\n\n(*) at the end of the range that was searched: no spring." if any("(*)" in row for row in rows) else ""
    return head + "\n".join(rows) + mark


def axis_row(x0: float, one: AtAxis) -> str:
    """A row of `axis_part`."""
    loop, spring, t = one.loop, one.fit.spring, one.transmission
    spread = "*" if one.fit.at_limit else f"{100 * one.fit.relative_spread[0]:.0f} %"
    return (
        f"| {x0:g} | {loop.stiffness / NANO:.2f} | {loop.damping * 1e12:.2f} | {loop.rest_angle / deg:.0f} "
        f"| {loop.explained:.2f} ({loop.explained_by_line:.2f}) | {loop.work / NANO:.1f} "
        f"| {spring.stiffness / NANO:.2f} ({spread}) | {spring.damping * 1e12:.2f} "
        f"| {spring.rest_angle / deg:.0f} | {one.fit.rms / deg:.1f} ({one.fit.largest / deg:.0f}) "
        f"| {t.mu:.2f} ({t.mu_plain:.2f}, {t.mu_mid_stroke:.2f}, {t.mu_torque:.2f}) "
        f"| {t.damping * 1e12:.1f} ({t.damping_at_given_pitch * 1e12:.1f}) |"
    )


def work_part(found: Findings) -> str:
    """Work per wingbeat by term."""
    head = (
        f"## Who pays for the pitching? Work on one wing's pitch in a wingbeat [nJ], axis at {found.pitch_axis:g}\n\n"
        "| fly | hinge | inertia | translational | rotational | added mass | dissipative | stroke and deviation take "
        "| largest torque [nN m] |\n|---|---|---|---|---|---|---|---|---|\n"
    )
    rows = []
    for fly in found.flies:
        torques = found.torques[fly.name]
        works = [torques.work(torques.hinge), -torques.work(torques.inertia)]
        works += [torques.work(torques.air[term]) for term in TERMS]
        cells = " | ".join(f"{work / NANO:+.1f}" for work in works)
        peak = found.at_chosen(fly).loop.peak / NANO
        rows.append(f"| {fly.name} | {cells} | {found.stroke_work[fly.name] / NANO:.0f} | {peak:.0f} |")
    return head + "\n".join(rows)


def variation_part(found: Findings) -> str:
    """One thing changed at a time."""
    head = (
        f"## What else it hangs on: {found.flies[0].name}, axis at {found.pitch_axis:g}\n\n"
        "| changed | loop: kappa | C | R^2 | work | passive: kappa | C | rms | mu |\n"
        "|---|---|---|---|---|---|---|---|---|\n"
    )
    rows = []
    for one in found.variations:
        loop, fit = one.found.loop, one.found.fit
        rows.append(
            f"| {one.name} | {loop.stiffness / NANO:.2f} | {loop.damping * 1e12:.2f} | {loop.explained:.2f} "
            f"| {loop.work / NANO:.1f} | {fit.spring.stiffness / NANO:.2f} | {fit.spring.damping * 1e12:.2f} "
            f"| {fit.rms / deg:.1f} | {one.found.transmission.mu:.2f} |"
        )
    return head + "\n".join(rows)


def bias_part(found: Findings) -> str:
    """Bias to paddling to yaw torque, simulated."""
    weight = found.flies[0].fly.morphology.weight
    head = (
        f"## Biased springs, simulated: {found.flies[0].name}, axis at {found.pitch_axis:g}\n\n"
        "Right hinge's rest angle up by the bias, left one's down. Torque > 0 turns right; body held.\n\n"
        "| bias [deg] | paddling d_alpha [deg] | yaw torque [nN m] | upward force / weight |\n|---|---|---|---|\n"
    )
    rows = [
        f"| {b.bias / deg:+.0f} | {b.d_alpha / deg:+.2f} | {b.torque[2] / NANO:+.2f} | {-b.force[2] / weight:.3f} |"
        for b in found.biased
    ]
    return head + "\n".join(rows)


def damping_part(found: Findings) -> str:
    """Why notes differ in beta of the measured hover."""
    inertia = reduced_yaw(found.flies[0].fly, found.flies[0].stroke).inertia.total
    head = (
        "## Beta of the measured hover\n\n"
        f"beta/I with I of the model, {1e13 * inertia:.2f}e-13 kg m^2 (body, wings and carried air), and with the "
        f"published {1e13 * PUBLISHED_INERTIA:g}e-13.\n\n"
        "| | beta [pN m s] | beta/I [1/s] | with the published I |\n|---|---|---|---|\n"
    )
    rows = [
        f"| {one.how} | {1e12 * one.beta:.1f} | {one.beta / inertia:.0f} | {one.beta / PUBLISHED_INERTIA:.0f} |"
        for one in found.dampings
    ]
    return head + "\n".join(rows)


def turning_part(found: Findings) -> str:
    """Recorded flights."""
    head = (
        "## Recorded flights of *D. hydei*, wingbeat by wingbeat\n\n"
        "Bias is half of right less left of <eta> + <tau>/kappa, kappa from the loop of the mean wingbeat. In brackets "
        "with the torques of other wingbeats: what the shared pitch does by itself. The interval counts chance in "
        "wingbeats and noise in either angle, not the shared pitch, nor kappa.\n\n"
        "| flight | wingbeats | spread of <eta>, <tau>/kappa [deg] | of paddling [deg] | correlation | slope, d_alpha "
        "on "
        "bias | turned over | 95 % |\n|---|---|---|---|---|---|---|---|\n"
    )
    rows = [
        f"| {f.name} | {len(f.bias)} | {f.pitch.std() / deg:.2f}, {f.strain.std() / deg:.2f} "
        f"| {f.d_alpha.std() / deg:.2f} | {f.correlation:.2f} ({f.correlation_by_pitch[0]:.2f}, 97.5 %: "
        f"{f.correlation_by_pitch[1]:.2f}) | {f.slopes[0]:.2f} ({f.slope_by_pitch:.2f}) | {f.slopes[1]:.2f} "
        f"| {f.interval[0]:.2f} to {f.interval[1]:.2f} |"
        for f in found.flights
    ]
    return head + "\n".join(rows)


def as_numbers(found: Findings) -> str:
    """The numbers as JSON, six digits."""
    rows: dict[str, Any] = {
        "claims": [asdict(claim) for claim in claims(found)],
        "pitch_axes_chords": PITCH_AXES,
        "pitch_axis_of_figures_chords": found.pitch_axis,
        "published": {"stiffness_N_m_per_rad": PUBLISHED_STIFFNESS, "mu": PUBLISHED_TRANSMISSION},
        "flies": {
            fly.name: [axis_numbers(x0, one) for x0, one in zip(PITCH_AXES, found.profiles[fly.name], strict=True)]
            for fly in found.flies
        },
        "stroke_work_J": found.stroke_work,
        "variations": {one.name: axis_numbers(found.pitch_axis, one.found) for one in found.variations},
        "biased_hover": [
            {"bias_deg": one.bias / deg, "d_alpha_deg": one.d_alpha / deg, "yaw_torque_N_m": float(one.torque[2])}
            for one in found.biased
        ],
        "flights": {
            f.name: {"wingbeats": len(f.bias), "correlation": f.correlation, "slope": f.slopes[0],
                     "slope_turned_over": f.slopes[1], "interval": f.interval, "slope_by_pitch": f.slope_by_pitch,
                     "correlation_by_pitch": f.correlation_by_pitch[0]}
            for f in found.flights
        },
        "beta_of_the_measured_hover_N_m_s": {one.how: one.beta for one in found.dampings},
    }  # fmt: skip
    short = json.loads(json.dumps(rows), parse_float=lambda text: float(f"{float(text):.6g}"))
    return json.dumps(short, indent=2) + "\n"


def axis_numbers(x0: float, one: AtAxis) -> dict[str, Any]:
    """Numbers of one fly about one axis, units in the names."""
    loop, fit, t = one.loop, one.fit, one.transmission
    return {
        "pitch_axis_chords": x0,
        "loop_stiffness_N_m_per_rad": loop.stiffness,
        "loop_damping_N_m_s": loop.damping,
        "loop_rest_angle_deg": loop.rest_angle / deg,
        "loop_r_squared": loop.explained,
        "loop_r_squared_line": loop.explained_by_line,
        "work_per_beat_J": loop.work,
        "peak_torque_N_m": loop.peak,
        "passive_stiffness_N_m_per_rad": fit.spring.stiffness,
        "passive_damping_N_m_s": fit.spring.damping,
        "passive_rest_angle_deg": fit.spring.rest_angle / deg,
        "passive_rms_deg": fit.rms / deg,
        "passive_at_limit": fit.at_limit,
        "relative_spread": fit.relative_spread,
        "settling_wingbeats": fit.passive.settling,
        "mu": t.mu,
        "mu_plain_mean": t.mu_plain,
        "mu_mid_stroke": t.mu_mid_stroke,
        "mu_torque": t.mu_torque,
        "yaw_torque_per_bias_N_m_per_rad": t.torque_per_bias,
        "gamma_N_m_per_rad": t.torque_per_paddling,
        "beta_passive_N_m_s": t.damping,
        "beta_pitch_given_N_m_s": t.damping_at_given_pitch,
    }


def main(folder: Path = FOLDER) -> Findings:
    """Find, draw and write."""
    measured(DATA, "kinematics_fourier", "muijres_mean_wingbeats", "muijres_freeflight")
    found = findings()
    text = as_text(found)
    write_files_atomically(
        folder,
        {
            "hinge_as_a_spring.md": text,
            "hinge_as_a_spring.json": as_numbers(found),
            "hinge_as_a_spring.svg": draw(found)["hinge_as_a_spring.svg"],
        },
    )
    print(text)
    return found


if __name__ == "__main__":
    main(folder_named(__file__, __doc__, FOLDER))
