"""Does `flycontrol fit` find the gains that a fly with beating wings was given?

Run with `python analyses/fit_the_simulated_fly.py [FOLDER]`; the measured hover is looked for in $FLYCONTROL_DATA, else
in ../shared/data. The note, the numbers and the figure go to reports/fit_the_simulated_fly unless a folder is given. It
takes two to three minutes of an idle core.
"""

import io
import json
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from _by_hand import DATA, REPORTS, folder_named, measured
from numpy.typing import NDArray

from flycontrol.flight.feedback import Sampling, YawFeedback
from flycontrol.flight.feedback_flight import controlled_flight
from flycontrol.flight.flapping_fly import FlappingFly
from flycontrol.flight.hinge_fit import at_pitch_axis, fitted_spring
from flycontrol.flight.hinge_motion import passive_wingbeat, sprung
from flycontrol.flight.hinge_transmission import hinge_transmission
from flycontrol.flight.multibody.freedoms import YAW_ONLY, Hinge
from flycontrol.flight.pulses import BodyPulse
from flycontrol.flight.sensors import Haltere
from flycontrol.flight.settings import MarchSettings
from flycontrol.identify.gains.fit import fit_gains, fit_without_profiles
from flycontrol.identify.gains.result import FitResult
from flycontrol.io.morphology import read_morphology_table
from flycontrol.io.series_conventions import CONVENTIONS
from flycontrol.io.series_files import read_series_file
from flycontrol.io.simulated_trials import MAPPING, simulated_trial_files
from flycontrol.io.trials import read_trials
from flycontrol.jobs.files import write_files_atomically
from flycontrol.jobs.work import generator
from flycontrol.model.hinge import HingeStroke, SteeredSpring
from flycontrol.model.morphology import morphology_from_table
from flycontrol.model.recovery import pulse_for_peak
from flycontrol.model.simulated_recording import PERFECT, CameraNoise, simulated_trial
from flycontrol.model.stroke_kinematics import StrokeKinematics, hover_stroke
from flycontrol.model.trajectory import FlightState, Trajectory
from flycontrol.model.trial import Pulse, Trial
from flycontrol.model.yaw import PDController, YawLoop, YawPlant
from flycontrol.reduce.reduced_yaw import reduced_yaw
from flycontrol.units import deg, ms

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FloatArray = NDArray[np.float64]
FOLDER = REPORTS / "fit_the_simulated_fly"
STROKE = hover_stroke()
MEASURED_FREQUENCY = 218.0  #: of the measured hover [1/s]
PITCH_AXIS = 0.05  #: at which hinge_as_a_spring finds passive pitching closest to measured pitch [chords]
DELAY_BEATS = 3
GAINS = (5510.0, 39.6)  #: K_P and K_D over the inertia [1/s^2, 1/s] by the rule of recovery_at_two_levels; certainty C
SPRING_GAINS = (2560.0, 48.5)  #: by the same rule for wings on springs
FRAMES = MarchSettings(steps=200, samples=40, estimate_error=False)  # 8800 frames a second
NOISE = CameraNoise(yaw=0.3 * deg, wing_angle=1 * deg)
PEAKS = (2.5, 5.0, 10.0, 20.0, 40.0)  #: [deg]
DRAWS = (100, 100, 50, 50, 50)  #: more where the interval should hold
RECORDINGS, SEED, WINGBEATS = 8, 0, 25
NAMES = ("kp", "kd", "delay", "damping", "paddling_gain")
WORDS = {"kp": "K_P/I", "kd": "K_D/I", "delay": "delay", "damping": "beta/I", "paddling_gain": "gamma/I"}
UNITS = {"kp": ("1/s^2", 1.0), "kd": ("1/s", 1.0), "delay": ("ms", ms), "damping": ("1/s", 1.0),
         "paddling_gain": ("1000/s^2 per rad", 1e3)}  # fmt: skip

