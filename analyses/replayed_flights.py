"""Do the wings of a filmed fly supply the forces and torques that its motion needs?

Run with `python analyses/replayed_flights.py [FOLDER]`; the recordings are looked for in $FLYCONTROL_DATA, else in
../shared/data. Table, figure and numbers go to reports/replayed_flights unless a folder is given.
"""

import io
import json
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from _by_hand import DATA, REPORTS, folder_named, measured
from _opened import opened

from flycontrol.flight.aerodynamics import Load
from flycontrol.flight.flapping_fly import FlappingFly
from flycontrol.flight.load_balance import LoadBalance, load_balance, wingbeat_balance, world_balance
from flycontrol.flight.replay import ReplayBandwidth, inner_wingbeats, replayed
from flycontrol.identify.agreement import Agreement, agreement
from flycontrol.io.morphology import read_morphology_table
from flycontrol.io.recordings import read_recording
from flycontrol.jobs.files import write_files_atomically
from flycontrol.model.morphology import morphology_from_table
from flycontrol.model.recording import Recording, WingAngles
from flycontrol.model.trajectory import Trajectory
from flycontrol.model.wingbeats import Wingbeats, segment_wingbeats
from flycontrol.units import deg, mm

NAME = "replayed_flights"
FLIGHTS = ("20121009_S0003", "20121120_S0001", "20121128_S0003")
WORDS = ("turning", "turning", "nearly straight")
AXES = ("roll", "pitch", "yaw")
nNm = 1e-9

# ## The question
#
# Three free flights of *D. hydei* are filmed with body and both wings. Prescribe both motions: the air (quasi-steady,
# all terms) and the wings' own inertia supply a force and a torque. Newton and Euler say what the body needs,
#
#     m (v' + w x v - g)    and    I w' + w x I w,
#
# with the full inertia tensor: the body hangs nose up, so that roll and yaw share a product of inertia. The body's own
# drag is left out: even with a drag coefficient of 2 on 3 mm^2 it would be 1 % of the weight at the usual 0.2 m/s and
# 6 % at the highest speed, 0.54 m/s.

