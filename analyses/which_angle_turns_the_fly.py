"""Which of the wings' three angles turns the fly?  Review, section 4 and Fig. 4.

Run with `python analyses/which_angle_turns_the_fly.py [FOLDER]`; the recordings are looked for in $FLYCONTROL_DATA,
else in ../shared/data. Table, figure and numbers go to reports/which_angle_turns_the_fly unless a folder is given.
"""

import json
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from _by_hand import DATA, REPORTS, folder_named
from hinge_as_a_spring import hovering_fly
from numpy.typing import NDArray
from replayed_flights import FLY, Flight, Replay, flights, svg_of
from scipy.spatial.transform import Rotation

from flycontrol.flight.coefficients import COEFFICIENTS
from flycontrol.flight.flapping_fly import FlappingFly
from flycontrol.flight.flight_record import taken
from flycontrol.flight.hinge_fit import at_pitch_axis
from flycontrol.flight.multibody.freedoms import YAW_ONLY, Hinge
from flycontrol.flight.quasi_steady import TERMS
from flycontrol.flight.settings import MarchSettings
from flycontrol.flight.simulate import simulate_flight
from flycontrol.jobs.files import write_files_atomically
from flycontrol.model.collapsed_wingbeats import CollapsedWingbeats, collapsed_wingbeats, wingbeats_between
from flycontrol.model.hinge import HingeStroke, SteeredSpring
from flycontrol.model.jitter import Jitter, jittered, wingbeat_jitter
from flycontrol.model.recording import Recording, WingAngles
from flycontrol.model.stroke import ANGLES, Angle, WingMotion
from flycontrol.model.stroke_kinematics import StrokeKinematics
from flycontrol.model.trajectory import FlightState, Trajectory
from flycontrol.model.turn import find_turns
from flycontrol.model.wing_stroke import FourierStroke, ModulatedStroke, Modulation, fourier_stroke
from flycontrol.model.wingbeats import Wingbeats, segment_wingbeats, wingbeat_mean
from flycontrol.reduce.factorial import Factorial
from flycontrol.reduce.symmetrised_torque import at_rest, torques_by_wingbeat, torques_of_stroke
from flycontrol.reduce.symmetrised_turn import turn_angles
from flycontrol.reduce.torque_shares import (
    Interval,
    TorqueShares,
    shares_of_collapsed,
    shares_of_slope,
)
from flycontrol.units import deg

if TYPE_CHECKING:
    from matplotlib.axes import Axes

FloatArray = NDArray[np.float64]
NAME = "which_angle_turns_the_fly"
nNm, pNm = 1e-9, 1e-12
SMALL = 0.25  # of the torque: an angle with a share below this does not turn the fly (C)
CLAIMED = 0.9  # "small changes in wing pitch are responsible for about 90% of the yaw torque generated"

# ## The claim
#
# The review collapses the wingbeats of a turn of 120 deg, finds differences between right and left in stroke,
# deviation and pitch, gives both wings the mean of one or two of the angles, and plays the eight motions in a
# simulation. Stroke alone does not turn its fly; pitch makes about 90 % of the yaw torque.
#
# Eight versions are a full factorial: what each angle does alone, what is lost without it, their interaction, and
# Shapley's share, the mean over all orders, which adds up to 1. Intervals are 95 %, from blocks of wingbeats.
#
# ## Turns that are known
#
# A published fly with a measured hover stroke, free to yaw and to nothing else, is steered for ten wingbeats: by
# paddling, by biased hinge springs, by stroke amplitude, by deviation, and by all at once. Films of it get the jitter
# of a tracked flight, and the method must say who did it.

BEFORE, TURNING, AFTER = 5, 10, 4  # wingbeats
FRAMES = 40  # a wingbeat
SPRING = {"stiffness": 2.39e-9, "damping": 1.55e-12}  # of this stroke, see hinge_as_a_spring.py
REST_ANGLE, PITCH_AXIS = 97 * deg, 0.05
SEED = 20091
NONE = Modulation()
DRAWS = 400


@dataclass(frozen=True, slots=True, kw_only=True)
class Steering:
    """What right and left wing do to turn, opposite to one another."""

    name: str
    right: Modulation
    by: tuple[Angle, ...]  #: the angles that differ
    hinge: bool = False  #: through springs, whose rest angles are biased

    @property
    def left(self) -> Modulation:
        """The mirror image's opposite."""
        r = self.right
        return Modulation(stroke_gain=-r.stroke_gain, deviation_offset=-r.deviation_offset,
                          pitch_offset=-r.pitch_offset)  # fmt: skip