# ## The question
#
# A fit of recorded flies rests on the reduced loop: linear, averaged over the wingbeat, yaw alone. If the flies were
# exactly what the wing level makes of them, would the fit find what they were given? The truth is known here: K_P and
# K_D are put in, the delay is three wingbeats, beta, gamma and I come from the wings by turning, paddling and inverse
# dynamics. An experiment is eight recordings of one fly on a magnetic tether, pulses of one wingbeat at eight phases to
# alternating sides, cameras at 8800 frames a second with 0.3 deg of white noise on yaw and 1 deg on wing angles.
#
# Most flies paddle on command with the built-in stroke. One hangs its wings on springs; stroke, deviation and spring
# are those of the measured hover.


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Subject:
    """A fly at the wing level, and what a fit should find of it."""

    name: str
    fly: FlappingFly
    stroke: StrokeKinematics
    start: FlightState | None
    plant: YawPlant
    feedback: YawFeedback
    truth: dict[str, float]  #: in the units of a fit

    @property
    def beat(self) -> float:
        """A wingbeat [s]."""
        return 1 / self.stroke.frequency

    @property
    def loop(self) -> YawLoop:
        """The reduced loop of the truth."""
        inertia = self.plant.inertia
        law = PDController(proportional=self.truth["kp"] * inertia, derivative=self.truth["kd"] * inertia)
        return YawLoop(plant=self.plant, controller=law, delay=self.truth["delay"])


def melanogaster(frequency: float = STROKE.frequency) -> FlappingFly:
    """The published fly, which may only yaw."""
    morphology = morphology_from_table(read_morphology_table(), "Drosophila melanogaster", frequency)
    return FlappingFly(morphology=morphology, body=YAW_ONLY)


def commanded(gains: tuple[float, float], per: float, beat: float) -> YawFeedback:
    """Gains over the inertia, `per` the command that makes a yaw acceleration of 1 [rad s^2]."""
    law = PDController(proportional=gains[0] * per, derivative=gains[1] * per)
    return YawFeedback(gains=law, delay=DELAY_BEATS * beat)


def subject(name: str, *, late: float = 0.0, **sensing: object) -> Subject:
    """Its command is the paddling angle; `late` is the mean lag of what is not a delay [s]."""
    model, beat = reduced_yaw(melanogaster(), STROKE), 1 / STROKE.frequency
    per = model.inertia.total / model.paddling
    truth = {"kp": GAINS[0], "kd": GAINS[1], "delay": DELAY_BEATS * beat + late, "damping": model.plant.damping_rate,
             "paddling_gain": 1 / per}  # fmt: skip
    return Subject(
        name=name, fly=melanogaster(), stroke=STROKE, start=None, plant=model.plant,
        feedback=replace(commanded(GAINS, per, beat), **sensing), truth=truth,
    )  # fmt: skip


def measured_hover() -> StrokeKinematics:
    """Both wings of *D. melanogaster* in hover (Fry 2005, digitised by others)."""
    path = DATA / "kinematics_fourier" / "Drosophila_hovering_fry.json"
    return StrokeKinematics.symmetric(read_series_file(path, CONVENTIONS["hovering fruit fly"]), MEASURED_FREQUENCY)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class OnSprings:
    """The fly on springs, and the damping that it would have if its wings did not give way."""

    subject: Subject
    rigid_damping: float  #: beta/I [1/s]
    gamma: float  #: torque per paddling over I, body and bias held [1/s^2 per rad]
    settling: float  #: of pitch on the springs, to 1/e [s]


