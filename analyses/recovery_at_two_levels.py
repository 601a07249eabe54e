"""Does a fly with beating wings recover its heading as the reduced yaw loop says?  (Figs. 7c, 7d and 8c of the review)

Run with `python analyses/recovery_at_two_levels.py [FOLDER]`; the note, the numbers and the figure go to
reports/recovery_at_two_levels unless a folder is given. It takes about a minute.
"""

import io
import json
import sys
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from flycontrol.flight.feedback import Sampling, YawFeedback
from flycontrol.flight.feedback_flight import ControlledFlight, controlled_flight
from flycontrol.flight.flapping_fly import FlappingFly
from flycontrol.flight.hinge_fit import at_pitch_axis, fitted_spring
from flycontrol.flight.hinge_motion import passive_wingbeat, sprung
from flycontrol.flight.hinge_transmission import hinge_transmission
from flycontrol.flight.multibody.freedoms import FREE, YAW_ONLY, BodyFreedoms, Hinge
from flycontrol.flight.pulses import BodyPulse
from flycontrol.flight.sensors import Haltere
from flycontrol.flight.settings import MarchSettings
from flycontrol.flight.trim import hover_trim
from flycontrol.io.morphology import read_morphology_table
from flycontrol.jobs.files import write_files_atomically
from flycontrol.model.gains import ChosenGains, PulseTask, fastest_proportional, most_robust_pd
from flycontrol.model.hinge import HingeStroke, SteeredSpring
from flycontrol.model.morphology import morphology_from_table
from flycontrol.model.perturbation import TorquePulse
from flycontrol.model.recovery import pulse_for_peak, pulse_response, recovery_time
from flycontrol.model.stroke_kinematics import StrokeKinematics, hover_stroke
from flycontrol.model.trajectory import FlightState
from flycontrol.model.yaw import PDController, YawLoop, YawPlant
from flycontrol.reduce.reduced_yaw import reduced_yaw
from flycontrol.units import deg, ms

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FloatArray = NDArray[np.float64]
FOLDER = Path(__file__).resolve().parents[1] / "reports" / "recovery_at_two_levels"
STROKE = hover_stroke()
FREQUENCY = STROKE.frequency
BEAT = 1 / FREQUENCY
DELAY = 3 * BEAT
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

    def feedback(self) -> YawFeedback:
        """Gains of the command, in radians."""
        return self.feedback_with(self.chosen.kp, self.chosen.kd)

    def feedback_with(self, kp: float, kd: float) -> YawFeedback:
        """Gains of the command from kp [1/s^2] and kd [1/s]."""
        per = self.plant.inertia / self.torque
        return YawFeedback(gains=PDController(proportional=kp * per, derivative=kd * per), delay=DELAY)

    def loop(self, delay: float = DELAY) -> YawLoop:
        """The reduced loop."""
        return self.loop_of(self.chosen, delay)

    def loop_of(self, gains: ChosenGains, delay: float = DELAY) -> YawLoop:
        """The reduced loop with other gains."""
        inertia = self.plant.inertia
        law = PDController(proportional=gains.kp * inertia, derivative=gains.kd * inertia)
        return YawLoop(plant=self.plant, controller=law, delay=delay)


# ## Two ways to paddle
#
# The command either is the paddling angle itself, or biases the springs on which the wings pitch passively. Then a bias
# makes a torque of its own size, and the body's turning pitches the wings too: they give way, and beta is smaller. The
# spring is the one whose passive pitching comes closest to the stroke's, about an axis 0.05 chords behind the leading
# edge. Gains follow one rule for both: the largest modulus margin among those that recover within 60 ms from every peak
# up to 40 deg.


def melanogaster() -> FlappingFly:
    """The published fly."""
    return FlappingFly(morphology=morphology_from_table(read_morphology_table(), "Drosophila melanogaster", FREQUENCY))


def gains_by_rule(plant: YawPlant) -> ChosenGains:
    """The most robust gains that meet the deadline."""
    task = PulseTask(duration=BEAT, peak=STRONGEST, tolerance=BAND)
    return most_robust_pd(plant.damping_rate, DELAY, task, DEADLINE)


