"""Does a fly with beating wings recover its heading as the reduced yaw loop says?  (Figs. 7c, 7d and 8c of the review)

Run with `python analyses/recovery_at_two_levels.py [FOLDER]`; the measured hover is looked for in $FLYCONTROL_DATA,
else in ../shared/data. The note, the numbers and the figure go to reports/recovery_at_two_levels unless a folder is
given. It takes about a minute.
"""

import io
import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from _by_hand import DATA, REPORTS, folder_named, measured
from numpy.typing import NDArray

from flycontrol.flight.feedback import Sampling, YawFeedback
from flycontrol.flight.feedback_flight import ControlledFlight, controlled_flight
from flycontrol.flight.flapping_fly import FlappingFly
from flycontrol.flight.hinge_fit import HingeFit, at_pitch_axis, fitted_spring
from flycontrol.flight.hinge_motion import passive_wingbeat, sprung
from flycontrol.flight.hinge_transmission import HingeTransmission, hinge_transmission
from flycontrol.flight.multibody.freedoms import FREE, YAW_ONLY, BodyFreedoms, Hinge
from flycontrol.flight.pulses import BodyPulse
from flycontrol.flight.sensors import Haltere
from flycontrol.flight.settings import MarchSettings
from flycontrol.flight.trim import hover_trim
from flycontrol.io.morphology import read_morphology_table
from flycontrol.io.series_conventions import CONVENTIONS
from flycontrol.io.series_files import read_series_file
from flycontrol.jobs.files import write_files_atomically
from flycontrol.model.gains import ChosenGains, PulseTask, fastest_proportional, most_robust_pd
from flycontrol.model.hinge import DampedSpring, HingeStroke, SteeredSpring
from flycontrol.model.morphology import morphology_from_table
from flycontrol.model.perturbation import TorquePulse
from flycontrol.model.recovery import pulse_for_peak, pulse_response, recovery_time
from flycontrol.model.stroke_kinematics import StrokeKinematics, hover_stroke
from flycontrol.model.trajectory import FlightState, Trajectory
from flycontrol.model.yaw import PDController, YawLoop, YawPlant
from flycontrol.reduce.reduced_yaw import reduced_yaw
from flycontrol.units import deg, ms

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FloatArray = NDArray[np.float64]
FOLDER = REPORTS / "recovery_at_two_levels"
STROKE = hover_stroke()
MEASURED_FREQUENCY = 218.0  #: of the measured hover [1/s]
PITCH_AXIS = 0.05  #: at which hinge_as_a_spring finds passive pitching closest to measured pitch [chords]
PUBLISHED_INERTIA = 3.06e-13  #: about the vertical in hover, cheng2011 [kg m^2]
DELAY_BEATS = 3
BAND, PEAK, SMALL = 2 * deg, 20 * deg, 1 * deg
STRONGEST, FREE_PEAK = 40 * deg, 5 * deg
DEADLINE = 60 * ms
QUICK = MarchSettings(estimate_error=False)
PHASES = np.arange(8) / 8
PEAKS = np.array([2.2, 2.5, 3, 4, 5, 7, 10, 15, 20, 25, 30, 35, 40]) * deg

# ## The question
#
# The review explains recovery from a magnetic pulse by I psi'' = -beta psi' + N_fly + N_ext with N_fly = K_P psi + K_D
# psi', three wingbeats late. Its curves are drawn through measured yaw (Fig. 7c), paddling (7d) and recovery times
# (8c). Here two beating wings in quasi-steady air make the same recovery, all terms of the air and the wings' inertia
# included. The fly senses its heading, and 13.6 ms later its wings paddle.
#
# beta, gamma and I of the reduced loop are found apart: by turning the body, by paddling, by inverse dynamics. Nothing
# is fitted to a flight, so the difference of both levels is what averaging over the wingbeat loses.


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Level:
    """A fly whose wings obey a command, and its reduced model."""

    name: str
    fly: FlappingFly
    stroke: StrokeKinematics
    start: FlightState | None
    plant: YawPlant
    torque: float  #: per command [N m/rad]
    chosen: ChosenGains

    @property
    def beat(self) -> float:
        """A wingbeat [s]."""
        return 1 / self.stroke.frequency

    @property
    def delay(self) -> float:
        """Three wingbeats [s]."""
        return DELAY_BEATS * self.beat

    def feedback(self) -> YawFeedback:
        """Gains of the command, in radians."""
        return self.feedback_with(self.chosen.kp, self.chosen.kd)

    def feedback_with(self, kp: float, kd: float) -> YawFeedback:
        """Gains of the command from kp [1/s^2] and kd [1/s]."""
        per = self.plant.inertia / self.torque
        return YawFeedback(gains=PDController(proportional=kp * per, derivative=kd * per), delay=self.delay)

    def loop(self, late: float = 0.0) -> YawLoop:
        """The reduced loop, its delay longer by so much [s]."""
        return self.loop_of(self.chosen, late)

    def loop_of(self, gains: ChosenGains, late: float = 0.0) -> YawLoop:
        """The reduced loop with other gains."""
        inertia = self.plant.inertia
        law = PDController(proportional=gains.kp * inertia, derivative=gains.kd * inertia)
        return YawLoop(plant=self.plant, controller=law, delay=self.delay + late)


# ## Two ways to paddle
#
# The command either is the paddling angle itself, or biases the springs on which the wings pitch passively. Then a bias
# makes a torque of its own size, and the body's turning pitches the wings too: they give way, and beta is smaller. The
# spring is the one whose passive pitching comes closest to the pitch measured in hover, about an axis 0.05 chords
# behind the leading edge, and stroke and deviation are the measured ones, so that nothing is left of the built-in
# stroke where the hinge is in the loop. Paddling is flown with either stroke. Gains follow one rule for all: the
# largest modulus margin among those with which the reduced loop recovers within 60 ms from every peak up to 40 deg.