def on_springs() -> OnSprings:
    """Its command biases the rest angles; beta and the torque of a bias with wings that give way."""
    stroke = measured_hover()
    plain, beat = at_pitch_axis(melanogaster(stroke.frequency), PITCH_AXIS), 1 / stroke.frequency
    spring = fitted_spring(plain, stroke).spring
    joint = SteeredSpring(stiffness=spring.stiffness, damping=spring.damping)
    rests = HingeStroke(stroke=stroke.left, rest_angle=spring.rest_angle)
    way = hinge_transmission(plain, stroke, spring)
    inertia, hover = reduced_yaw(plain, stroke).inertia.total, passive_wingbeat(sprung(plain, spring), stroke)
    sprung_fly = Subject(
        name="through the hinge, measured hover",
        fly=replace(plain, left=Hinge(pitch=joint), right=Hinge(pitch=joint)),
        stroke=replace(stroke, left=rests, right=rests),
        start=hover.start,
        plant=YawPlant(inertia=inertia, damping=way.damping),
        feedback=commanded(SPRING_GAINS, inertia / way.torque_per_bias, beat),
        truth={"kp": SPRING_GAINS[0], "kd": SPRING_GAINS[1], "delay": DELAY_BEATS * beat,
               "damping": way.damping / inertia, "paddling_gain": way.torque_per_bias / way.mu / inertia},
    )  # fmt: skip
    return OnSprings(
        subject=sprung_fly, rigid_damping=way.damping_at_given_pitch / inertia,
        gamma=way.torque_per_paddling / inertia, settling=hover.settling * beat,
    )  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Flown:
    """An experiment before cameras saw it."""

    subject: Subject
    peak: float  #: [rad]
    flights: tuple[Trajectory, ...]
    pulses: tuple[Pulse, ...]

    def seen(self, noise: CameraNoise, draw: int) -> tuple[Trial, ...]:
        """Trials with the noise of one draw, which no other strength shares."""
        seed = SEED + round(1000 * self.peak / deg)
        return tuple(
            simulated_trial(
                flight, f"pulse{k + 1}", pulse, fly="fly1", noise=noise, rng=generator(seed, draw * RECORDINGS + k)
            )
            for k, (flight, pulse) in enumerate(zip(self.flights, self.pulses, strict=True))
        )


def experiment(who: Subject, peak: float) -> Flown:
    """Eight recordings whose pulses would turn the reduced loop by the peak [rad]."""
    push = pulse_for_peak(who.loop, who.beat, peak)
    flights, pulses = [], []
    for k in range(RECORDINGS):
        onset = (1 + k / RECORDINGS) * who.beat
        pulse = BodyPulse(start=onset, duration=who.beat, torque_S=(0.0, 0.0, push.torque * (-1) ** k))
        flown = controlled_flight(
            who.fly, who.stroke, who.feedback, WINGBEATS, start=who.start, pulses=[pulse], settings=FRAMES
        )
        flights.append(flown.trajectory)
        pulses.append(Pulse(onset=onset, duration=who.beat))
    return Flown(subject=who, peak=peak, flights=tuple(flights), pulses=tuple(pulses))


# ## Noise against the model's error
#
# A fit to recordings without noise shows what the reduced loop itself gets wrong: that error does not shrink however
# many flies are filmed. With noise there are intervals, and the question is whether they hold the truth. Noise is drawn
# anew for every experiment of every strength; those fits begin where the noiseless one ended, to save time. The first
# draw of each strength goes through files and the whole search, as `flycontrol fit` does it.


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Drawn:
    """Fits of noisy experiments, arrays in the order of NAMES."""

    values: FloatArray  #: (draws, 5) estimates over truth
    errors: FloatArray  #: (draws, 5) standard errors over truth
    held: FloatArray  #: (draws, 5) 1 where the interval holds the truth, else 0

    @property
    def draws(self) -> int:
        """How many."""
        return len(self.held)

    @property
    def inside(self) -> FloatArray:
        """(5,) share of the intervals that hold the truth."""
        return np.asarray(self.held.mean(axis=0))

    @property
    def standard_error(self) -> FloatArray:
        """(5,) median over the draws, share of the truth."""
        return np.median(self.errors, axis=0)

    @property
    def shift(self) -> FloatArray:
        """(5,) mean of the estimates less truth, in standard errors."""
        return np.asarray((self.values.mean(axis=0) - 1) / self.standard_error)

    @property
    def spread(self) -> FloatArray:
        """(5,) standard deviation of the estimates in the standard errors that are stated."""
        return np.asarray(((self.values - self.values.mean(axis=0)) / self.errors).std(axis=0, ddof=1))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Strength:
    """Fits of one strength."""

    peak: float  #: [deg]
    example: FitResult  #: of the first draw, read from files
    drawn: Drawn


def at_strength(who: Subject, peak: float, draws: int) -> Strength:
    """Fit without noise, then with."""
    flown = experiment(who, peak * deg)
    start = fit_without_profiles(flown.seen(PERFECT, 0), noise="white").minimum.x
    return Strength(peak=peak, example=fit_gains(through_files(flown.seen(NOISE, 0))), drawn=drawn(flown, start, draws))


