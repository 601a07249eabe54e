"""How many steps a wingbeat, and how many blades a wing, does a simulated flight need?

Run with `python analyses/how_many_steps.py [FOLDER]`. Table, figure and numbers go to reports/how_many_steps unless a
folder is given.
"""

import io
import json
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from _by_hand import REPORTS, folder_named
from _opened import opened

from flycontrol.flight.flapping_fly import FlappingFly
from flycontrol.flight.quasi_steady import QuasiSteadyModel
from flycontrol.flight.settings import MarchSettings
from flycontrol.flight.simulate import simulate_flight
from flycontrol.flight.state_vector import level_start
from flycontrol.flight.wing_loads import loads_along
from flycontrol.io.morphology import read_morphology_table
from flycontrol.jobs.files import write_files_atomically
from flycontrol.model.morphology import morphology_from_table
from flycontrol.model.stroke_kinematics import StrokeKinematics
from flycontrol.model.trajectory import Trajectory
from flycontrol.model.wing_stroke import BermanWangStroke
from flycontrol.units import deg

if TYPE_CHECKING:
    from matplotlib.axes import Axes

NAME = "how_many_steps"
FOLDER = REPORTS / NAME
FREQUENCY = 220.0  # [1/s]
STEPS = (20, 28, 40, 56, 80, 112, 160, 200, 280, 400, 560, 800, 1120, 1600)
EXACT_STEPS = 12800
BLADES = (1, 2, 3, 4, 5, 6, 8, 10, 12, 16, 20, 24, 32, 48, 64)
EXACT_BLADES = 400
AT_INSTANTS = 1600  # of a wingbeat at which loads are compared
SPIN = np.array([30.0, -20.0, 50.0])  # [rad/s] so that no blade is symmetric to another

# ## The question
#
# Runge-Kutta's classical step errs with the fourth power of its length where motion is smooth. Blade elements are not:
# lift and drag depend on |sin alpha| and on |u| u, and the dissipative torque on |w| w, so that the second and third
# derivatives jump whenever a blade's velocity passes through the wing's plane or its axis. And along the span: a blade
# on one side of such a point has lift of the other sign, so that quadrature by a few Gauss nodes is not as good there
# as it is elsewhere. A free, turning fly with a lopsided stroke has no symmetry for errors to cancel in.


def wing(paddling: float, lead: float, amplitude: float) -> BermanWangStroke:
    """A stroke that uses every angle."""
    return BermanWangStroke(
        stroke_amplitude=amplitude, stroke_shape=0.7, stroke_offset=-3 * deg, pitch_shape=2.0, pitch_lead=lead,
        pitch_offset=paddling, deviation_amplitude=8 * deg, deviation_phase=0.4,
    )  # fmt: skip


STROKE = StrokeKinematics(
    frequency=FREQUENCY, left=wing(-4 * deg, 5 * deg, 70 * deg), right=wing(5 * deg, 12 * deg, 66 * deg)
)
START = replace(level_start(STROKE, (0.3, -0.2, 0.1)), angular_velocity_S=SPIN)
MORPHOLOGY = morphology_from_table(read_morphology_table(), "Drosophila melanogaster", FREQUENCY)
TERMS = {
    "all terms": ("translational", "rotational", "added_mass", "dissipative"),
    "without lift and drag": ("rotational", "added_mass", "dissipative"),
    "added mass alone": ("added_mass",),
}


def fly(terms: str = "all terms", blades: int = 6) -> FlappingFly:
    """The published fly in the air of some terms."""
    return FlappingFly(morphology=MORPHOLOGY, air=QuasiSteadyModel(nodes=blades, terms=TERMS[terms]))


def flown(own: FlappingFly, steps: int, wingbeats: int = 1) -> Trajectory:
    """So many wingbeats from the same start."""
    settings = MarchSettings(steps=steps, samples=1, tolerance=np.inf)
    return simulate_flight(own, STROKE, wingbeats, start=START, settings=settings)