STEERINGS = (
    Steering(name="paddling, 2 deg", right=Modulation(pitch_offset=2 * deg), by=("pitch",)),
    Steering(name="biased hinges, 3 deg", right=Modulation(pitch_offset=3 * deg), by=("pitch",), hinge=True),
    Steering(name="stroke amplitude, 10 %", right=Modulation(stroke_gain=0.1), by=("stroke",)),
    Steering(name="stroke amplitude, 30 %", right=Modulation(stroke_gain=0.3), by=("stroke",)),
    Steering(name="deviation, 8 deg", right=Modulation(deviation_offset=8 * deg), by=("deviation",)),
    Steering(
        name="all three: 10 %, 8 deg, 2 deg",
        right=Modulation(stroke_gain=0.1, deviation_offset=8 * deg, pitch_offset=2 * deg), by=ANGLES,
    ),
)  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True)
class KnownTurn:
    """A simulated turn and what was found of it."""

    steering: Steering
    turned: float  #: while it was steered and after [rad]
    truth: Factorial  #: torque of the wings' motion in mid-turn, body held, no film between [N m]
    flown: Factorial  #: turn angle of the eight versions, flown anew [rad]
    filmed: TorqueShares  #: from the film, with jitter


def flown_turn(steering: Steering) -> tuple[FlappingFly, Trajectory]:
    """Fly it."""
    hover = hovering_fly()
    fly = replace(at_pitch_axis(hover.fly, PITCH_AXIS), body=YAW_ONLY)
    stroke: Any = hover.stroke.left
    if steering.hinge:
        sprung = Hinge(pitch=SteeredSpring(**SPRING))
        fly, stroke = replace(fly, left=sprung, right=sprung), HingeStroke(stroke=stroke, rest_angle=REST_ANGLE)

    def steered(beat: int, _: FlightState) -> StrokeKinematics:
        """What the wings do in a wingbeat: nothing, the change coming, all of it, the change going."""
        now, then = (k >= BEFORE and k < BEFORE + TURNING for k in (beat, beat + 1))
        ramp = (float(beat), beat + 1.0)
        left, right = (
            ModulatedStroke(stroke=stroke, before=change if now else NONE, after=change if then else NONE, ramp=ramp)
            for change in (steering.left, steering.right)
        )
        return StrokeKinematics(frequency=hover.stroke.frequency, left=left, right=right)

    settings = MarchSettings(steps=800, samples=400, estimate_error=False)
    return fly, simulate_flight(fly, steered, BEFORE + TURNING + AFTER, settings=settings)


def filmed(flight: Trajectory, every: int) -> Recording:
    """Pose and wing angles at every so many instants."""
    seen = taken(flight, np.arange(0, len(flight.time), every))

    def angles(motion: WingMotion) -> WingAngles:
        return WingAngles(stroke=motion.stroke, deviation=motion.deviation, pitch=motion.pitch)

    q_WB = Rotation.from_quat(seen.q_WS[:, [1, 2, 3, 0]]).as_quat()[:, [3, 0, 1, 2]]
    return Recording(
        name="simulated", rate=FRAMES * seen.frequency, time=seen.time, source_sha256="", position_W=seen.position_W,
        q_WB=q_WB, stroke_plane_angle=0.0, left=angles(seen.left), right=angles(seen.right),
    )  # fmt: skip


def during(beats: Wingbeats, start: float, end: float) -> Wingbeats:
    """Wingbeats whose middle lies between two times [s]."""
    inside = np.flatnonzero((beats.middles > start) & (beats.middles < end))
    return wingbeats_between(beats, int(inside[0]), int(inside[-1]))


def turning(film: Recording, flight: Trajectory) -> Wingbeats:
    """The wingbeats that were steered."""
    return during(segment_wingbeats(film), BEFORE / flight.frequency, (BEFORE + TURNING) / flight.frequency)


def effects_of(fly: FlappingFly, flight: Trajectory) -> Factorial:
    """Torque of a wingbeat in mid-turn, every instant of it, body held."""
    steady = taken(flight, np.arange(400 * (BEFORE + 4), 400 * (BEFORE + 6)))
    beat = Wingbeats(reversals=np.array([BEFORE + 4.25, BEFORE + 5.25]) / flight.frequency)
    return Factorial(values=torques_by_wingbeat(fly, at_rest(steady), beat)[0])