def drawn(flown: Flown, start: FloatArray, draws: int) -> Drawn:
    """Draw the noise, fit, see whether the interval holds the truth."""
    truth = _row(flown.subject.truth)
    fits = [fit_without_profiles(flown.seen(NOISE, draw), start=start) for draw in range(1, draws + 1)]
    estimates = [[fit[name] for name in NAMES] for fit in fits]
    low, high = (np.array([[getattr(e, end) for e in row] for row in estimates]) for end in ("low", "high"))
    return Drawn(
        values=np.array([[e.value for e in row] for row in estimates]) / truth,
        errors=np.array([[e.standard_error for e in row] for row in estimates]) / truth,
        held=((low <= truth) & (truth <= high)).astype(float),
    )


def through_files(trials: Sequence[Trial]) -> tuple[Trial, ...]:
    """Write tables and read them as `flycontrol fit *.csv --mapping simulated_trials` does."""
    with tempfile.TemporaryDirectory() as folder:
        files = simulated_trial_files(trials)
        write_files_atomically(Path(folder), files)
        return read_trials([Path(folder) / name for name in files], MAPPING)


def _row(values: dict[str, float]) -> FloatArray:
    return np.array([values[name] for name in NAMES])


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Exact:
    """A fit to recordings of 10 deg without noise."""

    subject: Subject
    fit: FitResult

    @property
    def off(self) -> FloatArray:
        """(5,) estimate less truth, share of the truth, in the order of NAMES."""
        return np.array([self.fit[name].value for name in NAMES]) / _row(self.subject.truth) - 1


def without_noise(who: Subject) -> Exact:
    """What the reduced loop itself gets wrong."""
    return Exact(subject=who, fit=fit_without_profiles(experiment(who, 10 * deg).seen(PERFECT, 0), noise="white"))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Findings:
    """All that the note says."""

    exact: list[Exact]  #: the first one's subject is that of `strengths`
    rigid_damping: float  #: beta/I of the fly on springs if its wings did not give way [1/s]
    gamma: float  #: over I, of the fly on springs, by paddling [1/s^2 per rad]
    settling: float  #: of its pitch [s]
    strengths: list[Strength]

    @property
    def crossing(self) -> FloatArray:
        """(5,) peak at which the model's error is a standard error of one experiment, which goes as 1/peak [deg]."""
        last = self.strengths[-1]
        return last.peak * last.drawn.standard_error / np.abs(self.exact[0].off)

    @property
    def springs(self) -> Exact:
        """The fly through the hinge."""
        return self.exact[1]


def findings() -> Findings:
    """Fly, film, fit."""
    plain, springs = subject("paddling"), on_springs()
    sampling = Sampling(per_wingbeat=1)
    held = subject("steered once a wingbeat", late=(1 + sampling.ramp) / 2 / STROKE.frequency, sampling=sampling)
    haltere = subject("haltere as a filter of 2 ms", late=2 * ms, sensor=Haltere(time_constant=2 * ms))
    return Findings(
        exact=[without_noise(who) for who in (plain, springs.subject, held, haltere)],
        rigid_damping=springs.rigid_damping,
        gamma=springs.gamma,
        settling=springs.settling,
        strengths=[at_strength(plain, peak, draws) for peak, draws in zip(PEAKS, DRAWS, strict=True)],
    )


# ## The figure


def draw(found: Findings) -> str:
    """Left one experiment at each strength, right standard errors against the model's error."""
    from flycontrol.report.style import in_house_style, new_figure

    with in_house_style():
        figure: Figure = new_figure(3.3)
        left, right = figure.subplots(1, 2)
        _draw_estimates(left, found)
        _draw_errors(right, found)
        buffer = io.StringIO()
        figure.savefig(buffer, format="svg", metadata={"Date": None, "Creator": None})
    return buffer.getvalue()


_LOOKS = {"kp": ("#0b3954", "o"), "kd": ("#e08a00", "s"), "delay": ("#c8323c", "^"), "damping": ("#69add5", "D")}