def direct() -> Level:
    """The command is the paddling angle."""
    fly = replace(melanogaster(), body=YAW_ONLY)
    model = reduced_yaw(fly, STROKE)
    return Level(
        name="paddling", fly=fly, stroke=STROKE, start=None, plant=model.plant, torque=model.paddling,
        chosen=gains_by_rule(model.plant),
    )  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Sprung:
    """The fly on springs, with the reduced model of rigidly pitching wings beside its own."""

    level: Level
    rigid: YawPlant  #: beta where the pitch is given
    rigid_torque: float  #: gamma mu [N m/rad]
    mu: float


def through_the_hinge() -> Sprung:
    """The command biases the rest angles, right up and left down."""
    plain = at_pitch_axis(melanogaster(), 0.05)
    spring = fitted_spring(plain, STROKE).spring
    joint = SteeredSpring(stiffness=spring.stiffness, damping=spring.damping)
    rests = HingeStroke(stroke=STROKE.left, rest_angle=spring.rest_angle)
    given, way = reduced_yaw(plain, STROKE), hinge_transmission(plain, STROKE, spring)
    plant = YawPlant(inertia=given.inertia.total, damping=way.damping)
    level = Level(
        name="hinge bias",
        fly=replace(plain, body=YAW_ONLY, left=Hinge(pitch=joint), right=Hinge(pitch=joint)),
        stroke=replace(STROKE, left=rests, right=rests),
        start=passive_wingbeat(sprung(plain, spring), STROKE).start,
        plant=plant,
        torque=way.torque_per_bias,
        chosen=gains_by_rule(plant),
    )
    return Sprung(level=level, rigid=given.plant, rigid_torque=way.mu * given.paddling, mu=way.mu)


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
    push = pulse_for_peak(loop, beats * BEAT, peak)
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
        late = (1 + sampling.ramp) / (2 * n * FREQUENCY)
        name = f"sampled and held, {n} a wingbeat: {late / ms:.1f} ms later"
        rows.append(_lagging(level, replace(level.feedback(), sampling=sampling), late, name))
    for tau in (0.5 * ms, 2 * ms):
        name = f"haltere as a filter of {tau / ms:g} ms"
        rows.append(_lagging(level, replace(level.feedback(), sensor=Haltere(time_constant=tau)), tau, name))
    return rows


def _lagging(level: Level, feedback: YawFeedback, late: float, name: str) -> Row:
    plain = recovered(level, SMALL, feedback=feedback)
    known = recovered(level, SMALL, feedback=feedback, loop=level.loop(DELAY + late))
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
            torque=model.paddling, chosen=gains_by_rule(model.plant),
        )  # fmt: skip
        found = recovered(level, FREE_PEAK)
        early, later = found.time < 10 * BEAT, int(np.searchsorted(found.time, 20 * BEAT))
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


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Findings:
    """All that the note says."""

    paddling: Level
    hinge: Sprung
    nominal: dict[str, Recovery]  #: 20 deg, by way of paddling
    phases: dict[str, list[Recovery]]  #: 1 deg, every phase
    rigid: Recovery  #: through the hinge, against the loop of given pitch
    times: dict[str, FloatArray]  #: recovery times over PEAKS, wing level [s]
    reduced_times: dict[str, FloatArray]  #: the same, reduced loop [s]
    spread: dict[str, float]  #: of wing-level recovery times from 20 deg over the pulse's phase [s]
    proportional: Recovery  #: P alone, 20 deg
    durations: list[Row]
    strengths: list[Row]
    sensing: list[Row]
    freedoms: list[FreedomRow]

    @property
    def levels(self) -> tuple[Level, Level]:
        """Both ways to paddle."""
        return self.paddling, self.hinge.level

    def worst(self, name: str) -> float:
        """Largest misfit over the pulse's phase."""
        return max(one.misfit for one in self.phases[name])