# ## Steps
#
# The attitude after one wingbeat against that by 12,800 steps, and what the run itself estimates from half as many
# steps, divided by 15 as if the order were four.


@dataclass(frozen=True, slots=True, kw_only=True)
class StepRow:
    """One flight of one wingbeat."""

    terms: str
    steps: int
    error: float  #: of attitude [rad]
    estimate: float  #: of the same, by the run itself [rad]
    yaw_rate_error: float  #: of the angular velocity [rad/s]


def attitude_apart(one: Trajectory, other: Trajectory) -> float:
    """Angle between the last attitudes [rad]."""
    return 2 * float(np.linalg.norm(one.q_WS[-1] - other.q_WS[-1]))


@cache
def step_rows() -> tuple[StepRow, ...]:
    """All terms, and fewer and fewer kinks."""
    return tuple(_step_row(terms, steps) for terms in TERMS for steps in STEPS)


def _step_row(terms: str, steps: int) -> StepRow:
    exact, found = _exact(terms), flown(fly(terms), steps)
    assert found.step_error is not None
    return StepRow(
        terms=terms,
        steps=steps,
        error=attitude_apart(found, exact),
        estimate=found.step_error.attitude,
        yaw_rate_error=float(np.linalg.norm(found.angular_velocity_S[-1] - exact.angular_velocity_S[-1])),
    )


@cache
def _exact(terms: str) -> Trajectory:
    return flown(fly(terms), EXACT_STEPS)


def rows_of(terms: str) -> list[StepRow]:
    """Those of one choice of terms."""
    return [row for row in step_rows() if row.terms == terms]


def order(terms: str, fewest: int = 80) -> float:
    """Slope of log error over log steps, from `fewest` steps on, down to where rounding takes over."""
    rows = [row for row in rows_of(terms) if row.steps >= fewest and row.error > 1e-13]
    return -float(np.polyfit(np.log([row.steps for row in rows]), np.log([row.error for row in rows]), 1)[0])


def trust() -> tuple[float, float]:
    """Least and largest error over estimate, all terms, from 80 steps on."""
    ratios = [row.error / row.estimate for row in rows_of("all terms") if row.steps >= 80]
    return min(ratios), max(ratios)


# ## Blades
#
# Loads of both wings along the same wingbeat, and the attitude at its end when flown with so many blades. Two
# ways to choose them: Gauss nodes for the chord's own distribution, as in the simulator, and blades of even width.


@dataclass(frozen=True, slots=True, kw_only=True)
class BladeRow:
    """So many blades a wing against many."""

    blades: int
    worst_force: float  #: at any instant, over the weight
    mean_force: float  #: of the wingbeat's mean, over the weight
    mean_torque: float  #: over weight times wing length
    even_mean_force: float  #: of blades of even width
    attitude: float  #: after one flown wingbeat [rad]


@cache
def blade_rows() -> tuple[BladeRow, ...]:
    """Against 400 Gauss nodes."""
    along = simulate_flight(
        fly(), STROKE, 1, start=START, settings=MarchSettings(steps=AT_INSTANTS, samples=AT_INSTANTS)
    )
    exact = loads_along(fly(blades=EXACT_BLADES), along).total
    end = flown(fly(blades=EXACT_BLADES), 800)
    rows: list[BladeRow] = []
    for count in BLADES:
        few = loads_along(fly(blades=count), along).total
        force = (few.force - exact.force)[:-1] / MORPHOLOGY.weight
        torque = (few.torque - exact.torque)[:-1] / (MORPHOLOGY.weight * MORPHOLOGY.wing_length)
        rows.append(
            BladeRow(
                blades=count,
                worst_force=float(np.max(np.linalg.norm(force, axis=1))),
                mean_force=float(np.linalg.norm(force.mean(axis=0))),
                mean_torque=float(np.linalg.norm(torque.mean(axis=0))),
                even_mean_force=even_blades_miss(count, along),
                attitude=attitude_apart(flown(fly(blades=count), 800), end),
            )
        )
    return tuple(rows)