def _draw_estimates(ax: "Axes", found: Findings) -> None:
    truth = found.exact[0].subject.truth
    for k, (name, (colour, marker)) in enumerate(_LOOKS.items()):
        estimates = [one.example[name] for one in found.strengths]
        middle = np.array([100 * (e.value / truth[name] - 1) for e in estimates])
        ends = np.array([[100 * (end / truth[name] - 1) for end in (e.low, e.high)] for e in estimates])
        place = np.arange(len(PEAKS)) + 0.17 * (k - 1.5)
        ax.errorbar(
            place, middle, np.abs(ends.T - middle), fmt=marker, color=colour, markersize=4.5, capsize=2, linewidth=1.2,
            label=WORDS[name].replace("beta", "β"),
        )  # fmt: skip
    ax.axhline(0, color="#7d7d7d", linewidth=0.8, linestyle=(0, (1, 2)))
    ax.set_xticks(range(len(PEAKS)), [f"{peak:g}" for peak in PEAKS])
    ax.set(title="One experiment each, 95 % intervals", xlabel="peak of yaw [deg]", ylabel="estimate less truth [%]")
    ax.legend(loc="upper right", ncols=2, columnspacing=1.0)


def _draw_errors(ax: "Axes", found: Findings) -> None:
    from flycontrol.report.style import plain_log_ticks

    for name, (colour, marker) in _LOOKS.items():
        k = NAMES.index(name)
        spread = [100 * one.drawn.standard_error[k] for one in found.strengths]
        ax.plot(PEAKS, spread, marker=marker, color=colour, markersize=4.5, linewidth=1.3, label=WORDS[name])
        ax.axhline(100 * abs(found.exact[0].off[k]), color=colour, linewidth=1.1, linestyle=(0, (4, 2)))
    ax.set(
        title="Standard error; the model's: dashed", xlabel="peak of yaw [deg]",
        ylabel="share of the truth [%]", xscale="log", yscale="log",
    )  # fmt: skip
    ax.set_xticks(PEAKS)
    for which in ("x", "y"):
        plain_log_ticks(ax, which)


# ## The answer
#
# It opens the note, in the words of `_answer`; what its numbers are comes from `findings`.


def as_text(found: Findings) -> str:
    """The answer as a page of Markdown."""
    return (
        "\n\n".join([
            "# Fit the simulated fly",
            _answer(found),
            _claims_part(found),
            _exact_part(found),
            _noise_part(found),
            "![Estimates and intervals over the strength of the pulse](fit_the_simulated_fly.svg)",
        ])
        + "\n"
    )  # fmt: skip


def _answer(found: Findings) -> str:
    own, springs = np.abs(found.exact[0].off), found.springs
    kp, delay = (found.crossing[NAMES.index(name)] for name in ("kp", "delay"))
    gamma = NAMES.index("paddling_gain")
    weak = found.strengths[:2]
    return (
        f"Yes, to {100 * own.max():.1f} % for wings that paddle on command: that is what the reduced loop itself gets "
        "wrong, with these gains, in recordings without noise; it differs from gains to gains. With the noise of eight "
        "recordings 95 % intervals hold the truth "
        f"({_names()}) in\n\n{_held_list(found)}\n\n"
        f"The reduced loop's own error is as large as a standard error from pulses of {kp:.0f} deg on for K_P/I and of "
        f"{delay:.0f} deg for the delay. From there on, where published experiments lie, both are known more precisely "
        "than the model deserves: estimates spread as their standard errors say, but about a value that is off, and "
        "intervals are too narrow. Intervals of gamma/I hold it in "
        f"{sum(one.drawn.held[:, gamma].sum() for one in weak):.0f} of {sum(one.drawn.draws for one in weak)} "
        f"experiments with weak pulses; its estimates spread by {' and '.join(_spread(one, gamma) for one in weak)} of "
        "the standard errors that are stated.\n\n"
        "Through the hinge the damping that is found is that of wings that give way, "
        f"{springs.fit['damping'].value:.0f} 1/s where wings whose pitch is given have {found.rigid_damping:.0f}, and "
        f"the delay is {springs.off[2] * springs.subject.truth['delay'] / ms:.1f} ms too long: a wing takes "
        f"{found.settling / ms:.1f} ms to follow its spring. gamma/I from the paddling that is seen lies between what "
        "torque per bias over mu and torque per paddling give. A fly that steers once a wingbeat, or whose halteres "
        "filter, shows as one with a longer delay and a weaker K_D.\n\n"
        "Beware: all is simulated. The flies are on a tether and do exactly what they are told; noise is white; gains "
        "are by rule (certainty C); one fly is one set of parameters, so spread between flies is not in question. Made "
        "by [analyses/fit_the_simulated_fly.py](../../analyses/fit_the_simulated_fly.py)."
    )