def melanogaster(frequency: float = STROKE.frequency) -> FlappingFly:
    """The published fly."""
    return FlappingFly(morphology=morphology_from_table(read_morphology_table(), "Drosophila melanogaster", frequency))


def measured_hover() -> StrokeKinematics:
    """Both wings of *D. melanogaster* in hover (Fry 2005, digitised by others)."""
    path = DATA / "kinematics_fourier" / "Drosophila_hovering_fry.json"
    return StrokeKinematics.symmetric(read_series_file(path, CONVENTIONS["hovering fruit fly"]), MEASURED_FREQUENCY)


def gains_by_rule(plant: YawPlant, beat: float) -> ChosenGains:
    """The most robust gains that meet the deadline."""
    task = PulseTask(duration=beat, peak=STRONGEST, tolerance=BAND)
    return most_robust_pd(plant.damping_rate, DELAY_BEATS * beat, task, DEADLINE)


def direct(name: str, stroke: StrokeKinematics) -> Level:
    """The command is the paddling angle."""
    fly = replace(melanogaster(stroke.frequency), body=YAW_ONLY)
    model = reduced_yaw(fly, stroke)
    return Level(
        name=name, fly=fly, stroke=stroke, start=None, plant=model.plant, torque=model.paddling,
        chosen=gains_by_rule(model.plant, 1 / stroke.frequency),
    )  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Sprung:
    """The fly on springs, and what Eq. 8 would make of it."""

    level: Level
    fit: HingeFit
    way: HingeTransmission
    gives_way: float  #: nu: paddling per yaw rate of the body, no bias [s]

    @property
    def spring(self) -> DampedSpring:
        """Kappa, C and eta_0."""
        return self.fit.spring

    @property
    def rigid(self) -> YawPlant:
        """Beta where the pitch does not give way."""
        return YawPlant(inertia=self.level.plant.inertia, damping=self.way.damping_at_given_pitch)

    @property
    def rigid_torque(self) -> float:
        """gamma mu [N m/rad]."""
        return self.way.mu * self.way.torque_per_paddling


def through_the_hinge(stroke: StrokeKinematics) -> Sprung:
    """The command biases the rest angles, right up and left down."""
    plain = at_pitch_axis(melanogaster(stroke.frequency), PITCH_AXIS)
    fit = fitted_spring(plain, stroke)
    spring = fit.spring
    joint = SteeredSpring(stiffness=spring.stiffness, damping=spring.damping)
    rests = HingeStroke(stroke=stroke.left, rest_angle=spring.rest_angle)
    way = hinge_transmission(plain, stroke, spring)
    plant = YawPlant(inertia=reduced_yaw(plain, stroke).inertia.total, damping=way.damping)
    held = sprung(plain, spring)
    level = Level(
        name="hinge bias",
        fly=replace(plain, body=YAW_ONLY, left=Hinge(pitch=joint), right=Hinge(pitch=joint)),
        stroke=replace(stroke, left=rests, right=rests),
        start=passive_wingbeat(held, stroke).start,
        plant=plant,
        torque=way.torque_per_bias,
        chosen=gains_by_rule(plant, 1 / stroke.frequency),
    )
    turning = passive_wingbeat(held, stroke, yaw_rate=1.0).trajectory
    return Sprung(level=level, fit=fit, way=way, gives_way=mean_paddling(turning))


def mean_paddling(flight: Trajectory) -> float:
    """<phi'^2 (eta_R - eta_L)> / (2 <phi'^2>) [rad]."""
    weight = flight.left.stroke_rate**2 + flight.right.stroke_rate**2
    return float(np.average(0.5 * (flight.right.pitch - flight.left.pitch), weights=weight))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Recovery:
    """A pulse at both levels."""

    time: FloatArray  #: (N,) from the pulse's onset [s]
    yaw: FloatArray  #: (N,) wing level [rad]
    reduced: FloatArray  #: (N,) reduced loop [rad]
    flight: ControlledFlight
    loop: YawLoop
    pulse: TorquePulse

    @property
    def off(self) -> FloatArray:
        """(N,) wing level less reduced loop as a share of the reduced peak."""
        return (self.yaw - self.reduced) / np.abs(self.reduced).max()

    @property
    def misfit(self) -> float:
        """The largest of it."""
        return float(np.abs(self.off).max())

    @property
    def recovery_time(self) -> float:
        """Until the wing level's yaw stays within 2 deg [s]."""
        outside = np.flatnonzero(np.abs(self.yaw) > BAND)
        if not outside.size:
            return 0.0
        k = int(outside[-1])
        before, after = abs(self.yaw[k]), abs(self.yaw[k + 1])
        return float(self.time[k] + (before - BAND) / (before - after) * (self.time[k + 1] - self.time[k]))


def recovered(  # noqa: PLR0913 (what a pulse and a loop may be)
    level: Level,
    peak: float,
    *,
    phase: float = 0.0,
    beats: float = 1.0,
    feedback: YawFeedback | None = None,
    loop: YawLoop | None = None,
    wingbeats: int = 24,
) -> Recovery:
    """Pulse of so many beats that turns the reduced loop by the peak, one wingbeat and a phase after the start."""
    loop = loop or level.loop()
    push = pulse_for_peak(loop, beats * level.beat, peak)
    onset = (1 + phase) / level.stroke.frequency
    pulse = BodyPulse(start=onset, duration=push.duration, torque_S=(0.0, 0.0, push.torque))
    flight = controlled_flight(
        level.fly, level.stroke, feedback or level.feedback(), wingbeats, start=level.start, pulses=[pulse],
        settings=QUICK,
    )  # fmt: skip
    time = flight.trajectory.time - onset
    response = pulse_response(loop.closed_loop(), push, time[-1])
    reduced = np.where(time > 0, response(np.clip(time, 0.0, None))[0], 0.0)
    return Recovery(time=time, yaw=flight.yaw, reduced=reduced, flight=flight, loop=loop, pulse=push)