FLY = FlappingFly(
    morphology=morphology_from_table(read_morphology_table("drosophila_hydei"), "Drosophila hydei", 189.0)
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Flight:
    """One recording, its wingbeats, and those that the smoother leaves whole."""

    recording: Recording
    beats: Wingbeats
    inner: Wingbeats


def flights() -> list[Flight]:
    """All three."""
    measured(DATA, "muijres_freeflight")
    folder = DATA / "muijres_freeflight"
    return [flight_of(read_recording(folder / f"{name}.txt", "muijres_freeflight")) for name in FLIGHTS]


def flight_of(recording: Recording) -> Flight:
    """Wingbeats of a recording."""
    beats = segment_wingbeats(recording)
    return Flight(recording=recording, beats=beats, inner=inner_wingbeats(beats))


# ## A replay
#
# Wings smoothed to 4.5 wingbeat frequencies, the body to 0.6. Means over each wingbeat are compared. Everything in
# which another replay may differ is a field, so that one thing at a time can be changed elsewhere.


def same(thing: Any) -> Any:
    """Nothing changed."""
    return thing


def wingbeat_means(balance: LoadBalance, trajectory: Trajectory, flight: Flight) -> tuple[Load, Load]:
    """Supplied and required, wingbeat by wingbeat."""
    means = wingbeat_balance(balance, trajectory, flight.inner)
    return means.supplied, means.required


@dataclass(frozen=True, slots=True, kw_only=True)
class Replay:
    """How a flight is replayed."""

    fly: FlappingFly = FLY
    bandwidth: ReplayBandwidth = field(default_factory=ReplayBandwidth)
    reading: Callable[[Recording], Recording] = same  #: how the file is read
    seen: Callable[[Trajectory], Trajectory] = same  #: the body motion that the wings meet the air with
    compared: Callable[[LoadBalance, Trajectory, Flight], tuple[Load, Load]] = wingbeat_means

    def trajectory(self, flight: Flight) -> Trajectory:
        """Smooth motion of body and wings."""
        return replayed(self.reading(flight.recording), flight.beats, self.bandwidth)

    def loads(self, flight: Flight) -> tuple[Load, Load]:
        """Supplied and required, wingbeat by wingbeat, frame S."""
        trajectory = self.trajectory(flight)
        balance = load_balance(self.fly, trajectory)
        if self.seen is not same:
            balance = replace(load_balance(self.fly, self.seen(trajectory)), required=balance.required)
        return self.compared(balance, trajectory, flight)


def reread(change: Callable[[WingAngles, float], WingAngles]) -> Callable[[Recording], Recording]:
    """Read each wing's angles through `change`, which is told the side: +1 right, -1 left."""

    def read(recording: Recording) -> Recording:
        assert recording.left is not None
        assert recording.right is not None
        return replace(recording, left=change(recording.left, -1.0), right=change(recording.right, 1.0))

    return read


# ## What is compared
#
# Correlation over wingbeats and two slopes, each with a 95 % interval from blocks of five wingbeats. The wings' angles
# carry the noise, the body's motion hardly any: the slope of supply on need is 1 if all is right, whatever the noise,
# and that of need on supply comes out too low. Means over a flight are compared apart, since a wrong zero of an angle
# or a wrong place of the hinge moves them first.


@dataclass(frozen=True, slots=True, kw_only=True)
class AsIs:
    """One flight, or all of them."""

    name: str
    wingbeats: int
    lift: float  #: mean supplied force along the world's vertical over the weight
    lift_over_need: float  #: the same over what the motion needs
    forces: list[Agreement]  #: x, y, z of S
    torques: list[Agreement]  #: roll, pitch, yaw
    spread: np.ndarray  #: (2, 3) standard deviation of supplied and required torque [N m]
    bias: np.ndarray  #: (3,) mean of supplied less required torque [N m]
    hinge_shift: float  #: forward, that would take the mean pitching torque away [m]
    zero_gap: float  #: right less left zero of pitch that would take the mean yaw torque away [rad]


def as_is(some: list[Flight], name: str) -> AsIs:
    """Forces and torques of some flights together."""
    pairs = [Replay().loads(flight) for flight in some]
    count = sum(flight.inner.count for flight in some)
    lift, needed = np.sum([_lift(flight) for flight in some], axis=0) / count
    bias = np.concatenate([s.torque - r.torque for s, r in pairs]).mean(axis=0)
    spread = [np.concatenate([p[k].torque - p[k].torque.mean(axis=0) for p in pairs]).std(axis=0) for k in (0, 1)]
    return AsIs(
        name=name,
        wingbeats=count,
        lift=lift,
        lift_over_need=lift / needed,
        forces=[agreement([s.force[:, k] for s, _ in pairs], [r.force[:, k] for _, r in pairs]) for k in range(3)],
        torques=torque_agreements(pairs),
        spread=np.array(spread),
        bias=bias,
        hinge_shift=bias[1] / np.concatenate([s.force for s, _ in pairs]).mean(axis=0)[2],
        zero_gap=-bias[2] / _yaw_of_a_zero_gap(some),
    )


def torque_agreements(pairs: list[tuple[Load, Load]]) -> list[Agreement]:
    """Roll, pitch, yaw, flights pooled."""
    return [agreement([s.torque[:, k] for s, _ in pairs], [r.torque[:, k] for _, r in pairs]) for k in range(3)]


def _lift(flight: Flight) -> tuple[float, float]:
    """Supplied and needed upward force over the weight, summed over wingbeats."""
    trajectory = Replay().trajectory(flight)
    world = wingbeat_balance(world_balance(load_balance(FLY, trajectory), trajectory), trajectory, flight.inner)
    weight = FLY.morphology.weight
    return float(world.supplied.force[:, 2].sum() / weight), float(world.required.force[:, 2].sum() / weight)


def _yaw_of_a_zero_gap(some: list[Flight]) -> float:
    """Mean yaw torque for a unit of difference between the zeros of right and left pitch [N m/rad]."""
    gap = 2 * deg

    def mean_yaw(apart: float) -> float:
        moved = Replay(reading=reread(lambda wing, side: replace(wing, pitch=wing.pitch + side * apart / 2)))
        return float(np.concatenate([moved.loads(flight)[0].torque[:, 2] for flight in some]).mean())

    return (mean_yaw(gap / 2) - mean_yaw(-gap / 2)) / gap


# ## The figure


def draw(all_flights: list[Flight]) -> bytes:
    """Torques and normal force of each flight, one column a flight."""
    from flycontrol.report.style import in_house_style, new_figure

    with in_house_style():
        figure = new_figure(6.4)
        panels = figure.subplots(4, 3, sharey="row", sharex="col")
        for column, flight, words in zip(panels.T, all_flights, WORDS, strict=True):
            draw_flight(column, flight)
            column[0].set_title(f"{flight.recording.name}\n{words}", fontsize=8)
        for ax, label in zip(panels[:, 0], (*(f"{a} torque, less\nits mean [nN m]" for a in AXES),
                                            "force up the\nbody / weight"), strict=True):  # fmt: skip
            ax.set_ylabel(label)
        figure.legend(*panels[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=2)
        return svg_of(figure)


def draw_flight(column: np.ndarray, flight: Flight) -> None:
    """Supply and need of one flight; torques less their means."""
    (supplied, required), time = Replay().loads(flight), flight.inner.middles * 1e3
    needs = {"color": "#0b3954", "linewidth": 1.5, "label": "needed by the body's motion"}
    supplies = {"color": "#e08a00", "linewidth": 1.2, "linestyle": (0, (4, 1.5)), "label": "supplied by the wings"}
    for load, look in ((required, needs), (supplied, supplies)):
        for axis in range(3):
            column[axis].plot(time, (load.torque[:, axis] - load.torque[:, axis].mean()) / nNm, **look)
        column[3].plot(time, -load.force[:, 2] / FLY.morphology.weight, **look)
    column[3].set_xlabel("time [ms]")


def svg_of(figure: Any) -> bytes:
    """The bytes of a figure."""
    buffer = io.BytesIO()
    figure.savefig(buffer, format="svg", metadata={"Date": None})
    return buffer.getvalue()


# ## The answer
#
# **The force along the stroke plane's normal follows Newton** (correlation 0.88) but is too small and moves too little:
# the wings supply 0.89, 0.77 and 0.69 of the vertical force that the motion needs; the slope is 0.63 (0.50 to 0.68).
#
# **Torques are right in size**: the slopes of supply on need are 1.00 (0.31 to 1.45) in roll, 1.04 (0.70 to 1.33) in
# pitch and 1.08 (0.86 to 1.49) in yaw, with correlations of 0.55, 0.71 and 0.67. Most of it is one burst of some ten
# wingbeats in each turning flight: the figure shows supply and need rise and fall together there. On top of it the
# supply scatters by 1 to 2 nN m that no body needs; `noise_ceiling_of_a_replay.py` asks where that comes from, and
# `why_crude_replays_miss_yaw.py` what earlier replays did otherwise. The nearly straight flight has little yaw, and
# what its wings say of it is wrong: -0.40 (-0.65 to -0.10). In the first flight the yaw supply drifts from 1.4 to -1.6
# nN m (means over nine wingbeats) within 0.3 s while the fly flies straight on.
#
# **Means are off**: a pitching torque of -5.8 to -7.4 nN m that the body does not need, which a hinge 0.4 to 0.5 mm
# further forward would balance (its place is scaled from another species), and up to 1.8 nN m of yaw, which zeros of
# left and right pitch 3 deg apart would balance. Forces in the stroke plane hardly agree; see
# `mass_seen_by_the_wings.py`.


def estimate(e: Any, digits: int = 2) -> str:
    """A value with its interval."""
    return f"{e.value:.{digits}f} ({e.low:.{digits}f} to {e.high:.{digits}f})"


def as_text(results: list[AsIs]) -> str:
    """The numbers as a page of Markdown."""
    lines = [
        "# Replayed flights\n",
        "Three free flights with wings and body prescribed: means over wingbeats of what air (all terms) and wing "
        "inertia supply against what the body needs by Newton and Euler. Intervals are 95 %, from blocks of five "
        "wingbeats. Wings are smoothed to 4.5, the body to 0.6 wingbeat frequencies. Nothing is fitted.\n",
        "| | " + " | ".join(r.name for r in results) + " |",
        "|---|" + "---|" * len(results),
        _row("wingbeats", [str(r.wingbeats) for r in results]),
        _row("vertical force over weight", [f"{r.lift:.2f}" for r in results]),
        _row("vertical force over what the motion needs", [f"{r.lift_over_need:.2f}" for r in results]),
    ]
    for k, name in enumerate(("forward", "sideways", "normal to the stroke plane")):
        lines.append(_row(f"force {name}: correlation", [estimate(r.forces[k].correlation) for r in results]))
        lines.append(_row("slope of supply on need", [estimate(r.forces[k].slope) for r in results]))
    for k, name in enumerate(AXES):
        lines.append(_row(f"{name} torque: correlation", [estimate(r.torques[k].correlation) for r in results]))
        lines.append(_row("slope of supply on need", [estimate(r.torques[k].slope) for r in results]))
        lines.append(_row("slope of need on supply", [estimate(r.torques[k].slope_of_required) for r in results]))
    for label, values in (
        ("spread of supplied torque, roll, pitch, yaw [nN m]", [r.spread[0] / nNm for r in results]),
        ("spread of needed torque [nN m]", [r.spread[1] / nNm for r in results]),
        ("mean supplied less needed [nN m]", [r.bias / nNm for r in results]),
    ):
        lines.append(_row(label, [", ".join(f"{x:.2f}" for x in value) for value in values]))
    shifts = [f"{r.hinge_shift / mm:.2f}" for r in results]
    gaps = [f"{-r.zero_gap / deg:.1f}" for r in results]
    lines.append(_row("a hinge further forward by so much balances mean pitch [mm]", shifts))
    lines.append(_row("left less right zero of pitch that balances mean yaw [deg]", gaps))
    return (
        "\n".join(lines) + f"\n\n![Torques less their means, and normal force, supplied and needed]({NAME}.svg)\n\n"
        "Each torque is drawn less its mean over the flight; the table says by how much supply and need are apart in "
        "the mean.\n"
    )


def _row(label: str, cells: Iterable[str]) -> str:
    return f"| {label} | " + " | ".join(cells) + " |"


def numbers_of(a: Agreement) -> dict[str, list[float]]:
    """Value and interval of each measure."""
    measures = (("correlation", a.correlation), ("slope", a.slope), ("slope_of_need", a.slope_of_required))
    return {name: [round(v, 4) for v in (e.value, e.low, e.high)] for name, e in measures}


CLOSE, ROUGH = 0.10, 0.25


def graded(off: float) -> str:
    """In words: within 10 %, within 25 %, or not."""
    return "agrees" if abs(off) <= CLOSE else "roughly" if abs(off) <= ROUGH else "fails"


def claims(results: list[AsIs]) -> list[dict[str, str]]:
    """What the review says, what comes out here, and whether they agree."""
    *singles, together = results
    yaw, flights = together.torques[2], [r.torques[2].correlation.value for r in singles]
    right = yaw.slope.low < 1 < yaw.slope.high and yaw.correlation.low > 0
    wrong = sum(correlation < 0 for correlation in flights)
    return [
        {"claim": "quasi-steady forces account for the average ones with an accuracy of about 90 %",
         "published": "about 0.9",
         "ours": f"{together.lift_over_need:.2f} of the vertical force that three flights need "
                 f"({', '.join(f'{r.lift_over_need:.2f}' for r in singles)})",
         "agreement": graded(together.lift_over_need - 1), "where": "section 3", "basis": "real data"},
        {"claim": "measured wing motion and the rigid-body equations give the torque that turns the body",
         "published": "no number",
         "ours": f"yaw torque supplied on needed: slope {estimate(yaw.slope)}, correlation "
                 f"{estimate(yaw.correlation)}; flight by flight {', '.join(f'{one:.2f}' for one in flights)}",
         "agreement": "fails" if not right else f"roughly: wrong in {wrong} of {len(singles)} flights" if wrong else
                      "agrees",
         "where": "section 3, Fig. 3c", "basis": "real data"},
    ]  # fmt: skip


def as_numbers(results: list[AsIs]) -> str:
    """The numbers as JSON, units in the names."""
    rows = [
        {
            "flight": r.name,
            "wingbeats": r.wingbeats,
            "vertical_force_over_weight": round(r.lift, 4),
            "vertical_force_over_needed": round(r.lift_over_need, 4),
            "force": dict(zip("xyz", map(numbers_of, r.forces), strict=True)),
            "torque": dict(zip(AXES, map(numbers_of, r.torques), strict=True)),
            "mean_gap_N_m": [float(f"{b:.4g}") for b in r.bias],
            "balancing_hinge_shift_m": float(f"{r.hinge_shift:.4g}"),
            "balancing_zero_gap_rad": float(f"{r.zero_gap:.4g}"),
        }
        for r in results
    ]
    return json.dumps({"claims": claims(results), "flights": rows}, indent=1) + "\n"


def main(folder: Path = REPORTS / NAME) -> list[AsIs]:
    """Replay, compare, draw and write."""
    all_flights = flights()
    results = [as_is([flight], flight.recording.name) for flight in all_flights] + [as_is(all_flights, "all")]
    text = opened(__file__, as_text(results))
    files = {f"{NAME}.md": text, f"{NAME}.json": as_numbers(results), f"{NAME}.svg": draw(all_flights)}
    write_files_atomically(folder, files)
    print(text)
    return results


if __name__ == "__main__":
    main(folder_named(__file__, __doc__, REPORTS / NAME))