def even_blades_miss(count: int, along: Trajectory) -> float:
    """Mean force that blades of even width miss, translational term, over the weight."""
    from flycontrol.flight.aerodynamics import BodyMotion, flight_loads
    from flycontrol.flight.blades import BladeElements

    body = BodyMotion(velocity=along.velocity_S[:-1], angular_velocity=along.angular_velocity_S[:-1])
    left, right = (_without_end(along, side) for side in ("left", "right"))
    middle = (np.arange(count) + 0.5) / count
    chord = MORPHOLOGY.planform.chord(middle)
    area = chord * MORPHOLOGY.planform.mean_chord / chord.sum() * MORPHOLOGY.wing_length  # of the wing as it is
    even = BladeElements(radius=middle * MORPHOLOGY.wing_length, area=area)
    few = flight_loads(MORPHOLOGY, left, right, body, QuasiSteadyModel(), even).total
    many = flight_loads(MORPHOLOGY, left, right, body, QuasiSteadyModel(nodes=100)).total
    return float(np.linalg.norm((few.force - many.force).mean(axis=0))) / MORPHOLOGY.weight


def _without_end(along: Trajectory, side):
    motion = along.left if side == "left" else along.right
    return replace(motion, **{name: getattr(motion, name)[:-1] for name in type(motion).__slots__})


# ## The figure


def draw() -> bytes:
    """Steps on the left, blades on the right."""
    from flycontrol.report.style import in_house_style, new_figure

    with in_house_style():
        figure = new_figure(3.3)
        left, right = figure.subplots(1, 2)
        draw_steps(left)
        draw_blades(right)
        buffer = io.BytesIO()
        figure.savefig(buffer, format="svg", metadata={"Date": None, "Creator": None})
        return buffer.getvalue()


def draw_steps(ax: "Axes") -> None:
    """Error of the attitude over steps a wingbeat."""
    looks = {"all terms": ("#0b3954", "o", "-"), "without lift and drag": ("#3a87c0", "s", "--"),
             "added mass alone": ("#e08a00", "^", ":")}  # fmt: skip
    for terms, (color, marker, line) in looks.items():
        rows = rows_of(terms)
        steps, error = [row.steps for row in rows], [row.error for row in rows]
        ax.plot(steps, error, color=color, marker=marker, linestyle=line, markersize=4, label=terms)
    rows = rows_of("all terms")
    ax.plot(
        [row.steps for row in rows], [row.estimate for row in rows], "x", color="#c8323c", markersize=5,
        label="all terms, as the run estimates it",
    )  # fmt: skip
    guide = np.array([80.0, 1600.0])
    ax.plot(guide, 3e-4 * (guide / 80) ** -4.0, color="#7d7d7d", linewidth=0.8)
    ax.annotate("fourth order", (300, 3e-6), fontsize=7.5, color="#1a1a1a")
    ax.axvline(200, color="#7d7d7d", linewidth=0.7, linestyle=(0, (1, 2)))
    ax.set(xscale="log", yscale="log", xlabel="steps a wingbeat", ylabel="error of attitude after a wingbeat [rad]")
    ax.set_xticks([20, 50, 100, 200, 500, 1000], ["20", "50", "100", "200", "500", "1000"])
    ax.minorticks_off()
    ax.legend(loc="lower left", fontsize=7)


def draw_blades(ax: "Axes") -> None:
    """Error of the load over blades a wing."""
    rows = blade_rows()
    count = [row.blades for row in rows]
    ax.plot(count, [r.even_mean_force for r in rows], "^:", color="#e08a00", markersize=4, label="mean, even blades")
    ax.plot(count, [r.worst_force for r in rows], "s--", color="#3a87c0", markersize=4, label="worst instant, Gauss")
    ax.plot(count, [r.mean_force for r in rows], "o-", color="#0b3954", markersize=4, label="mean, Gauss")
    ax.axvline(6, color="#7d7d7d", linewidth=0.7, linestyle=(0, (1, 2)))
    ax.set(xscale="log", yscale="log", xlabel="blades a wing", ylabel="error of force over weight")
    ax.set_xticks([1, 2, 6, 20, 60], ["1", "2", "6", "20", "60"])
    ax.minorticks_off()
    ax.legend(loc="upper right", fontsize=7)