def _held_list(found: Findings) -> str:
    return "\n".join(
        f"- {_held(one)} of {one.drawn.draws} experiments with pulses of {one.peak:g} deg" for one in found.strengths
    )


def _held(one: Strength) -> str:
    return ", ".join(f"{held:.0f}" for held in one.drawn.held.sum(axis=0))


def _share(one: Strength, k: int) -> str:
    return f"{100 * one.drawn.inside[k]:.0f} %"


def _spread(one: Strength, k: int) -> str:
    return f"{one.drawn.spread[k]:.2f}"


def _claims_part(found: Findings) -> str:
    rows = [
        f"| {' | '.join(each[key] for key in ('claim', 'published', 'ours', 'agreement'))} |" for each in claims(found)
    ]
    return "| claim | published | here | agreement |\n|---|---|---|---|\n" + "\n".join(rows)


def _names() -> str:
    return ", ".join(WORDS[name] for name in NAMES)


def _exact_part(found: Findings) -> str:
    head = (
        "## Without noise: what the reduced loop itself gets wrong\n\nPulses of 10 deg. Each cell: "
        "found, of what was put in or extracted apart; a filter or holding a command counts as delay by its mean "
        "lag.\n\n| fly | " + " | ".join(f"{WORDS[n]} [{UNITS[n][0]}]" for n in NAMES) + " |\n" + "|---" * 6 + "|\n"
    )
    rows = []
    for one in found.exact:
        cells = [
            f"{one.fit[n].value / UNITS[n][1]:.4g} of {one.subject.truth[n] / UNITS[n][1]:.4g} ({100 * off:+.1f} %)"
            for n, off in zip(NAMES, one.off, strict=True)
        ]
        rows.append(f"| {one.subject.name} | {' | '.join(cells)} |")
    tail = (
        "\n\nThrough the hinge, stroke and spring are those of the measured hover; beta is that of wings that give way "
        f"(with given pitch beta/I would be {found.rigid_damping:.0f} 1/s), gamma is torque per bias over mu."
    )
    return head + "\n".join(rows) + tail


def _noise_part(found: Findings) -> str:
    head = (
        f"## With noise: {NOISE.yaw / deg:g} deg on yaw, {NOISE.wing_angle / deg:g} deg on wing angles\n\n"
        "Eight recordings an experiment, noise drawn anew for every experiment of every strength. Each cell: how often "
        "the 95 % interval holds the truth (binomial standard error 2 % for 100 draws and 3 % for 50, at 95 %); "
        "standard error; mean of the estimates less truth, and their spread, in standard errors.\n\n"
        "| peak, draws | " + " | ".join(WORDS[n] for n in NAMES) + " |\n" + "|---" * 6 + "|\n"
    )
    rows = []
    for one in found.strengths:
        seen = one.drawn
        columns = zip(seen.inside, seen.standard_error, seen.shift, seen.spread, strict=True)
        cells = [
            f"{100 * inside:.0f} %; {100 * error:.2g} %; {off:+.1f}; {sd:.2f}" for inside, error, off, sd in columns
        ]
        rows.append(f"| {one.peak:g} deg, {seen.draws} | {' | '.join(cells)} |")
    crossing = " | ".join(f"{peak:.0f} deg" for peak in found.crossing)
    return head + "\n".join(rows) + f"\n| the model's error is a standard error at | {crossing} |"