# ## Where the reduced loop could fail
#
# Averaging over the wingbeat has no place for the phase at which a pulse comes; a short pulse meets wings at
# mid-stroke, where a turning body is braked hard, or at reversal, where it is not. The linear loop has no place for
# strong pulses. The loop of yaw alone has no place for roll: a torque about the stroke plane's normal rolls a body
# whose long axis slants to it. Sampling once a wingbeat, as a fly that steers once a stroke would, and halteres that
# filter are no part of Eq. 6 either; a delay that is longer by their mean lag should stand for them.


@dataclass(frozen=True, slots=True, kw_only=True)
class Row:
    """One variation."""

    name: str
    misfit: float  #: against the reduced loop as it is, share of the peak
    delayed: float | None = None  #: against the loop with the lag added to its delay


def by_duration(level: Level) -> list[Row]:
    """The worst phase for pulses of several durations."""
    return [
        Row(
            name=f"{beats:g} wingbeats",
            misfit=max(recovered(level, SMALL, phase=float(p), beats=beats).misfit for p in PHASES),
        )
        for beats in (0.1, 0.25, 0.5, 1.0, 2.0)
    ]


def by_strength(level: Level) -> list[Row]:
    """Pulses of one wingbeat, weak to strong."""
    return [
        Row(name=f"{peak / deg:g} deg", misfit=recovered(level, peak).misfit)
        for peak in (0.1 * deg, 5 * deg, 20 * deg, 40 * deg, 80 * deg)
    ]


def by_sensing(level: Level) -> list[Row]:
    """Sampled commands and filtering halteres."""
    rows = []
    for n in (4, 2, 1):
        sampling = Sampling(per_wingbeat=n)
        late = (1 + sampling.ramp) / (2 * n) * level.beat
        name = f"sampled and held, {n} a wingbeat: {late / ms:.1f} ms later"
        rows.append(_lagging(level, replace(level.feedback(), sampling=sampling), late, name))
    for tau in (0.5 * ms, 2 * ms):
        name = f"haltere as a filter of {tau / ms:g} ms"
        rows.append(_lagging(level, replace(level.feedback(), sensor=Haltere(time_constant=tau)), tau, name))
    return rows


def _lagging(level: Level, feedback: YawFeedback, late: float, name: str) -> Row:
    plain = recovered(level, SMALL, feedback=feedback)
    known = recovered(level, SMALL, feedback=feedback, loop=level.loop(late))
    return Row(name=name, misfit=plain.misfit, delayed=known.misfit)


@dataclass(frozen=True, slots=True, kw_only=True)
class FreedomRow:
    """A 5 deg pulse on a fly in trimmed hover."""

    name: str
    misfit: float  #: share of the peak in the first ten wingbeats after the pulse
    yaw_later: float  #: heading 20 wingbeats after the pulse [rad]
    roll_later: float  #: [rad]


def by_freedom() -> list[FreedomRow]:
    """Yaw alone, all but roll, all six."""
    trim = hover_trim(melanogaster(), STROKE)
    model = reduced_yaw(melanogaster(), trim.kinematics, body_pitch=trim.body_pitch)
    rows = []
    for name, body, start in (
        ("yaw alone", YAW_ONLY, None),
        ("all but roll", BodyFreedoms(roll=False), trim.start),
        ("all six", FREE, trim.start),
    ):
        level = Level(
            name=name, fly=replace(melanogaster(), body=body), stroke=trim.kinematics, start=start, plant=model.plant,
            torque=model.paddling, chosen=gains_by_rule(model.plant, 1 / trim.kinematics.frequency),
        )  # fmt: skip
        found = recovered(level, FREE_PEAK)
        early, later = found.time < 10 * level.beat, int(np.searchsorted(found.time, 20 * level.beat))
        roll = found.flight.trajectory.roll
        rows.append(
            FreedomRow(
                name=name,
                misfit=float(np.abs(found.off[early]).max()),
                yaw_later=float(found.yaw[later]),
                roll_later=float(roll[later] - roll[0]),
            )
        )
    return rows


# ## What cameras would see
#
# A camera sees paddling, not what was asked for. Where the pitch is given the joint obeys, so that paddling is the
# command by construction and says nothing new. On springs the body's turning paddles the wings too: to first order
# d_alpha = mu d_eta_0 + nu psi', nu from turning a held fly as mu is from biasing it.


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Paddled:
    """Wingbeat means of one recovery on springs."""

    seen: FloatArray  #: (K,) d_alpha of the wings [rad]
    asked: FloatArray  #: (K,) mu d_eta_0 of the reduced loop [rad]
    turned: FloatArray  #: (K,) nu psi' of the reduced loop [rad]

    @property
    def off(self) -> float:
        """Largest of seen less asked, share of the largest asked."""
        return float(np.abs(self.seen - self.asked).max() / np.abs(self.asked).max())

    @property
    def off_with_turning(self) -> float:
        """The same, nu psi' added to what was asked for."""
        return float(np.abs(self.seen - self.asked - self.turned).max() / np.abs(self.asked).max())


def paddled(hinge: Sprung, one: Recovery) -> Paddled:
    """Wings beside what Eq. 8 and nu make of the reduced loop."""
    _, rate, torque = reduced_response(one)
    return Paddled(
        seen=one.flight.d_alpha,
        asked=wingbeat_means(one, hinge.way.mu * torque / hinge.level.torque),
        turned=wingbeat_means(one, hinge.gives_way * rate),
    )