# ## The answer
#
# **The order is not four.** With all terms it is 0.8 from 80 to 1,600 steps, and errors jump about; without lift and
# drag it is 1.9, with added mass alone 4.0. The fitted C_L of 0.03 at 0 deg and 0.10 at 90 deg is not zero there, so
# that lift does not merely bend but jumps when a blade's velocity passes through its plane or normal. With the
# coefficients `whitney2010`, whose lift vanishes at both ends, the order is 1.9 and 200 steps leave 4e-7 rad instead
# of 8.5e-6. As it is, 80 steps leave 3e-5 and 1,600 leave 5e-6: more steps buy little.
#
# **The run's own estimate is too small**: it divides by 15 as fourth order would allow, and from 80 steps on the
# error is 2.3 to 28 times as large.
#
# **Six blades are enough**: they miss 8e-6 of the weight in the mean and 3.5e-6 rad after a wingbeat, less than the
# steps do; beyond ten blades the error stays at about 1e-6. At the worst instant, while lift turns round somewhere
# along the wing, they miss 3.4e-3, and that falls slowly with any number. Blades of even width miss more in the mean,
# 2.2e-3 at 20 and 4.4e-4 at 64.


def as_text() -> str:
    """Both tables as a page of Markdown."""
    least, largest = trust()
    lines = [
        "# How many steps\n",
        f"One wingbeat of a free, turning fly with a lopsided stroke, against {EXACT_STEPS:,} steps. Order: the slope "
        "from 80 steps on.\n",
        "| steps | " + " | ".join(f"{terms} [rad]" for terms in TERMS) + " | all terms, estimated by the run [rad] |",
        "|---|---|---|---|---|",
    ]
    by_terms = {terms: {row.steps: row for row in rows_of(terms)} for terms in TERMS}
    lines += [
        f"| {steps} | " + " | ".join(f"{by_terms[terms][steps].error:.1e}" for terms in TERMS)
        + f" | {by_terms['all terms'][steps].estimate:.1e} |"
        for steps in STEPS
    ]  # fmt: skip
    lines += [
        "| order | " + " | ".join(f"{order(terms):.1f}" for terms in TERMS) + " | |\n",
        f"From 80 steps on the error is {least:.2g} to {largest:.2g} times what the run estimates.\n",
        f"Blades against {EXACT_BLADES}: force over weight, torque over weight times wing length.\n",
        "| blades | force, worst instant | force, mean | torque, mean | mean force, even blades "
        "| attitude after a wingbeat [rad] |",
        "|---|---|---|---|---|---|",
    ]
    lines += [
        f"| {r.blades} | {r.worst_force:.1e} | {r.mean_force:.1e} | {r.mean_torque:.1e} | {r.even_mean_force:.1e} "
        f"| {r.attitude:.1e} |"
        for r in blade_rows()
    ]
    return "\n".join(lines) + f"\n\n![Error over steps and over blades]({NAME}.svg)\n"


def as_numbers() -> str:
    """The numbers as JSON, three digits."""

    def short(row: StepRow | BladeRow) -> dict[str, object]:
        values = {name: getattr(row, name) for name in type(row).__slots__}
        return {name: float(f"{x:.3g}") if isinstance(x, float) else x for name, x in values.items()}

    orders = {terms: round(order(terms), 2) for terms in TERMS}
    tables = {"steps": [short(row) for row in step_rows()], "blades": [short(row) for row in blade_rows()]}
    return json.dumps({"orders": orders, **tables}, indent=1) + "\n"


def main(folder: Path = FOLDER) -> None:
    """Fly, draw and write."""
    text = opened(__file__, as_text())
    write_files_atomically(folder, {f"{NAME}.md": text, f"{NAME}.json": as_numbers(), f"{NAME}.svg": draw()})
    print(text)


if __name__ == "__main__":
    main(folder_named(__file__, __doc__, FOLDER))