def findings() -> Findings:
    """Fly and compare."""
    paddling, hinge = direct(), through_the_hinge()
    levels = (paddling, hinge.level)
    return Findings(
        paddling=paddling,
        hinge=hinge,
        nominal={level.name: recovered(level, PEAK) for level in levels},
        phases={level.name: [recovered(level, SMALL, phase=float(p)) for p in PHASES] for level in levels},
        rigid=_against_rigid(hinge),
        times={level.name: _times(level) for level in levels},
        reduced_times={level.name: _reduced_times(level) for level in levels},
        spread={level.name: _spread(level) for level in levels},
        proportional=_proportional(paddling),
        durations=by_duration(paddling),
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
    return np.array([recovery_time(loop, pulse_for_peak(loop, BEAT, float(peak)), BAND) for peak in PEAKS])


def _proportional(level: Level) -> Recovery:
    task = PulseTask(duration=BEAT, peak=PEAK, tolerance=BAND)
    chosen = fastest_proportional(level.plant.damping_rate, DELAY, task)
    feedback, loop = level.feedback_with(chosen.kp, 0.0), level.loop_of(chosen)
    return recovered(level, PEAK, feedback=feedback, loop=loop, wingbeats=40)


def _against_rigid(hinge: Sprung) -> Recovery:
    """The same command gains, turned into torque by gamma mu, on the plant whose wings do not give way."""
    gains = hinge.level.feedback().gains
    law = PDController(
        proportional=gains.proportional * hinge.rigid_torque, derivative=gains.derivative * hinge.rigid_torque
    )
    return recovered(hinge.level, SMALL, loop=YawLoop(plant=hinge.rigid, controller=law, delay=DELAY))


# ## The figure


def draw(found: Findings) -> str:
    """Yaw and paddling after 20 deg, recovery time over strength, and what is left at every phase."""
    from flycontrol.report.style import in_house_style, new_figure

    with in_house_style():
        figure: Figure = new_figure(5.6)
        axes = figure.subplots(2, 2)
        _draw_yaw(axes[0, 0], found)
        _draw_paddling(axes[1, 0], found)
        _draw_times(axes[0, 1], found)
        _draw_off(axes[1, 1], found)
        buffer = io.StringIO()
        figure.savefig(buffer, format="svg", metadata={"Date": None, "Creator": None})
    return buffer.getvalue()


def _looks() -> dict[str, tuple[str, str, str]]:
    """Light line of the wing level, dark dashes of the reduced loop, marker."""
    from flycontrol.report.style import EXACT, MARK

    return {"paddling": ("#69add5", EXACT, "o"), "hinge bias": ("#f0b56b", MARK, "s")}


def _draw_yaw(ax: "Axes", found: Findings) -> None:
    from flycontrol.report.style import BAND as SHADE
    from flycontrol.report.style import PULSE

    ax.axhspan(-2, 2, color=SHADE)
    ax.axvspan(0, BEAT / ms, color=PULSE)
    for name, (light, dark, _) in _looks().items():
        one = found.nominal[name]
        ax.plot(one.time / ms, one.yaw / deg, color=light, linewidth=3.2, label=f"wings, {name}")
        ax.plot(
            one.time / ms, one.reduced / deg, color=dark, linewidth=1.1, linestyle=(0, (4, 2)), label="reduced loop"
        )
    ax.set(title="Yaw after a pulse (Fig. 7c)", xlabel="time from onset [ms]", ylabel="yaw [deg]", xlim=(-5, 95))
    ax.legend(loc="upper right")


def _draw_paddling(ax: "Axes", found: Findings) -> None:
    one = found.nominal["paddling"]
    light, dark, _ = _looks()["paddling"]
    beats = one.flight.d_alpha
    middle = one.time[0] + (np.arange(len(beats)) + 0.5) * BEAT
    ax.axvspan(0, BEAT / ms, color="#f4dfc6")
    ax.plot(middle / ms, 2 * beats / deg, "o", color=light, markersize=5, label="wings, by wingbeat")
    asked = reduced_torque(one) / found.paddling.torque
    ax.plot(
        one.time / ms, 2 * asked / deg, color=dark, linewidth=1.2, linestyle=(0, (4, 2)), label="reduced: 2 N_fly / γ"
    )
    ax.set(
        title="Paddling (Fig. 7d)",
        xlabel="time from onset [ms]",
        ylabel="right − left attack angle [deg]",
        xlim=(-5, 95),
        ylim=(-2.5, 0.2),
    )
    ax.legend(loc="lower right")


def reduced_torque(one: Recovery) -> FloatArray:
    """(N,) N_fly of the reduced loop [N m]."""
    response = pulse_response(one.loop.closed_loop(), one.pulse, one.time[-1])
    return np.where(one.time > 0, response(np.clip(one.time, 0.0, None))[2], 0.0)


def _draw_times(ax: "Axes", found: Findings) -> None:
    for level in found.levels:
        light, dark, marker = _looks()[level.name]
        loop = level.loop()
        fine = np.linspace(2.02, 40, 160) * deg
        unit = pulse_for_peak(loop, BEAT, 1.0)
        times = [recovery_time(loop, unit.times(float(peak)), BAND) for peak in fine]
        ax.plot(fine / deg, np.array(times) / ms, color=dark, linewidth=1.1, linestyle=(0, (4, 2)))
        ax.plot(
            PEAKS / deg, found.times[level.name] / ms, marker, color=light, markeredgecolor=dark, markersize=5,
            label=f"wings, {level.name}",
        )  # fmt: skip
    ax.axhline(DEADLINE / ms, color="#7d7d7d", linewidth=0.8, linestyle=(0, (1, 2)))
    ax.annotate("60 ms", (1, DEADLINE / ms), (0, 2), textcoords="offset points", fontsize=7.5)
    ax.set(
        title="Recovery time (Fig. 8c)", xlabel="peak of the reduced loop [deg]", ylabel="until within 2° [ms]",
        ylim=(0, 70), xlim=(0, 42),
    )  # fmt: skip
    ax.legend(loc="lower right")


def _draw_off(ax: "Axes", found: Findings) -> None:
    for name, (light, dark, _) in _looks().items():
        for k, one in enumerate(found.phases[name]):
            label = f"{name}, 8 phases" if k == 0 else None
            style = "-" if name == "paddling" else (0, (4, 1.5))
            colour = dark if name == "paddling" else light
            ax.plot(one.time / ms, 100 * one.off, color=colour, linewidth=0.9, linestyle=style, label=label)
    ax.axhspan(-1, 1, color="#e6edf1", zorder=0)
    ax.set(
        title="Wings less reduced loop", xlabel="time from onset [ms]", ylabel="share of the peak [%]", xlim=(-5, 95),
        ylim=(-1.8, 1.8),
    )  # fmt: skip
    ax.legend(loc="upper right")


# ## The answer
#
# On a magnetic tether the reduced loop is as good as the wings: after a pulse of one wingbeat the two levels stay
# within 1 % of the peak, whatever the phase and up to 80 deg, and recovery times within 1 ms. Through the hinge Eq. 8
# is right about the torque of a bias and wrong about the damping: wings on springs give way to a turning body, and with
# the damping that they leave the loop holds to 1.2 %. Slow sampling and filtering act as delays of their mean lag.
# What the loop has no place for are pulses of a fraction of a wingbeat, and roll, which is unstable in hover and turns
# with yaw: without roll control a free fly that controls yaw does not come back to its heading.


@dataclass(frozen=True, slots=True, kw_only=True)
class Claim:
    """A line of the table at the top of the note."""

    claim: str
    published: str
    ours: str
    agreement: str
    basis: str = "simulated"


def claims(found: Findings) -> list[Claim]:
    """What the review says or the reduced loop needs, what comes out, and whether they agree."""
    wing, reduced = found.times["paddling"], found.reduced_times["paddling"]
    at = {peak: float(wing[np.argmin(np.abs(PEAKS - peak * deg))]) for peak in (2.2, 5, 20, 40)}
    free = found.freedoms[-1]
    follows = paddling_follows(found)
    return [
        _claim(
            "the reduced loop holds on a tether, command = paddling", "Eq. 7",
            f"{100 * found.worst('paddling'):.2f} % of the peak at the worst of 8 phases",
            found.worst("paddling") < 0.01,
        ),
        _claim(
            "the same through the hinge, d_alpha = mu d_eta_0", "Eq. 8",
            f"{100 * found.rigid.misfit:.0f} % of the peak with the damping of wings that do not give way",
            found.rigid.misfit < 0.1,
        ),
        _claim(
            "through the hinge, with beta and torque per bias of passive wings", "not claimed",
            f"{100 * found.worst('hinge bias'):.1f} % of the peak", found.worst("hinge bias") < 0.1,
        ),
        _claim(
            "recovery in under 60 ms and 15 wingbeats", "section 6",
            f"{at[20] / ms:.1f} ms from 20 deg, {at[20] / BEAT:.1f} wingbeats", at[20] < min(DEADLINE, 15 * BEAT),
        ),
        _claim(
            "recovery time rises sharply, then plateaus", "Fig. 8c",
            ", ".join(f"{at[peak] / ms:.0f}" for peak in at) + " ms from 2.2, 5, 20, 40 deg; both levels within "
            f"{np.abs(wing - reduced).max() / ms:.1f} ms",
            (at[5] - at[2.2]) / 2.8 > 5 * (at[40] - at[20]) / 20,
        ),
        _claim(
            "P control alone is too slow", "section 6",
            f"{found.proportional.recovery_time / ms:.0f} ms from 20 deg at best",
            found.proportional.recovery_time > DEADLINE,
        ),
        _claim(
            "N_fly of Eq. 6 agrees with the measured paddling", "Fig. 7d",
            f"{100 * follows:.1f} % of the largest paddling apart", follows < 0.1,
        ),
        _claim(
            "yaw control suffices to keep a heading", "implied by section 6",
            f"in free flight heading is {free.yaw_later / deg:.1f} deg and roll {free.roll_later / deg:.0f} deg off 20 "
            "wingbeats after a 5 deg pulse: roll is unstable and turns with yaw",
            abs(free.yaw_later) < 0.1 * FREE_PEAK,
        ),
    ]  # fmt: skip


def _claim(claim: str, published: str, ours: str, holds: object) -> Claim:
    agreement = "fails" if not holds else "shown here" if published == "not claimed" else "agrees"
    return Claim(claim=claim, published=published, ours=ours, agreement=agreement)


def paddling_follows(found: Findings) -> float:
    """Largest difference of d_alpha by wingbeats from the reduced loop's wingbeat means, share of the largest."""
    one = found.nominal["paddling"]
    asked = one.flight.averaged(reduced_torque(one) / found.paddling.torque)
    n = one.flight.trajectory.samples_per_wingbeat
    beats = one.flight.d_alpha
    means = asked[n // 2 :: n][: len(beats)]
    return float(np.abs(beats - means).max() / np.abs(means).max())


def as_text(found: Findings) -> str:
    """The answer as a page of Markdown."""
    parts = [
        "# Recovery at two levels",
        "Agrees: within 1 % of the peak for paddling itself, 10 % through the hinge; recovery as published. Pulses "
        "last one wingbeat.\n\n| claim | published | here | agreement |\n|---|---|---|---|\n"
        + "\n".join(f"| {c.claim} | {c.published} | {c.ours} | {c.agreement} |" for c in claims(found)),
        _levels_part(found),
        "## What the reduced loop has no place for\n\nLargest difference of the two levels, share of the peak; "
        "command = paddling, yaw alone, 1 deg unless said.\n\n" + _rows_part(found),
        _freedom_part(found),
        "![Yaw, recovery time, paddling, and what is left](recovery_at_two_levels.svg)",
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
            f"| {100 * found.worst(level.name):.2f} |"
        )
    hinge = found.hinge
    tail = (
        f"\n\nmu = {hinge.mu:.2f}. What Eq. 8 lacks: a turning body pitches wings on springs, so that beta/I falls "
        f"from {hinge.rigid.damping_rate:.0f} to {hinge.level.plant.damping_rate:.0f} 1/s. gamma mu itself is right: "
        f"{hinge.rigid_torque * 1e9:.1f} against {hinge.level.torque * 1e9:.1f} nN m per radian of bias."
    )
    return head + "\n".join(rows) + tail


def _rows_part(found: Findings) -> str:
    def table(title: str, rows: Sequence[Row]) -> str:
        lines = [f"| {row.name} | {100 * row.misfit:.2f} |{_percent(row.delayed)}" for row in rows]
        lagging = rows[0].delayed is not None
        head = f"| {title} | reduced loop [%] |" + " its delay longer by the lag [%] |" * lagging
        return "\n".join([head, "|---|---|" + "---|" * lagging, *lines])

    return "\n\n".join([
        table("duration of the pulse, worst of 8 phases", found.durations),
        table("strength", found.strengths),
        table("sensing and steering", found.sensing),
    ])  # fmt: skip


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
        "mu": found.hinge.mu,
        "durations": [asdict(row) for row in found.durations],
        "strengths": [asdict(row) for row in found.strengths],
        "sensing": [asdict(row) for row in found.sensing],
        "freedoms": [asdict(row) for row in found.freedoms],
    }
    short = json.loads(json.dumps(rows), parse_float=lambda text: float(f"{float(text):.6g}"))
    return json.dumps(short, indent=2) + "\n"


def main(folder: Path = FOLDER) -> Findings:
    """Find, draw and write."""
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
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else FOLDER)