def known_turn(steering: Steering, jitter: Jitter, rng: np.random.Generator) -> KnownTurn:
    """Fly, film, collapse, attribute."""
    fly, flight = flown_turn(steering)
    film = filmed(flight, 400 // FRAMES)
    noisy = jittered(film, segment_wingbeats(film), jitter, rng)
    return KnownTurn(
        steering=steering,
        turned=float(flight.yaw[-1] - flight.yaw[0]),
        truth=effects_of(fly, flight),
        flown=Factorial(values=turn_angles(fly, flight, MarchSettings(steps=400, estimate_error=False))),
        filmed=shares_of_collapsed(fly, collapsed_wingbeats(noisy, turning(noisy, flight)), draws=DRAWS),
    )


def known_turns(jitter: Jitter) -> list[KnownTurn]:
    """All five, with the jitter of a real flight."""
    return [known_turn(steering, jitter, np.random.default_rng([SEED, k])) for k, steering in enumerate(STEERINGS)]


# Ten wingbeats are few. How often do their intervals hold what each angle did?

FILMS = 25
WATCHED = ("paddling, 2 deg", "deviation, 8 deg")


def coverage(jitter: Jitter) -> tuple[int, int]:
    """Effects inside their intervals, and how many there were: new jitter on each film, three angles each."""
    held = 0
    for steering in (s for s in STEERINGS if s.name in WATCHED):
        fly, flight = flown_turn(steering)
        film, truth = filmed(flight, 400 // FRAMES), effects_of(fly, flight).shapley
        beats = segment_wingbeats(film)
        for k in range(FILMS):
            noisy = jittered(film, beats, jitter, np.random.default_rng([SEED, k, len(steering.name)]))
            found = shares_of_collapsed(fly, collapsed_wingbeats(noisy, turning(noisy, flight)), draws=100).effects
            held += sum(bool(found[a].low <= t <= found[a].high) for a, t in zip(ANGLES, truth, strict=True))
    return held, FILMS * len(WATCHED) * len(ANGLES)


# ## A level turn
#
# One of the recordings of *D. hydei* holds a turn of 60 deg in 15 wingbeats during which the fly hardly banks. Its
# wings' asymmetry is not all of the turn: in the straight flight before and after it right and left differ too, by a
# wrong zero of an angle or by what the fly does against some other torque. So the torque of quiet wingbeats is taken
# away, version by version, once of those before and once of those after, which do not agree with one another.

LEVEL_FLIGHT, SMALLEST_LEVEL = "20121009_S0003", 50 * deg
QUIET = {"before": (0, 14), "after": (40, 52)}  # wingbeats below 2.5 rad/s on either side


@dataclass(frozen=True, slots=True, kw_only=True)
class LevelTurn:
    """The turn's wingbeats and what they say."""

    first: int
    last: int
    angle: float  #: [rad]
    collapsed: CollapsedWingbeats
    shares: dict[str, TorqueShares]  #: as it is, less the quiet wingbeats before, less those after
    flown: Factorial  #: turn of the eight versions over the turn's wingbeats, flown anew, yaw alone free [rad]


def level_turn(flight: Flight) -> LevelTurn:
    """The largest complete turn of the flight."""
    trajectory = Replay().trajectory(flight)
    rate = wingbeat_mean(trajectory.angular_velocity_S, trajectory.time, flight.inner)[:, 2]
    angle = rate * flight.inner.durations
    found = [t for t in find_turns(rate, flight.inner) if t.complete and angle[t.first : t.last + 1].sum() > 0]
    turn = max(found, key=lambda t: angle[t.first : t.last + 1].sum())

    def collapsed(first: int, last: int) -> CollapsedWingbeats:
        return collapsed_wingbeats(flight.recording, wingbeats_between(flight.inner, first, last))

    beats = collapsed(turn.first, turn.last)
    quiet = {name: collapsed(*span) for name, span in QUIET.items()}
    begin, end = np.searchsorted(trajectory.time, flight.inner.reversals[[turn.first, turn.last + 1]])
    return LevelTurn(
        first=turn.first,
        last=turn.last,
        angle=float(angle[turn.first : turn.last + 1].sum()),
        collapsed=beats,
        shares={
            "as it is": shares_of_collapsed(FLY, beats, draws=DRAWS),
            **{
                f"less the quiet wingbeats {name}": shares_of_collapsed(FLY, beats, wingbeats, draws=DRAWS)
                for name, wingbeats in quiet.items()
            },
        },
        flown=Factorial(values=turn_angles(FLY, taken(trajectory, np.arange(begin, end)))),
    )  # fmt: skip


# ## Banked turns
#
# Both turning flights end in a burst in which the fly rolls by up to 80 rad/s. Torque and need change from wingbeat to
# wingbeat there, so that a mean says nothing. Instead the slope of supplied on needed yaw torque over all wingbeats,
# which is about 1 (`replayed_flights.py`), is shared: the part that mirror-symmetric wings on this body would supply,
# and the parts of the three angles. Wrong zeros and jitter leave the slope alone.


@dataclass(frozen=True, slots=True, kw_only=True)
class ByWingbeat:
    """One flight, wingbeat by wingbeat."""

    flight: Flight
    moving: FloatArray  #: (n, 8) body as it moved [N m]
    held: FloatArray  #: (n, 8) body held [N m]
    required: FloatArray  #: (n,) [N m]


def by_wingbeat(flight: Flight) -> ByWingbeat:
    """Replay all eight versions."""
    trajectory = Replay().trajectory(flight)
    return ByWingbeat(
        flight=flight,
        moving=torques_by_wingbeat(FLY, trajectory, flight.inner),
        held=torques_by_wingbeat(FLY, at_rest(trajectory), flight.inner),
        required=Replay().loads(flight)[1].torque[:, 2],
    )


def slopes(some: Iterable[ByWingbeat]) -> TorqueShares:
    """Shares of the slope, flights pooled."""
    some = list(some)
    return shares_of_slope([b.moving for b in some], [b.required for b in some])


# ## Patterns of yaw
#
# A laboratory publishes the wingbeat of the wing on one side and on the other at maximal yaw torque, from many flights
# of *D. hydei*; the amplitude is arbitrary and no scatter comes with it. Right is given the one, left the other. In
# place of an interval, other air, other zeros and another hinge show how far each part can move.


@dataclass(frozen=True, slots=True, kw_only=True)
class Pattern:
    """Yaw torque of the pattern, by angle, as it is and with every suspect."""

    total: float  #: [N m]
    effects: FloatArray  #: (3,) [N m]
    half_difference: FloatArray  #: (3,) root mean square of half of right less left [rad]
    suspects: dict[str, FloatArray]  #: effects of stroke, deviation, pitch and their total, (4,) [N m]


def pattern_stroke(table: NDArray[Any], name: str, harmonics: int = 12) -> FourierStroke:
    """One wing's wingbeat; the file's stroke and pitch count the other way round."""
    stroke, deviation, pitch = (table[f"{name}_{angle}_deg"] for angle in ("stroke", "dev", "pitch"))
    angles = np.stack([-stroke, deviation, 180 - pitch], axis=1) * deg
    return fourier_stroke(np.arange(len(table)) / len(table), angles, harmonics)


def moved_zero(stroke: FourierStroke, angle: int, by: float) -> FourierStroke:
    """Another zero of one angle."""
    cosine = stroke.cosine.copy()
    cosine[angle, 0] += by
    return replace(stroke, cosine=cosine)


def yaw_pattern() -> Pattern:
    """Both wings, as published and with every suspect."""
    path = DATA / "muijres_mean_wingbeats" / "maneuver_modulated.csv"
    table = np.genfromtxt(path, delimiter=",", names=True)[:-1]
    right, left = (pattern_stroke(table, f"yawmax_{way}") for way in ("fwd", "rwd"))
    plain = StrokeKinematics(frequency=189.0, left=left, right=right)
    found = {name: Factorial(values=torques_of_stroke(fly, k)) for name, fly, k in pattern_suspects(table, plain)}
    phase = np.arange(200) / 200
    apart = 0.5 * (right(phase).angles - left(phase).angles)
    as_is = found["as published"]
    return Pattern(
        total=float(as_is.total),
        effects=as_is.shapley,
        half_difference=np.sqrt(np.mean(apart**2, axis=0)),
        suspects={name: np.append(f.shapley, f.total) for name, f in found.items()},
    )


def pattern_suspects(
    table: NDArray[Any], plain: StrokeKinematics
) -> Iterator[tuple[str, FlappingFly, StrokeKinematics]]:
    """Everything that could be otherwise."""
    yield "as published", FLY, plain
    for name in COEFFICIENTS:
        yield f"coefficients {name}", replace(FLY, air=replace(FLY.air, coefficients=name)), plain
    yield "translation alone", replace(FLY, air=replace(FLY.air, terms=TERMS[:1])), plain
    for harmonics in (6, 20):
        right, left = (pattern_stroke(table, f"yawmax_{way}", harmonics) for way in ("fwd", "rwd"))
        yield f"{harmonics} harmonics", FLY, replace(plain, left=left, right=right)
    for angle, name in enumerate(ANGLES):
        for by in (-5, 5):
            left, right = (moved_zero(w, angle, by * deg) for w in (plain.left, plain.right))  # type: ignore[arg-type]
            yield f"zero of {name} {by:+d} deg", FLY, replace(plain, left=left, right=right)
    for way, forward in (("forward", 0.3e-3), ("back", -0.3e-3)):
        x, y, z = FLY.morphology.right_hinge
        yield (
            f"hinge 0.3 mm {way}",
            replace(FLY, morphology=replace(FLY.morphology, right_hinge=(x + forward, y, z))),
            plain,
        )


# ## What is found


@dataclass(frozen=True, slots=True, kw_only=True)
class Findings:
    """All that the note states."""

    known: list[KnownTurn]
    coverage: tuple[int, int]  #: effects inside their intervals, and all
    level: LevelTurn
    flights: list[ByWingbeat]
    slopes: dict[str, TorqueShares]
    pattern: Pattern


def findings() -> Findings:
    """Everything, in a minute or two."""
    both = [flight for flight in flights() if flight.recording.name != "20121128_S0003"]
    single = [by_wingbeat(flight) for flight in both]
    jitter = wingbeat_jitter(both[0].recording, both[0].inner)
    return Findings(
        known=known_turns(jitter),
        coverage=coverage(jitter),
        level=level_turn(next(f for f in both if f.recording.name == LEVEL_FLIGHT)),
        flights=single,
        slopes={**{b.flight.recording.name: slopes([b]) for b in single}, "both": slopes(single)},
        pattern=yaw_pattern(),
    )


def verdict(pitch: Interval) -> str:
    """Agreement with the review's 90 % in words."""
    if pitch.high < CLAIMED:
        return "fails: most of it, but less" if pitch.value > 0.5 else "fails"
    if pitch.low > 0.5:
        return "agrees" if pitch.low <= CLAIMED else "agrees: more than that"
    return "cannot be told"


def without(share: Interval) -> str:
    """Agreement with "this angle does not turn the fly" in words: its share is small, wherever in its interval."""
    if max(abs(share.low), abs(share.high)) < SMALL:
        return "agrees"
    return "fails" if share.low > SMALL or share.high < -SMALL else "cannot be told"


# ## The figure

RIGHT: dict[str, Any] = {"color": "#0b3954", "linewidth": 1.5, "label": "right"}
LEFT: dict[str, Any] = {"color": "#e08a00", "linewidth": 1.5, "linestyle": (0, (4, 1.5)), "label": "left"}
LOOK: dict[Angle, dict[str, Any]] = {
    "stroke": {"color": "#69add5", "marker": "s", "linestyle": (0, (1, 1))},
    "deviation": {"color": "#e08a00", "marker": "^", "linestyle": (0, (4, 1.5))},
    "pitch": {"color": "#0b3954", "marker": "o", "linestyle": "-"},
}


def draw(found: Findings) -> bytes:
    """Angles of the level turn, torque by angle along its flight, shares of all turns."""
    from flycontrol.report.style import in_house_style, new_figure

    with in_house_style():
        figure = new_figure(8.2)
        top, middle, bottom = figure.subfigures(3, 1, height_ratios=[1.0, 1.0, 1.7])
        for k, ax in enumerate(top.subplots(1, 3)):
            draw_angle(ax, found.level.collapsed, k)
        draw_flight(middle.subplots(), found)
        draw_shares(bottom.subplots(), found)
        return svg_of(figure)


def draw_angle(ax: "Axes", beats: CollapsedWingbeats, k: int) -> None:
    """Mean and spread of both wings."""
    for side, look in (("right", RIGHT), ("left", LEFT)):
        mean, spread = beats.mean(side)[:, k] / deg, beats.spread(side)[:, k] / deg
        ax.fill_between(beats.phase, mean - spread, mean + spread, color=look["color"], alpha=0.2, linewidth=0)
        ax.plot(beats.phase, mean, **look)
    ax.set(xlabel="phase [wingbeats]", ylabel=f"{ANGLES[k]} [deg]", xlim=(0, 1))
    if k == 0:
        ax.set_title(f"Level turn: mean and spread of {beats.count} wingbeats")
        ax.legend(loc="lower center")


def draw_flight(ax: "Axes", found: Findings) -> None:
    """Torque by angle, wingbeat by wingbeat, body held."""
    one = next(b for b in found.flights if b.flight.recording.name == LEVEL_FLIGHT)
    time = one.flight.inner.middles * 1e3
    effects = Factorial(values=one.held).shapley / nNm
    for k, angle in enumerate(ANGLES):
        look = {**LOOK[angle], "marker": "", "linewidth": 1.4}
        ax.plot(time, effects[:, k], label=angle, **look)
    ends = one.flight.inner.reversals[[found.level.first, found.level.last + 1]] * 1e3
    ax.axvspan(*ends, color="#e6edf1", zorder=0)
    ax.annotate("level turn", (ends.mean(), 6.6), ha="center", va="top")
    ax.annotate("burst", (446, 5.0), ha="right", va="center")
    for first, last in QUIET.values():
        span = one.flight.inner.reversals[[first, last + 1]] * 1e3
        ax.axvspan(*span, ymax=0.05, color="#d9d9d9", zorder=0)
        ax.annotate("quiet", (span.mean(), -4.15), ha="center", va="bottom", fontsize=7.5)
    ax.axhline(0, color="#7d7d7d", linewidth=0.7)
    ax.set(xlabel="time [ms]", ylabel="yaw torque by angle [nN m]", ylim=(-4.7, 8.8), xlim=(time[0], time[-1]))
    ax.set_title(f"{LEVEL_FLIGHT}, body held")
    ax.legend(loc="upper center", bbox_to_anchor=(0.2, 1.04), ncols=3)


def rows_of(found: Findings) -> list[tuple[str, TorqueShares]]:
    """Everything that has shares with intervals."""
    return [
        *((f"simulated: {k.steering.name}", k.filmed) for k in found.known),
        *((f"level turn, {name}", s) for name, s in found.level.shares.items()),
        *((f"slope on need, {name}", s) for name, s in found.slopes.items()),
    ]


def draw_shares(ax: "Axes", found: Findings) -> None:
    """Shapley's shares with intervals, one row a turn."""
    rows = rows_of(found)
    for row, (_, shares) in enumerate(rows):
        for k, angle in enumerate(ANGLES):
            share, y = shares.shapley[angle], row + 0.24 * (k - 1)
            look = {name: value for name, value in LOOK[angle].items() if name != "linestyle"}
            ax.plot(np.clip([share.low, share.high], -1.5, 2.5), [y, y], color=look["color"], linewidth=1.6)
            seen = share.value if -1.5 < share.value < 2.5 else np.nan
            ax.plot(seen, y, markersize=4.5, label=angle if row == 0 else None,
                    linestyle="none", **look)  # fmt: skip
    ax.axvline(CLAIMED, color="#c8323c", linewidth=1.0)
    ax.annotate("review: pitch, about 90 %", (CLAIMED, -0.95), (3, 0), textcoords="offset points", va="center",
                color="#c8323c")  # fmt: skip
    ax.axvline(0, color="#7d7d7d", linewidth=0.7)
    for row in (len(STEERINGS), len(STEERINGS) + len(found.level.shares)):
        ax.axhline(row - 0.5, color="#d9d9d9", linewidth=0.7)
    ax.set(yticks=range(len(rows)), yticklabels=[name for name, _ in rows], ylim=(len(rows) - 0.5, -1.3),
           xlim=(-1.75, 2.5), xlabel="share of the yaw torque, Shapley, 95 % (cut off at the frame)")  # fmt: skip
    ax.legend(loc="lower left", bbox_to_anchor=(0.0, 0.98), ncols=3, columnspacing=1.0)


# ## The answer


def answer(found: Findings) -> str:
    """What the note has found, in words."""
    pitch = [k for k in found.known if k.steering.by == ("pitch",)]
    as_is, less = found.level.shares["as it is"], found.level.shares["less the quiet wingbeats after"]
    both, (stroke, deviation, by_pitch) = found.slopes["both"], (e / pNm for e in found.pattern.effects)
    unbounded = [k.steering.name for k in found.known if not np.isfinite(k.filmed.shapley["pitch"].low)]
    return "\n\n".join([
        f"**The method finds pitch.** Turns of {' and '.join(f'{abs(k.turned) / deg:.0f}' for k in pitch)} deg by "
        "paddling and by biased hinges, filmed with the jitter of a tracker, are attributed to pitch by "
        f"{' and '.join(between(k.filmed.shapley['pitch']) for k in pitch)}; without jitter by 1, since only pitch "
        "differs there. " + (f"Of the turns by {' and by '.join(unbounded)} a film tells nothing: their torque is "
        "within the jitter, and their shares have no bounds. " if unbounded else "")
        + f"Intervals of ten wingbeats hold {found.coverage[0]} of {found.coverage[1]} effects.",
        f"**The level turn is mostly pitch**: {between(as_is.shapley['pitch'])} of the torque of the asymmetry as it "
        f"is measured, stroke {as_is.shapley['stroke'].value:.2f}, deviation {as_is.shapley['deviation'].value:.2f}. "
        "But right and left differ in straight flight too. Less the quiet wingbeats after the turn pitch has "
        f"{between(less.shapley['pitch'])} and deviation {less.shapley['deviation'].value:.2f}; less those before it "
        "nothing is left to share. The wings' yaw torque drifts through this flight by more than the turn needs, so "
        "that 90 % is neither shown nor excluded. Stroke alone makes "
        f"{between(as_is.alone['stroke'])} of the torque as measured and {between(less.alone['stroke'])} less the "
        "wingbeats after. Flown anew, this motion turns a fly by "
        f"{abs(found.level.flown.values[-1]) / deg:.0f} deg, not by {found.level.angle / deg:.0f}.",
        "**Banked turns do not show it.** What follows the needed yaw torque there is deviation, "
        f"{between(both.shapley['deviation'])}, rather than pitch, {between(both.shapley['pitch'])}; half of the slope "
        "comes from mirror-symmetric wings on a rolling body.",
        f"**The published pattern of maximal yaw has none here**: pitch {by_pitch:+.0f}, deviation {deviation:+.0f}, "
        f"stroke {stroke:+.0f} pN m cancel, at wings that differ by half a degree. Either its amplitude is the wrong "
        "thing to scale, or a quasi-steady wing misses it.",
    ])  # fmt: skip


# ## The note


def between(i: Interval, digits: int = 2) -> str:
    """A value with its interval."""
    if not np.isfinite(i.low):
        return f"{i.value:.{digits}f} (no bounds)"
    return f"{i.value:.{digits}f} ({i.low:.{digits}f} to {i.high:.{digits}f})"


def three(values: Mapping[Angle, Interval]) -> str:
    """Stroke, deviation, pitch as cells."""
    return " | ".join(between(values[angle]) for angle in ANGLES)


def plain_three(values: FloatArray) -> str:
    """Three numbers."""
    return ", ".join(f"{v:.2f}" for v in values)


def known_rows(found: Findings) -> Iterator[str]:
    """Simulated turns."""
    for k in found.known:
        torque, turn = k.truth, k.flown
        yield (
            f"| {k.steering.name} | {k.turned / deg:.1f} | {float(torque.total) / nNm:.2f} "
            f"| {plain_three(torque.shapley / torque.total)} | {float(torque.interaction / torque.total):+.3f} "
            f"| {plain_three(turn.shapley / turn.total)} | {three(k.filmed.shapley)} "
            f"| {between(k.filmed.interaction)} |"
        )


def level_rows(found: Findings) -> Iterator[str]:
    """The level turn and the slopes."""
    for name, s in [(f"level turn, {n}", s) for n, s in found.level.shares.items()] + [
        (f"slope, {n}", s) for n, s in found.slopes.items()
    ]:
        unit, digits = (nNm, 2) if name.startswith("level") else (1.0, 2)
        total, body = (Interval(**{e: getattr(i, e) / unit for e in ("value", "low", "high")})
                       for i in (s.total, s.symmetric))  # fmt: skip
        yield (
            f"| {name} | {s.wingbeats} | {between(body, digits)} | {between(total, digits)} | {three(s.shapley)} "
            f"| {plain_three(np.array([s.alone[a].value for a in ANGLES]))} "
            f"| {plain_three(np.array([s.all_but_one[a].value for a in ANGLES]))} | {s.interaction.value:+.3f} |"
        )


def claims(found: Findings) -> list[dict[str, str]]:
    """The review's claims, what is found here, and agreement in words."""
    real: dict[str, str] = {"where": "section 4, Fig. 4", "basis": "real data"}
    by_pitch = [k.filmed.shapley["pitch"] for k in found.known if k.steering.by == ("pitch",)]
    worst = min(share.value for share in by_pitch)
    *parts, pitch = found.pattern.effects
    against = float(sum(parts) / pitch)

    def row(claim: str, published: str, ours: str, agreement: str) -> dict[str, str]:
        return {"claim": claim, "published": published, "ours": ours, "agreement": agreement, **real}

    return [
        {
            **row(
                "symmetrising finds the angle that turns the fly: turns made by pitch, filmed with a tracker's jitter",
                "it does", "pitch " + " and ".join(between(share) for share in by_pitch),
                "agrees" if worst >= CLAIMED else "fails",
            ),
            "basis": "simulated",
        },
        *(
            {
                **row(
                    f"symmetrising finds the angle that turns the fly: a turn made by {k.steering.name}, so filmed",
                    "it does",
                    ", ".join(f"{angle} {between(share)}" for angle, share in k.filmed.shapley.items()), found_by(k),
                ),
                "basis": "simulated",
            }
            for k in found.known if k.steering.by in (("stroke",), ("deviation",))
        ),
        *(
            row(f"pitch makes the yaw torque: a level turn of 60 deg, {name}", "about 0.9", between(s.shapley["pitch"]),
                verdict(s.shapley["pitch"]))
            for name, s in found.level.shares.items()
        ),
        *(
            row(f"differences in stroke alone do not turn the fly: a level turn of 60 deg, {name}", "no turn",
                f"{between(s.alone['stroke'])} of the torque", without(s.alone["stroke"]))
            for name, s in found.level.shares.items()
        ),
        *(
            row(f"pitch makes the yaw torque: share of the slope on need, banked turns, {name}", "about 0.9",
                between(s.shapley["pitch"]), verdict(s.shapley["pitch"]))
            for name, s in found.slopes.items()
        ),
        row("pitch makes the yaw torque: published wingbeats of maximal yaw", "about 0.9",
            f"stroke and deviation add {against:+.2f} of the pitch's torque to it",
            "roughly" if abs(against) < 0.3 else "fails: nothing is left of the pitch's torque"),
    ]  # fmt: skip


def found_by(known: KnownTurn) -> str:
    """Whether a film tells that the angle of the steering turned the fly."""
    (angle,) = known.steering.by
    share = known.filmed.shapley[angle]
    if not np.isfinite(share.low):
        return "fails: the torque of the turn is too small beside the jitter for any bound"
    others = [other for name, other in known.filmed.shapley.items() if name != angle]
    return "agrees" if share.low > max(other.high for other in others) else "cannot be told: the intervals overlap"


def claim_rows(found: Findings) -> Iterator[str]:
    """The same as rows of a table."""
    for c in claims(found):
        yield f"| {c['claim']} | {c['published']} | {c['ours']} | {c['agreement']} |"


def pattern_rows(found: Findings) -> Iterator[str]:
    """Suspects."""
    for name, effects in found.pattern.suspects.items():
        yield f"| {name} | " + " | ".join(f"{e / pNm:.0f}" for e in effects) + " |"


def as_text(found: Findings) -> str:
    """The note."""
    level, pattern = found.level, found.pattern
    flown, apart = level.flown, np.sqrt(np.mean(level.collapsed.asymmetry.mean(axis=0) ** 2, axis=0))
    return "\n".join([
        "# Which angle turns the fly?\n",
        "The review: small changes in wing pitch make about 90 % of the yaw torque of a turn, stroke alone does not "
        "turn the fly. Wings are given the mean of both, angle by angle: eight versions, a full factorial. Shapley's "
        "shares are means over all orders and add up to 1; intervals are 95 %, from blocks of wingbeats. Made by "
        f"[analyses/{NAME}.py](../../analyses/{NAME}.py).\n",
        answer(found) + "\n",
        "| claim | review | here | agreement |",
        "|---|---|---|---|",
        *claim_rows(found),
        "\n## Simulated turns\n",
        "Ten wingbeats of steering, yaw alone free. Shares of stroke, deviation, pitch: in the torque of the motion "
        "as it was, in the turn angle of the eight versions flown anew, and in films with a real tracker's jitter.\n",
        "| steered by | turn [deg] | torque [nN m] | shares | interaction | shares of the turn angle | film: stroke | "
        "deviation | pitch | interaction |",
        "|---|---|---|---|---|---|---|---|---|---|",
        *known_rows(found),
        f"\nWith new jitter on {FILMS} films each of {' and '.join(WATCHED)}, {found.coverage[0]} of "
        f"{found.coverage[1]} effects lie inside their 95 % intervals.",
        "\n## Measured turns\n",
        f"*D. hydei*: wingbeats {level.first} to {level.last} of {LEVEL_FLIGHT} turn by {level.angle / deg:.0f} deg, "
        f"nearly level. Right and left differ by {plain_three(apart / deg)} deg (stroke, deviation, pitch; rms of half "
        "of the mean difference). Mean wingbeat on a held body, torque in nN m. Below it the slope of supplied on "
        "needed yaw torque over all wingbeats of the banked flights, body as it moved.\n",
        "| | wingbeats | symmetric wings | all asymmetries | stroke | deviation | pitch | alone | all but one "
        "| interaction |",
        "|---|---|---|---|---|---|---|---|---|---|",
        *level_rows(found),
        f"\nFlown anew with yaw alone free, from rest, the level turn's wing motion turns the fly by "
        f"{flown.values[-1] / deg:.0f} deg; with only stroke, deviation or pitch kept by "
        f"{plain_three(flown.alone / deg)} deg, with both wings alike by {flown.values[0] / deg:.1f}.\n",
        "## Published patterns of maximal yaw\n",
        f"Right and left differ by {plain_three(pattern.half_difference / deg)} deg (stroke, deviation, pitch; rms of "
        "half of it). Their torques cancel to within what air, zeros and hinge leave open, so that no share can be "
        "stated. Torque by angle and of all three [pN m], amplitude arbitrary:\n",
        "| changed | stroke | deviation | pitch | all |",
        "|---|---|---|---|---|",
        *pattern_rows(found),
        f"\n![Angles of the level turn, torque by angle, shares]({NAME}.svg)\n",
    ])  # fmt: skip


def interval_numbers(i: Interval) -> list[float | None]:
    """Value, low, high; no number where there is no bound."""
    return [float(f"{v:.5g}") if np.isfinite(v) else None for v in (i.value, i.low, i.high)]


def share_numbers(s: TorqueShares) -> dict[str, Any]:
    """Everything about one turn."""
    parts = {
        name: {angle: interval_numbers(i) for angle, i in getattr(s, name).items()}
        for name in ("shapley", "alone", "all_but_one", "effects")
    }
    return {
        "wingbeats": s.wingbeats, "total": interval_numbers(s.total), "symmetric": interval_numbers(s.symmetric),
        "interaction": interval_numbers(s.interaction), "status": s.status, **parts,
    }  # fmt: skip


def as_numbers(found: Findings) -> str:
    """The numbers as JSON: value, low, high; torques in N m, angles in rad."""

    def numbers(values: FloatArray) -> list[float]:
        return [float(f"{v:.5g}") for v in values]

    return json.dumps({
        "claims": claims(found),
        "effects_inside_their_intervals": list(found.coverage),
        "simulated": {k.steering.name: {
            "turn_rad": float(f"{k.turned:.5g}"),
            "torque_shares": numbers(k.truth.shapley / k.truth.total),
            "interaction": float(f"{k.truth.interaction / k.truth.total:.4g}"),
            "turn_shares": numbers(k.flown.shapley / k.flown.total),
            "filmed": share_numbers(k.filmed),
        } for k in found.known},
        "level_turn": {
            "angle_rad": float(f"{found.level.angle:.5g}"),
            "versions_flown_rad": numbers(found.level.flown.values),
            "shares": {name: share_numbers(s) for name, s in found.level.shares.items()},
        },
        "slope_on_need": {name: share_numbers(s) for name, s in found.slopes.items()},
        "yaw_pattern": {
            "half_difference_rad": numbers(found.pattern.half_difference),
            "stroke_deviation_pitch_total_N_m": {n: numbers(v) for n, v in found.pattern.suspects.items()},
        },
    }, indent=1) + "\n"  # fmt: skip


def main(folder: Path = REPORTS / NAME) -> Findings:
    """Find, draw and write."""
    found = findings()
    text = as_text(found)
    files = {f"{NAME}.md": text, f"{NAME}.json": as_numbers(found), f"{NAME}.svg": draw(found)}
    write_files_atomically(folder, files)
    print(text)
    return found


if __name__ == "__main__":
    main(folder_named(__file__, __doc__, REPORTS / NAME))