def claims(found: Findings) -> list[dict[str, str]]:
    """What the review builds on, what comes out, and whether they agree."""
    own = np.abs(found.exact[0].off[:4]).max()
    return [
        {
            "claim": "a fit of the delayed loop finds gains, delay and damping of wings that paddle on command",
            "published": "not claimed: used there",
            "ours": f"without noise within {100 * own:.1f} % of what the wings were given",
            "agreement": "shown here" if own < 0.02 else "fails",
            "where": "section 6, Fig. 7c",
            "basis": "simulated",
        },
        *hinge_claims(found),
        *interval_claims(found),
    ]


def hinge_claims(found: Findings) -> list[dict[str, str]]:
    """What a fit makes of wings on springs."""
    damping = found.springs.fit["damping"].value
    gamma, per_bias = found.springs.fit["paddling_gain"].value, found.springs.subject.truth["paddling_gain"]
    off = gamma / found.gamma - 1
    return [
        {
            "claim": "a fit of wings on springs finds beta of wings whose pitch is given",
            "published": "Eq. 8",
            "ours": f"beta/I {damping:.0f} 1/s is found, not {found.rigid_damping:.0f}: wings on springs give way",
            "agreement": "agrees" if abs(damping / found.rigid_damping - 1) < 0.1 else "fails",
            "where": "section 7, Eq. 8",
            "basis": "simulated",
        },
        {
            "claim": "the torque of wings on springs over the paddling that cameras see is gamma",
            "published": "Eq. 8",
            "ours": f"gamma/I {gamma / 1e3:.0f} is found, {found.gamma / 1e3:.0f} by paddling, {per_bias / 1e3:.0f} by "
            "bias over mu [1000/s^2 per rad]",
            "agreement": "agrees" if abs(off) < 0.1 else "roughly" if abs(off) < 0.25 else "fails",
            "where": "section 7, Eq. 8",
            "basis": "simulated",
        },
    ]


def interval_claims(found: Findings) -> list[dict[str, str]]:
    """How often intervals hold the truth, and up to where they should."""
    small = found.strengths[0]
    return [
        {
            "claim": f"95 % intervals hold the truth: pulses of {small.peak:g} deg",
            "published": "not claimed",
            "ours": f"{', '.join(f'{100 * share:.0f}' for share in small.drawn.inside)} % of {small.drawn.draws} "
            f"experiments ({_names()})",
            "agreement": "shown here",
            "where": "",
            "basis": "simulated",
        },
        {
            "claim": "95 % intervals hold the truth: stronger pulses, K_P/I",
            "published": "not claimed",
            "ours": ", ".join(f"{_share(one, 0)} at {one.peak:g} deg" for one in found.strengths[1:])
            + f"; its own error is a standard error of {RECORDINGS} recordings at {found.crossing[0]:.0f} deg",
            "agreement": "shown here: not where pulses are strong",
            "where": "",
            "basis": "simulated",
        },
    ]


def as_numbers(found: Findings) -> str:
    """The numbers as JSON, six digits."""
    rows = {
        "claims": claims(found),
        "seed": SEED,
        "recordings": RECORDINGS,
        "without_noise": {
            one.subject.name: {
                name: {"truth": one.subject.truth[name], "estimate": one.fit[name].value} for name in NAMES
            }
            for one in found.exact
        },
        "with_noise": {
            f"{one.peak:g} deg": {
                "draws": one.drawn.draws,
                **{
                    name: {
                        "inside": float(one.drawn.inside[k]),
                        "relative_standard_error": float(one.drawn.standard_error[k]),
                        "spread_in_standard_errors": float(one.drawn.spread[k]),
                        "mean_relative_error": float(one.drawn.values[:, k].mean() - 1),
                    }
                    for k, name in enumerate(NAMES)
                },
            }
            for one in found.strengths
        },
        "crossing_deg": dict(zip(NAMES, found.crossing.tolist(), strict=True)),
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
            "fit_the_simulated_fly.md": text,
            "fit_the_simulated_fly.json": as_numbers(found),
            "fit_the_simulated_fly.svg": draw(found),
        },
    )
    print(text)
    return found


if __name__ == "__main__":
    main(folder_named(__file__, __doc__, FOLDER))