def reduced_response(one: Recovery) -> FloatArray:
    """(3, N) yaw [rad], yaw rate [rad/s] and N_fly [N m] of the reduced loop."""
    response = pulse_response(one.loop.closed_loop(), one.pulse, one.time[-1])
    return np.where(one.time > 0, response(np.clip(one.time, 0.0, None)), 0.0)


def wingbeat_means(one: Recovery, values: FloatArray) -> FloatArray:
    """(K,) of values at the flight's instants."""
    n = one.flight.trajectory.samples_per_wingbeat
    return one.flight.averaged(values)[n // 2 :: n][: len(one.flight.d_alpha)]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Findings:
    """All that the note says."""

    paddling: Level  #: built-in stroke
    paddling_hover: Level  #: measured stroke
    hinge: Sprung
    nominal: dict[str, Recovery]  #: 20 deg
    phases: dict[str, list[Recovery]]  #: 1 deg, every phase
    rigid: Recovery  #: through the hinge, against the loop of Eq. 8
    seen: Paddled
    times: dict[str, FloatArray]  #: recovery times over PEAKS, wing level [s]
    reduced_times: dict[str, FloatArray]  #: the same, reduced loop [s]
    spread: dict[str, float]  #: of wing-level recovery times from 20 deg over the pulse's phase [s]
    proportional: dict[str, Recovery]  #: P alone, 20 deg
    durations: dict[str, list[Row]]
    strengths: list[Row]
    sensing: list[Row]
    freedoms: list[FreedomRow]

    @property
    def levels(self) -> tuple[Level, ...]:
        """All that were flown on a tether."""
        return self.paddling, self.paddling_hover, self.hinge.level

    def worst(self, level: Level) -> float:
        """Largest misfit over the pulse's phase."""
        return max(one.misfit for one in self.phases[level.name])

    def time_from(self, level: Level, peak: float) -> float:
        """Recovery time of the wings from one of PEAKS [deg], in s."""
        return float(self.times[level.name][np.argmin(np.abs(PEAKS - peak * deg))])


def findings() -> Findings:
    """Fly and compare."""
    paddling, hover = direct("paddling", STROKE), measured_hover()
    hover_paddling, hinge = direct("paddling, measured hover", hover), through_the_hinge(hover)
    levels = (paddling, hover_paddling, hinge.level)
    nominal = {level.name: recovered(level, PEAK) for level in levels}
    return Findings(
        paddling=paddling,
        paddling_hover=hover_paddling,
        hinge=hinge,
        nominal=nominal,
        phases={level.name: [recovered(level, SMALL, phase=float(p)) for p in PHASES] for level in levels},
        rigid=_against_rigid(hinge),
        seen=paddled(hinge, nominal[hinge.level.name]),
        times={level.name: _times(level) for level in levels},
        reduced_times={level.name: _reduced_times(level) for level in levels},
        spread={level.name: _spread(level) for level in levels},
        proportional={level.name: _proportional(level) for level in levels},
        durations={level.name: by_duration(level) for level in levels},
        strengths=by_strength(paddling),
        sensing=by_sensing(paddling),
        freedoms=by_freedom(),
    )


def _times(level: Level) -> FloatArray:
    return np.array([recovered(level, float(peak)).recovery_time for peak in PEAKS])


def _spread(level: Level) -> float:
    return float(np.ptp([recovered(level, PEAK, phase=float(p)).recovery_time for p in PHASES]))


def _reduced_times(level: Level) -> FloatArray:
    loop = level.loop()
    return np.array([recovery_time(loop, pulse_for_peak(loop, level.beat, float(peak)), BAND) for peak in PEAKS])


def _proportional(level: Level) -> Recovery:
    task = PulseTask(duration=level.beat, peak=PEAK, tolerance=BAND)
    chosen = fastest_proportional(level.plant.damping_rate, level.delay, task)
    feedback, loop = level.feedback_with(chosen.kp, 0.0), level.loop_of(chosen)
    return recovered(level, PEAK, feedback=feedback, loop=loop, wingbeats=40)


def _against_rigid(hinge: Sprung) -> Recovery:
    """The same command gains, turned into torque by gamma mu, on the plant whose wings do not give way."""
    gains = hinge.level.feedback().gains
    law = PDController(
        proportional=gains.proportional * hinge.rigid_torque, derivative=gains.derivative * hinge.rigid_torque
    )
    return recovered(hinge.level, SMALL, loop=YawLoop(plant=hinge.rigid, controller=law, delay=hinge.level.delay))


# ## The figure


def draw(found: Findings) -> str:
    """Yaw and paddling after 20 deg, recovery time over strength, and what is left at every phase."""
    from flycontrol.report.style import in_house_style, new_figure

    with in_house_style():
        figure: Figure = new_figure(5.8)
        axes = figure.subplots(2, 2)
        _draw_yaw(axes[0, 0], found)
        _draw_paddling(axes[1, 0], found)
        _draw_times(axes[0, 1], found)
        _draw_off(axes[1, 1], found)
        buffer = io.StringIO()
        figure.savefig(buffer, format="svg", metadata={"Date": None, "Creator": None})
    return buffer.getvalue()


WINGS = {"paddling": ("#9cc9e3", 4.2), "hinge bias": ("#e08a00", 2.6)}  #: colour and width [pt]
REDUCED = {"paddling": ("#0b3954", (0, (4.5, 2))), "hinge bias": ("#1a1a1a", (0, (1, 1.4)))}
NAMED = {"paddling": "paddling", "hinge bias": "on springs"}
MARKERS = {"paddling": "o", "hinge bias": "s"}


def _draw_yaw(ax: "Axes", found: Findings) -> None:
    from flycontrol.report.style import BAND as SHADE
    from flycontrol.report.style import PULSE

    ax.axhspan(-2, 2, color=SHADE)
    ax.axvspan(0, found.paddling.beat / ms, color=PULSE)
    for name, (colour, width) in WINGS.items():
        one, (dark, dash) = found.nominal[name], REDUCED[name]
        ax.plot(one.time / ms, one.yaw / deg, color=colour, linewidth=width, label=f"wings, {NAMED[name]}")
        ax.plot(
            one.time / ms, one.reduced / deg, color=dark, linewidth=1.2, linestyle=dash,
            label=f"reduced, {NAMED[name]}",
        )  # fmt: skip
    ax.set(title="a  Yaw after a pulse (Fig. 7c)", xlabel="time from onset [ms]", ylabel="yaw [deg]", xlim=(-5, 95))
    ax.legend(loc="upper right", handlelength=2.6)


def _draw_paddling(ax: "Axes", found: Findings) -> None:
    from flycontrol.report.style import PULSE

    one, seen = found.nominal["hinge bias"], found.seen
    middle = (one.time[0] + (np.arange(len(seen.seen)) + 0.5) * found.hinge.level.beat) / ms
    ax.axvspan(0, found.hinge.level.beat / ms, color=PULSE)
    ax.plot(middle, 2 * seen.seen / deg, "s", color=WINGS["hinge bias"][0], markersize=5, label="wings, on springs")
    ax.plot(middle, 2 * seen.asked / deg, color="#1a1a1a", linewidth=1.2, linestyle=(0, (1, 1.4)), label="2 μ dη₀")
    ax.plot(
        middle, 2 * (seen.asked + seen.turned) / deg, color="#c8323c", linewidth=1.3, linestyle=(0, (4.5, 2)),
        label="2 (μ dη₀ + ν ψ′)",
    )  # fmt: skip
    ax.set(
        title=f"c  Paddling (Fig. 7d), on springs, {PEAK / deg:g}° pulse", xlabel="time from onset [ms]",
        ylabel="right − left attack angle [deg]", xlim=(-5, 95),
    )  # fmt: skip
    ax.legend(loc="lower right", handlelength=2.6)


def _draw_times(ax: "Axes", found: Findings) -> None:
    for level in (found.paddling, found.hinge.level):
        (dark, dash), loop = REDUCED[level.name], level.loop()
        fine = np.linspace(2.02, 40, 160) * deg
        unit = pulse_for_peak(loop, level.beat, 1.0)
        times = [recovery_time(loop, unit.times(float(peak)), BAND) for peak in fine]
        ax.plot(fine / deg, np.array(times) / ms, color=dark, linewidth=1.2, linestyle=dash)
        ax.plot(
            PEAKS / deg, found.times[level.name] / ms, MARKERS[level.name], color=WINGS[level.name][0],
            markeredgecolor=dark, markersize=5, label=f"wings, {NAMED[level.name]}",
        )  # fmt: skip
    ax.axhline(DEADLINE / ms, color="#7d7d7d", linewidth=0.8)
    ax.annotate("60 ms", (1, DEADLINE / ms), (0, 2), textcoords="offset points", fontsize=7.5)
    ax.set(
        title="b  Recovery time (Fig. 8c); lines: reduced", xlabel="peak of the reduced loop [deg]",
        ylabel="until within 2° [ms]", ylim=(0, 88), xlim=(0, 42),
    )  # fmt: skip
    ax.legend(loc="lower right")


def _draw_off(ax: "Axes", found: Findings) -> None:
    for name, (colour, _) in WINGS.items():
        for k, one in enumerate(found.phases[name]):
            label = f"{NAMED[name]}, 8 phases" if k == 0 else None
            shade, dash = ("#0b3954", "-") if name == "paddling" else (colour, REDUCED[name][1])
            ax.plot(one.time / ms, 100 * one.off, color=shade, linewidth=0.9, linestyle=dash, label=label)
    ax.axhspan(-1, 1, color="#e6edf1", zorder=0)
    ax.set(
        title="d  Wings less reduced loop", xlabel="time from onset [ms]", ylabel="share of the peak [%]",
        xlim=(-5, 95), ylim=(-1.6, 2.4),
    )  # fmt: skip
    ax.legend(loc="upper right")


# ## The answer
#
# It opens the note, in the words of `answer`; what its numbers are comes from `findings`.


def answer(found: Findings) -> str:
    """What was asked, in a paragraph, and what to beware of."""
    way, hinge, free = found.hinge.way, found.hinge, found.freedoms[-1]
    return (
        "On a magnetic tether, yes. After a pulse of one wingbeat, at any phase, wings that paddle on command stay "
        f"within {_worst(found, found.paddling)} of the reduced loop's peak with the built-in stroke and within "
        f"{_worst(found, found.paddling_hover)} with the measured hover; wings that hang on springs within "
        f"{_worst(found, found.hinge.level)}, if the reduced loop has the damping and the torque per bias that such "
        "wings leave. With the damping of wings whose pitch is given and the torque gamma mu of Eq. 8 it is "
        f"{100 * found.rigid.misfit:.0f} % off: a turning body pitches wings on springs, so that beta falls from "
        f"{1e12 * way.damping_at_given_pitch:.1f} to {1e12 * way.damping:.1f} pN m s, and the paddling that a camera "
        "sees is mu d_eta_0 + nu psi', not mu d_eta_0. Slow sampling and filtering act as delays of their mean lag. "
        "The reduced loop has no place for pulses much shorter than a wingbeat, and none for roll: a free fly that "
        f"controls yaw alone has rolled by {abs(free.roll_later) / deg:.0f} deg 20 wingbeats after a pulse of 5 deg "
        "and does not come back to its heading.\n\n"
        "Beware: all is simulated; no recording of a perturbed fly is at hand, so nothing here tests Fig. 7 or 8c "
        "against flies. Gains (certainty C) are those that recover within 60 ms in the reduced loop, so that 60 ms are "
        "no finding. beta, gamma, mu and I are extracted apart, by turning, paddling, biasing and inverse dynamics; "
        f"nothing is fitted to a flight. The spring (kappa {1e9 * hinge.spring.stiffness:.2f} nN m/rad, C "
        f"{1e12 * hinge.spring.damping:.2f} pN m s/rad) is the one whose passive pitching comes closest to the "
        f"measured hover, which it misses by {hinge.fit.rms / deg:.1f} deg rms, about an axis that nobody has "
        "measured: [the hinge as a spring](../hinge_as_a_spring/hinge_as_a_spring.md). Made by "
        "[analyses/recovery_at_two_levels.py](../../analyses/recovery_at_two_levels.py)."
    )


def _worst(found: Findings, level: Level) -> str:
    return f"{100 * found.worst(level):.2f} %"


@dataclass(frozen=True, slots=True, kw_only=True)
class Claim:
    """A line of the table at the top of the note."""

    claim: str
    published: str
    ours: str
    agreement: str
    where: str
    basis: str = "simulated"


CLOSE, NEAR = 0.01, 0.10  #: misfits that agree and that agree roughly, shares of the peak
LATE = 0.25  #: recoveries that are later than claimed by less than this agree roughly


def graded(misfit: float) -> str:
    """In words."""
    return "agrees" if misfit < CLOSE else "roughly" if misfit < NEAR else "fails"


def claims(found: Findings) -> list[Claim]:
    """What the review says or the reduced loop needs, what comes out, and whether they agree."""
    return [*loop_claims(found), *recovery_claims(found), *paddling_claims(found), _heading_claim(found)]


def loop_claims(found: Findings) -> list[Claim]:
    """The reduced loop beside the wings."""
    short = found.durations[found.paddling.name][:3]
    hinge, way = found.hinge, found.hinge.way
    return [
        *(
            Claim(
                claim=f"the delayed yaw loop follows wings that paddle on command: pulses of one wingbeat, {stroke}",
                published="Eq. 7",
                ours=f"{_worst(found, level)} of the peak apart at the worst of 8 phases of the pulse",
                agreement=graded(found.worst(level)),
                where="section 7, Eq. 7",
            )
            for stroke, level in (("built-in stroke", found.paddling), ("measured hover", found.paddling_hover))
        ),
        Claim(
            claim="the delayed yaw loop follows wings that paddle on command: pulses shorter than a wingbeat",
            published="Eq. 7",
            ours=", ".join(f"{100 * row.misfit:.1f}" for row in short) + " % of the peak apart for pulses of "
            + ", ".join(row.name.split()[0] for row in short) + " wingbeats, built-in stroke",
            agreement=graded(max(row.misfit for row in short)),
            where="section 7, Eq. 7",
        ),
        Claim(
            claim="the loop with torque gamma mu d_eta_0 and beta of wings whose pitch is given follows wings on "
            "springs",
            published="Eq. 8",
            ours=f"{100 * found.rigid.misfit:.0f} % of the peak apart: wings on springs give way, beta/I is "
            f"{hinge.level.plant.damping_rate:.0f} and not {hinge.rigid.damping_rate:.0f} 1/s, the torque per bias "
            f"{1e9 * way.torque_per_bias:.1f} and not {1e9 * hinge.rigid_torque:.1f} nN m/rad",
            agreement=graded(found.rigid.misfit),
            where="section 7, Eq. 8",
        ),
        Claim(
            claim="a delayed yaw loop with beta and torque per bias of wings that give way follows wings on springs",
            published="not claimed",
            ours=f"{_worst(found, hinge.level)} of the peak apart at the worst of 8 phases of the pulse",
            agreement="shown here" if found.worst(hinge.level) < NEAR else "fails",
            where="section 7",
        ),
    ]  # fmt: skip


def recovery_claims(found: Findings) -> list[Claim]:
    """How fast it is over."""
    return [
        *(
            claim
            for how, level in _ways(found)
            for claim in (_deadline_claim(found, how, level), _plateau_claim(found, how, level))
        ),
        Claim(
            claim="P control alone is too slow",
            published="over 60 ms",
            ours=", ".join(
                f"{found.proportional[level.name].recovery_time / ms:.0f} ms ({how}, beta/I "
                f"{level.plant.damping_rate:.0f} 1/s)"
                for how, level in _ways(found)
            )
            + " from 20 deg with the fastest gain",
            agreement="agrees"
            if all(found.proportional[level.name].recovery_time > DEADLINE for _, level in _ways(found))
            else "fails",
            where="section 6, Fig. 7c",
        ),
    ]


def _ways(found: Findings) -> tuple[tuple[str, Level], ...]:
    return ("paddling on command", found.paddling), ("wings on springs", found.hinge.level)


def _deadline_claim(found: Findings, how: str, level: Level) -> Claim:
    twenty, forty = (found.time_from(level, peak) for peak in (20, 40))
    limit, times = min(DEADLINE, 15 * level.beat), found.times[level.name]
    missed, late = PEAKS[times >= limit] / deg, times.max() / limit - 1
    held = "agrees" if not len(missed) else "roughly" if late < LATE else "fails"
    if len(missed):
        held += f": from {missed[0]:g} deg on too late by up to {100 * late:.0f} %"
    return Claim(
        claim=f"recovery takes under 60 ms and 15 wingbeats: {how}",
        published="under 60 ms",
        ours=f"{twenty / ms:.1f} ms ({twenty / level.beat:.1f} wingbeats) from 20 deg, {forty / ms:.1f} ms "
        f"({forty / level.beat:.1f}) from 40 deg",
        agreement=held + ", with gains chosen for it in the reduced loop",
        where="section 6, Fig. 7c",
    )  # fmt: skip


def _plateau_claim(found: Findings, how: str, level: Level) -> Claim:
    wing, reduced = found.times[level.name], found.reduced_times[level.name]
    shown = (2.2, 5, 20, 40)
    at = [found.time_from(level, peak) for peak in shown]
    apart = np.abs(wing - reduced)
    steep, flat = (at[1] - at[0]) / (shown[1] - shown[0]), (at[3] - at[2]) / (shown[3] - shown[2])
    jump = f"fails: from {PEAKS[np.argmax(apart)] / deg:g} deg the return swings out of the band once more"
    return Claim(
        claim=f"recovery time rises sharply with the pulse, then plateaus: {how}",
        published="a sharp rise, then a plateau",
        ours=", ".join(f"{time / ms:.0f}" for time in at)
        + " ms from " + ", ".join(f"{peak:g}" for peak in shown) + " deg; the reduced loop takes "
        f"{reduced[-1] / ms:.0f} ms from 40 deg and is at most {apart[:-1].max() / ms:.1f} ms off below",
        agreement="agrees" if steep > 5 * flat else jump,
        where="section 6, Fig. 8c",
    )  # fmt: skip


def paddling_claims(found: Findings) -> list[Claim]:
    """What cameras would see."""
    return [
        Claim(
            claim="N_fly of Eq. 6 agrees with the measured paddling",
            published="strong agreement",
            ours="no recording of a perturbed fly's wings is at hand; simulated wings that obey the command agree by "
            "construction",
            agreement="cannot be told",
            where="section 6, Fig. 7d",
        ),
        Claim(
            claim="the paddling angle that is seen is the one that was asked for, d_alpha = mu d_eta_0, while the body "
            "turns",
            published="Eq. 8",
            ours=f"{100 * found.seen.off:.0f} % of the largest apart: wings on springs give way to the turn; "
            f"{100 * found.seen.off_with_turning:.0f} % with nu psi' added",
            agreement=graded(found.seen.off),
            where="section 7, Eq. 8",
        ),
    ]


def _heading_claim(found: Findings) -> Claim:
    free = found.freedoms[-1]
    return Claim(
        claim="yaw control suffices to keep a heading",
        published="implied by section 6",
        ours=f"in free flight heading is {free.yaw_later / deg:.1f} deg and roll {free.roll_later / deg:.0f} deg off "
        "20 wingbeats after a 5 deg pulse: roll is unstable and turns with yaw",
        agreement="agrees" if abs(free.yaw_later) < 0.1 * FREE_PEAK else "fails",
        where="section 6",
    )


def as_text(found: Findings) -> str:
    """The answer as a page of Markdown."""
    parts = [
        "# Recovery at two levels",
        answer(found),
        f"Misfits agree below {100 * CLOSE:.0f} % of the peak, roughly below {100 * NEAR:.0f} %; recoveries that are "
        f"late agree roughly if by less than {100 * LATE:.0f} %.\n\n"
        "| claim | published | here | agreement |\n|---|---|---|---|\n"
        + "\n".join(f"| {c.claim} | {c.published} | {c.ours} | {c.agreement} |" for c in claims(found)),
        _levels_part(found),
        _spring_part(found),
        "## What the reduced loop has no place for\n\nLargest difference of the two levels, share of the peak; "
        "command = paddling, built-in stroke, yaw alone, 1 deg unless said.\n\n" + _rows_part(found),
        _freedom_part(found),
        "![Yaw, recovery time, paddling on springs, and what is left](recovery_at_two_levels.svg)",
    ]
    return "\n\n".join(parts) + "\n"


def _levels_part(found: Findings) -> str:
    head = (
        "## The loops\n\nI about the stroke plane's normal, wings and carried air in it; gains by rule (certainty C): "
        "the largest modulus margin among those that recover within 60 ms from every peak up to 40 deg.\n\n"
        "| command | beta/I [1/s] | torque per command [nN m/rad] | K_P/I [1/s^2] | K_D/I [1/s] | modulus margin "
        "| recovery from 20 deg, reduced and wings (spread over the phase) [ms] | worst phase [% of the peak] |\n"
        "|---|---|---|---|---|---|---|---|\n"
    )
    rows = []
    at = int(np.argmin(np.abs(PEAKS - PEAK)))
    for level in found.levels:
        c = level.chosen
        rows.append(
            f"| {level.name} | {level.plant.damping_rate:.0f} | {level.torque * 1e9:.1f} | {c.kp:.0f} | {c.kd:.1f} "
            f"| {c.modulus_margin:.2f} | {found.reduced_times[level.name][at] / ms:.1f} and "
            f"{found.times[level.name][at] / ms:.1f} ({found.spread[level.name] / ms:.1f}) "
            f"| {100 * found.worst(level):.2f} |"
        )
    return head + "\n".join(rows)


def _spring_part(found: Findings) -> str:
    hinge, way, spring = found.hinge, found.hinge.way, found.hinge.spring
    inertia = hinge.level.plant.inertia
    return (
        "## The springs\n\n"
        f"Pitch axis at {PITCH_AXIS:g} chords: kappa {1e9 * spring.stiffness:.2f} nN m/rad, C "
        f"{1e12 * spring.damping:.2f} pN m s/rad, eta_0 {spring.rest_angle / deg:.0f} deg, found from the measured "
        f"hover alone. mu = {way.mu:.2f} (d_alpha weighted by phi'^2), {way.mu_torque:.2f} in yaw torque: the torque "
        f"of a bias is {1e9 * way.torque_per_bias:.1f} nN m/rad, gamma mu {1e9 * hinge.rigid_torque:.1f}. beta is "
        f"{1e12 * way.damping:.1f} pN m s on the springs and {1e12 * way.damping_at_given_pitch:.1f} if the wings kept "
        f"the pitch that they have in hover; beta/I {hinge.level.plant.damping_rate:.0f} and "
        f"{hinge.rigid.damping_rate:.0f} 1/s with I = {1e13 * inertia:.2f}e-13 kg m^2, body, wings and carried air "
        f"(with the published {1e13 * PUBLISHED_INERTIA:g}e-13 the first is {way.damping / PUBLISHED_INERTIA:.0f}). nu "
        f"= {hinge.gives_way / ms:.2f} ms: a body that turns at 1000 deg/s paddles its wings by "
        f"{1000 * hinge.gives_way:.2f} deg with the turn."
    )


def _rows_part(found: Findings) -> str:
    def table(title: str, rows: Sequence[Row]) -> str:
        lines = [f"| {row.name} | {100 * row.misfit:.2f} |{_percent(row.delayed)}" for row in rows]
        lagging = rows[0].delayed is not None
        head = f"| {title} | reduced loop [%] |" + " its delay longer by the lag [%] |" * lagging
        return "\n".join([head, "|---|---|" + "---|" * lagging, *lines])

    return "\n\n".join([
        _durations_part(found),
        table("strength", found.strengths),
        table("sensing and steering", found.sensing),
    ])  # fmt: skip


def _durations_part(found: Findings) -> str:
    names = [level.name for level in found.levels]
    head = "| duration of the pulse, worst of 8 phases | " + " | ".join(f"{name} [%]" for name in names) + " |\n"
    rows = [
        f"| {rows[0].name} | " + " | ".join(f"{100 * row.misfit:.2f}" for row in rows) + " |"
        for rows in zip(*(found.durations[name] for name in names), strict=True)
    ]
    return head + "|---" * (1 + len(names)) + "|\n" + "\n".join(rows)


def _percent(share: float | None) -> str:
    return "" if share is None else f" {100 * share:.2f} |"


def _freedom_part(found: Findings) -> str:
    rows = [
        f"| {row.name} | {100 * row.misfit:.1f} | {_signed(row.yaw_later)} | {_signed(row.roll_later)} |"
        for row in found.freedoms
    ]
    return (
        "## A body with more freedoms\n\nTrimmed hover, 5 deg pulse about the stroke plane's normal, yaw control "
        "alone.\n\n| free | ten wingbeats: difference [% of the peak] | yaw 20 wingbeats later [deg] | roll [deg] |\n"
        "|---|---|---|---|\n" + "\n".join(rows)
    )


def _signed(angle: float) -> str:
    return f"{round(angle / deg, 1) + 0.0:+.1f}"  # no -0.0


def as_numbers(found: Findings) -> str:
    """The numbers as JSON, six digits."""
    rows = {
        "claims": [asdict(claim) for claim in claims(found)],
        "levels": {
            level.name: {
                "damping_rate_per_s": level.plant.damping_rate,
                "inertia_kg_m2": level.plant.inertia,
                "torque_per_command_N_m_per_rad": level.torque,
                "kp_per_s2": level.chosen.kp,
                "kd_per_s": level.chosen.kd,
                "misfit_by_phase": [one.misfit for one in found.phases[level.name]],
                "peaks_deg": (PEAKS / deg).tolist(),
                "recovery_s": found.times[level.name].tolist(),
                "recovery_reduced_s": found.reduced_times[level.name].tolist(),
            }
            for level in found.levels
        },
        "rigid_wings": {"misfit": found.rigid.misfit, "damping_rate_per_s": found.hinge.rigid.damping_rate},
        "spring": {
            "pitch_axis_chords": PITCH_AXIS,
            "stiffness_N_m_per_rad": found.hinge.spring.stiffness,
            "damping_N_m_s": found.hinge.spring.damping,
            "rest_angle_deg": found.hinge.spring.rest_angle / deg,
            "mu": found.hinge.way.mu,
            "mu_torque": found.hinge.way.mu_torque,
            "beta_passive_N_m_s": found.hinge.way.damping,
            "beta_pitch_given_N_m_s": found.hinge.way.damping_at_given_pitch,
            "paddling_per_yaw_rate_s": found.hinge.gives_way,
        },
        "paddling_seen_less_asked": found.seen.off,
        "paddling_seen_less_asked_and_turned": found.seen.off_with_turning,
        "proportional_recovery_s": {name: one.recovery_time for name, one in found.proportional.items()},
        "durations": {name: [asdict(row) for row in rows] for name, rows in found.durations.items()},
        "strengths": [asdict(row) for row in found.strengths],
        "sensing": [asdict(row) for row in found.sensing],
        "freedoms": [asdict(row) for row in found.freedoms],
    }
    short = json.loads(json.dumps(rows), parse_float=lambda text: float(f"{float(text):.6g}"))
    return json.dumps(short, indent=2) + "\n"


def main(folder: Path = FOLDER) -> Findings:
    """Find, draw and write."""
    measured(DATA, "kinematics_fourier")
    found = findings()
    text = as_text(found)
    write_files_atomically(
        folder,
        {
            "recovery_at_two_levels.md": text,
            "recovery_at_two_levels.json": as_numbers(found),
            "recovery_at_two_levels.svg": draw(found),
        },
    )
    print(text)
    return found


if __name__ == "__main__":
    main(folder_named(__file__, __doc__, FOLDER))
