"""How well can silhouettes tell where a fly and its wings are: by pixels, cameras, images, and what is known of it?

Run with `python analyses/how_well_can_silhouettes_tell.py [FOLDER]`. The note, the numbers and the figures go to
reports/how_well_can_silhouettes_tell unless a folder is given. It takes some five minutes on one core.
"""

import io
import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from _by_hand import REPORTS, folder_named
from numpy.typing import NDArray

from flycontrol.jobs.files import write_files_atomically
from flycontrol.model.camera import Camera, replaced
from flycontrol.model.camera_forms import looking_at
from flycontrol.model.planform import Planform
from flycontrol.model.pose import COORDINATES, Pose
from flycontrol.model.references import cite
from flycontrol.units import deg, mm, um
from flycontrol.vision.example_flight import turning_pose
from flycontrol.vision.first_pose import MARGIN, fine_hull
from flycontrol.vision.fit_shape import fit_shape
from flycontrol.vision.fly_shape import FlyShape, fly_shape
from flycontrol.vision.follower import Fly, Follower
from flycontrol.vision.reading.hull_stance import stance_of_hull
from flycontrol.vision.render import IDEAL, Imaging, Silhouettes, degraded, render_silhouettes
from flycontrol.vision.silhouette_fit import Agreement, SilhouetteFit, best_wing
from flycontrol.vision.silhouettes import cleaned
from flycontrol.vision.size_fit import Sizes, resized
from flycontrol.vision.soft_silhouette import border_distance
from flycontrol.vision.stance import BASE_MOVE, MOVE, TURN, WING_TURN, Stance, pose_of, stances_of, stepped
from flycontrol.vision.tracked_frame import Track, gathered
from flycontrol.vision.views import views_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

NAME = "how_well_can_silhouettes_tell"
FOLDER = REPORTS / NAME
SEED = 20090117

# ## The question
#
# Section 2 of the review reads 18 coordinates a frame off the hull of three silhouettes. Its method's authors state
# errors under 3 pixels and 5 deg; a tracker that fits a model of the fly to the images states 2 to 9 deg, angle by
# angle. What can silhouettes tell, which camera or pixel is worth its money, and when do they say nothing?
#
# A fly with legs turns by 100 deg, banks and beats its wings unequally, at 8,000 frames a second. It is drawn, filmed
# in one way or another, and tracked by the package: once by its hull alone, once by the parametric fly fitted to all
# silhouettes. The fitted fly has no legs, and, except where said, the sizes of the drawn one. Cameras are ideal but
# where said. All of this flatters: a real fly bends its wings, and its sizes are not known beforehand.

RATE, FREQUENCY = 8000.0, 220.0  # [1/s]
WINGBEATS = 10
STROKE_PLANE = 50 * deg
DISTANCE = 120 * mm  # of cameras
VIEW = 7.3 * mm  # width of what they see
PLANFORM = Planform(length=2.4 * mm, mean_chord=2.4 * mm / 3.4, second_moment_radius=0.58)
FITTED, DRAWN = fly_shape(PLANFORM), fly_shape(PLANFORM, legs=True)
FLY = Fly(shape=FITTED, stroke_plane_angle=STROKE_PLANE)


def turning_flight(shape: FlyShape, wingbeats: float = WINGBEATS) -> Pose:
    """100 deg to the right, banked by up to 25 deg, with wings that beat unequally."""
    return turning_pose(shape, STROKE_PLANE, wingbeats)


def held_elsewhere(pose: Pose, stroke: float, deviation: float) -> Pose:
    """The same flight with both wings' strokes and deviations shifted [rad]."""
    X = pose.coordinates.copy()
    X[:, [6, 9]] += stroke
    X[:, [7, 10]] += deviation
    return Pose(coordinates=X, stroke_plane_angle=pose.stroke_plane_angle)


# ## How a fly is filmed
#
# One thing at a time is changed from the reference: three orthogonal cameras, 35 px/mm, sharp silhouettes. Cameras
# less than 90 deg apart look along directions with equal angles to each other, about the same axis as the orthogonal
# ones, and so more from above the narrower they stand; with two, the first two of them, which at 90 deg both look
# level. A fourth camera looks along that axis.


def cameras_apart(angle: float, count: int, scale: float) -> tuple[Camera, ...]:
    """Cameras an angle apart from one another [rad], at `scale` [px/m], for a view of 7.3 mm."""
    axis = np.full(3, 1 / np.sqrt(3))
    sine = np.sqrt((1 - np.cos(angle)) / 1.5)
    places = [np.sqrt(1 - sine**2) * axis + sine * _unit(e - axis * (axis @ e)) for e in np.eye(3)]
    size = round(VIEW * scale)
    return tuple(
        looking_at(np.zeros(3), DISTANCE * place, focal=scale * DISTANCE, shape=(size, size), name=f"camera {k}")
        for k, place in enumerate([*places, axis][:count], start=1)
    )


def _unit(v: FloatArray) -> FloatArray:
    return v / np.linalg.norm(v)


@dataclass(frozen=True, slots=True, kw_only=True)
class Filming:
    """One way to film one fly."""

    name: str = "reference: 3 orthogonal, 35 px/mm"
    group: str = "reference"
    scale: float = 35 / mm  #: [px/m]
    angle: float = 90 * deg  #: between cameras [rad]
    count: int = 3
    imaging: Imaging = IDEAL
    misplaced: float = 0.0  #: by which each camera's image is shifted from where its calibration has it [px]
    drawn: FlyShape = DRAWN
    held: tuple[float, float] = (0.0, 0.0)  #: added to stroke and deviation of both wings [rad]
    phase: float | None = None  #: wingbeats at which all counted frames lie; None: all of them

    @property
    def cameras(self) -> tuple[Camera, ...]:
        """As calibrated."""
        return cameras_apart(self.angle, self.count, self.scale)

    @property
    def misplaced_cameras(self) -> tuple[Camera, ...]:
        """As they stand: each shifted its own way."""
        ways = 2.4 * np.arange(self.count)  # [rad]
        moves = self.misplaced * np.stack([np.cos(ways), np.sin(ways)], axis=1)
        return tuple(
            replaced(camera, matrix=np.array([[1, 0, u], [0, 1, v], [0, 0, 1.0]]) @ camera.matrix)
            for camera, (u, v) in zip(self.cameras, moves, strict=True)
        )

    def flight(self) -> Pose:
        """What is flown."""
        return held_elsewhere(turning_flight(self.drawn), *self.held)

    def silhouettes(self, pose: Pose, seed: int) -> list[Silhouettes]:
        """What the cameras show of it, without dust."""
        masks = render_silhouettes(self.drawn, pose, self.misplaced_cameras)
        if self.imaging == IDEAL:
            return list(masks)
        return [tuple(cleaned(mask).mask for mask in views) for views in degraded(masks, self.imaging, seed)]


REFERENCE = Filming()


def _sized(name: str, shape: FlyShape) -> Filming:
    return replace(REFERENCE, group="shape", name=name, drawn=shape)


def _seen_by(count: int, angle: float, name: str = "") -> Filming:
    named = name or f"{count} cameras, {angle:.0f} deg apart"
    return replace(REFERENCE, group="cameras", name=named, count=count, angle=angle * deg)


def _imaged(name: str, imaging: Imaging) -> Filming:
    return replace(REFERENCE, group="images", name=name, imaging=imaging)


def _body(factor: float) -> FlyShape:
    return resized(DRAWN, Sizes(body_length=factor, body_radius=factor))


def _wings(factor: float) -> FlyShape:
    return resized(DRAWN, Sizes(wing_length=factor, wing_chord=factor))


FILMINGS = (
    REFERENCE,
    *(replace(REFERENCE, group="pixels", name=f"{s} px/mm", scale=s / mm) for s in (15, 25, 70)),
    _seen_by(4, 90, "3 orthogonal cameras and a fourth"), _seen_by(3, 60), _seen_by(3, 30),
    _seen_by(2, 90), _seen_by(2, 60), _seen_by(2, 30),
    _imaged("blur of 1 px, noise of 10 %", Imaging(blur=1.0, noise=0.1)),
    _imaged("15 % of pixels lost", Imaging(missing=0.15)),
    replace(REFERENCE, group="images", name="each camera 1 px off", misplaced=1.0),
    _sized("wings 5 % larger", _wings(1.05)), _sized("wings 5 % smaller", _wings(0.95)),
    _sized("body 10 % larger", _body(1.1)), _sized("body 10 % smaller", _body(0.9)),
    _sized("no legs", FITTED),
    replace(REFERENCE, group="wings", name="rear reversal", phase=0.0),
    replace(REFERENCE, group="wings", name="rear reversal, along the abdomen", phase=0.0, held=(-20 * deg, -40 * deg)),
    replace(REFERENCE, group="wings", name="front reversal", phase=0.5),
    replace(REFERENCE, group="wings", name="front reversal, wings meet", phase=0.5, held=(20 * deg, 0.0)),
)  # fmt: skip


# ## How it is tracked
#
# Not whole flights but stretches of eleven frames, five of them over the flight, so that each covers another fifth of
# the wingbeat. The tracker is set on the fly about as wrongly as it is in mid-flight (standard deviations: 0.02 mm, 1
# deg in yaw and pitch, 3 deg in roll, 5 deg in each turn of a wing, wings' bases where the fitted shape has them), then
# follows it by its own predictions; three frames later its errors count. The hull is read in every second of those
# frames, and is told the truth of the frame before, as wrongly: wings are up to 12 deg farther then. That is kinder
# than following by the hull alone.
#
# One flight of ten wingbeats is followed as a whole, from a first pose known as badly, by the fit and by the hull
# alone: does the short cut flatter?

_BETWEEN_REVERSALS = 4  # frames after a rear reversal
TURNS_OFF = np.array([3, 1, 1]) * deg  # roll, pitch, yaw


@dataclass(frozen=True, slots=True, kw_only=True)
class Plan:
    """How much is tracked."""

    stretches: int = 5
    warm: int = 3  #: frames of a stretch that do not count
    counted: int = 8
    whole: int = 10  #: wingbeats that are followed as a whole
    filmings: tuple[Filming, ...] = FILMINGS

    def starts(self, filming: Filming, frames: int) -> list[int]:
        """First frame of every stretch."""
        beat = RATE / FREQUENCY
        apart = (frames - beat) / beat / self.stretches  # wingbeats
        if filming.phase is None:
            fifths = int(apart * self.stretches) / self.stretches
            return [_BETWEEN_REVERSALS + round(beat * fifths * k) for k in range(self.stretches)]
        middle = self.warm + (self.counted - 1) / 2
        return [round(beat * (1 + round(apart) * k + filming.phase) - middle) for k in range(self.stretches)]


def disturbed(truth: Stance, rng: np.random.Generator) -> Stance:
    """As wrong as a tracker is in mid-flight."""
    step = np.zeros(18)
    step[MOVE] = rng.normal(0, 0.02 * mm, 3)
    step[TURN] = rng.normal(0, TURNS_OFF)
    for side in (0, 1):
        step[WING_TURN[side]] = rng.normal(0, 5 * deg, 3)
    base = fit_shape(FITTED).bases_B
    step[BASE_MOVE[0].start :] = (base - truth.bases_B).ravel()
    return stepped(truth, step)


def known(stance: Stance) -> SilhouetteFit:
    """A start for a follower."""
    nothing = Agreement(cost=np.inf, overlap=np.zeros(1), precision=np.zeros(1))
    return SilhouetteFit(stance=stance, covariance=np.zeros((18, 18)), agreement=nothing, converged=True, iterations=0)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Found:
    """What a tracker said beside the truth, N frames; NaN where it says that it does not know, wing by wing."""

    error: FloatArray  #: (N, 18) [m, rad]
    spread: FloatArray  #: (N, 18) standard deviations that it stated [m, rad]
    phase: FloatArray  #: (N,) of the wingbeat

    @property
    def missed(self) -> float:
        """Share of frames without an answer for the body."""
        return float(np.mean(np.isnan(self.error[:, 0])))

    @property
    def wings_missed(self) -> float:
        """Share of wings without an answer."""
        return float(np.mean(np.isnan(self.error[:, [6, 9]])))

    @property
    def wings_wrong(self) -> float:
        """Share of wings with an answer and an angle that is 45 deg off or more."""
        return float(np.mean(np.max(np.abs(self.error[:, 6:12]).reshape(-1, 2, 3), axis=2) >= 45 * deg))

    def __add__(self, other: "Found") -> "Found":
        """Both, one after the other."""
        both = ((getattr(self, name), getattr(other, name)) for name in Found.__slots__)
        error, spread, phase = (np.concatenate(pair) for pair in both)
        return Found(error=error, spread=spread, phase=phase)


def errors(found: Pose, truth: Pose) -> FloatArray:
    """(N, 18) found less true, angles within +-180 deg."""
    away = found.coordinates - truth.coordinates
    away[:, 3:12] = (away[:, 3:12] + np.pi) % (2 * np.pi) - np.pi
    return away


def followed(filming: Filming, truth: Pose, first: int, count: int, *, refine: bool = True) -> Found:
    """By the tracker, from a wrong start at the first frame on."""
    rng, pose = np.random.default_rng([SEED, first]), truth[first : first + count]
    start = known(disturbed(stances_of(pose[0])[0], rng))
    follower = Follower(cameras=filming.cameras, fly=FLY, refine=refine, start=start)
    masks = filming.silhouettes(pose, SEED + first)
    found = gathered((follower.follow(each) for each in masks), STROKE_PLANE, filming.count)
    seen = np.where(believed(found), 1.0, np.nan)
    return Found(error=errors(found.pose, pose) * seen, spread=found.uncertainty * seen, phase=phases(first, count))


def believed(found: Track) -> BoolArray:
    """(N, 18) which coordinates of which frames the tracker believes."""
    told = np.repeat(found.believed[:, None], len(COORDINATES), axis=1)
    for k, doubts in enumerate(found.doubts):
        for side, doubt in zip(("left", "right"), doubts[1:], strict=True):
            if doubt:
                told[k, [name.startswith(side) for name in COORDINATES]] = False
    return told


def phases(first: int, count: int, step: int = 1) -> FloatArray:
    """(N,) of the wingbeat, 0 at the rear reversal."""
    return np.arange(first, first + count, step) * FREQUENCY / RATE % 1


def read_off_hulls(filming: Filming, truth: Pose, first: int, count: int, step: int = 2) -> Found:
    """The hull alone, told the frame before."""
    rng, pose = np.random.default_rng([SEED, first, 1]), truth[first : first + count : step]
    shape, said = fit_shape(FITTED), np.full((len(pose), 18), np.nan)
    masks = filming.silhouettes(pose, SEED + first)
    for k, views in enumerate(masks):
        hull = fine_hull(views, filming.cameras, shape)
        before = disturbed(stances_of(truth[max(first + k * step - 1, 0)])[0], rng)
        border = border_distance(views_of(views, filming.cameras), MARGIN)
        choice = partial(best_wing, border, shape, softness=2.5)  # roughly, as the tracker judges a hull
        read = stance_of_hull(hull, before, FITTED, STROKE_PLANE, choice) if len(hull) else None
        if read is not None and read.dissection.complete:
            said[k] = pose_of([read.stance], STROKE_PLANE).coordinates[0]
    error = errors(Pose(coordinates=said, stroke_plane_angle=STROKE_PLANE), pose)
    return Found(error=error, spread=np.full_like(error, np.nan), phase=phases(first, count, step))


@dataclass(frozen=True, slots=True, kw_only=True)
class Tried:
    """One way to film, and what came of it."""

    filming: Filming
    fit: Found
    hull: Found


def tried(filming: Filming, plan: Plan) -> Tried:
    """All stretches of one way to film."""
    truth = filming.flight()
    starts = plan.starts(filming, len(truth))
    fits = [_counted(followed(filming, truth, first, plan.warm + plan.counted), plan.warm) for first in starts]
    hulls = [read_off_hulls(filming, truth, first + plan.warm, plan.counted) for first in starts]
    return Tried(filming=filming, fit=_joined(fits), hull=_joined(hulls))


def _counted(found: Found, warm: int) -> Found:
    return Found(error=found.error[warm:], spread=found.spread[warm:], phase=found.phase[warm:])


def _joined(parts: Sequence[Found]) -> Found:
    whole = parts[0]
    for part in parts[1:]:
        whole = whole + part
    return whole


# ## What is compared
#
# Left and right wings together, the body's centre as a distance, over what the tracker believes; beside it the share
# that it does not, and the share of wings that it believes and that are far off.


@dataclass(frozen=True, slots=True, kw_only=True)
class Quantity:
    """Some of the 18 coordinates that are judged together."""

    name: str
    unit: str
    columns: tuple[int, ...]
    size: float  #: of the unit [m or rad]
    joint: bool = False  #: the length of the vector, not each column


QUANTITIES = (
    Quantity(name="centre", unit="um", columns=(0, 1, 2), size=um, joint=True),
    Quantity(name="yaw", unit="deg", columns=(3,), size=deg),
    Quantity(name="pitch", unit="deg", columns=(4,), size=deg),
    Quantity(name="roll", unit="deg", columns=(5,), size=deg),
    Quantity(name="stroke", unit="deg", columns=(6, 9), size=deg),
    Quantity(name="deviation", unit="deg", columns=(7, 10), size=deg),
    Quantity(name="wing pitch", unit="deg", columns=(8, 11), size=deg),
    Quantity(name="wing bases", unit="um", columns=(12, 13, 14, 15, 16, 17), size=um),
)
ANGLES = QUANTITIES[1:7]


def sizes(found: Found, quantity: Quantity) -> FloatArray:
    """Absolute errors in the quantity's unit; what has no answer left out."""
    columns = found.error[:, quantity.columns] / quantity.size
    values = np.linalg.norm(columns, axis=1) if quantity.joint else np.abs(columns).ravel()
    return values[np.isfinite(values)]


def rms(found: Found, quantity: Quantity) -> float:
    """Root mean square error in the quantity's unit."""
    values = sizes(found, quantity)
    return float(np.sqrt(np.mean(values**2))) if len(values) else np.nan


def middle(found: Found, quantity: Quantity) -> float:
    """Median error in the quantity's unit."""
    values = sizes(found, quantity)
    return float(np.median(values)) if len(values) else np.nan


def held_by_band(found: Found, quantity: Quantity) -> float:
    """Share of errors within 1.96 stated standard deviations."""
    error, spread = (values[:, quantity.columns] for values in (found.error, found.spread))
    told = np.isfinite(error)
    return float(np.mean(np.abs(error[told]) <= 1.96 * spread[told])) if told.any() else np.nan


def stated(found: Found, quantity: Quantity) -> float:
    """Root mean square of the stated standard deviations, in the quantity's unit."""
    spread = np.where(np.isfinite(found.error), found.spread, np.nan)[:, quantity.columns] / quantity.size
    squares = np.sum(spread**2, axis=1) if quantity.joint else spread**2
    return float(np.sqrt(np.nanmean(squares)))


# ## All of it


@dataclass(frozen=True, slots=True, kw_only=True)
class Findings:
    """Everything that was tracked."""

    tried: tuple[Tried, ...]
    whole: Found  #: one flight, by the tracker
    whole_hull: Found  #: the same, followed by the hull alone

    def named(self, name: str) -> Tried:
        """One way to film."""
        return next(each for each in self.tried if each.filming.name == name)

    def group(self, *groups: str) -> list[Tried]:
        """Ways to film of some groups, in their order."""
        return [each for each in self.tried if each.filming.group in groups]

    @property
    def reference(self) -> Tried:
        """Three orthogonal cameras, 35 px/mm, sharp."""
        return self.tried[0]


def findings(plan: Plan | None = None) -> Findings:
    """Film and track."""
    plan = plan or Plan()
    truth = REFERENCE.flight()
    count = min(int(plan.whole * RATE / FREQUENCY), len(truth))
    return Findings(
        tried=tuple(tried(filming, plan) for filming in plan.filmings),
        whole=followed(REFERENCE, truth, 0, count),
        whole_hull=followed(REFERENCE, truth, 0, count, refine=False),
    )


# ## The figures

_DARK, _BLUE, _ORANGE, _GREY = "#0b3954", "#3a87c0", "#e08a00", "#7d7d7d"


def draw(found: Findings) -> dict[str, bytes]:
    """Four figures, by file name."""
    from flycontrol.report.style import in_house_style

    drawn: dict[str, Callable[[Findings], Figure]] = {
        f"{NAME}.svg": figure_of_pixels,
        f"{NAME}_filmed.svg": figure_of_filmings,
        f"{NAME}_wingbeat.svg": figure_of_wingbeat,
        f"{NAME}_bands.svg": figure_of_bands,
    }
    files: dict[str, bytes] = {}
    with in_house_style():
        for name, figure in drawn.items():
            buffer = io.BytesIO()
            figure(found).savefig(buffer, format="svg", metadata={"Date": None, "Creator": None})
            files[name] = buffer.getvalue()
    return files


def figure_of_pixels(found: Findings) -> "Figure":
    """Median errors over pixels a millimetre."""
    from flycontrol.report.style import new_figure

    figure = new_figure(3.1)
    by_scale = sorted(found.group("reference", "pixels"), key=lambda each: each.filming.scale)
    axes = figure.subplots(1, 3)
    for ax, quantities in zip(axes, (QUANTITIES[:1], ANGLES[:3], ANGLES[3:]), strict=True):
        draw_over_pixels(ax, by_scale, quantities)
    name_ways(figure, axes[0], "fit: dark, filled", "hull alone: light, hollow")
    return figure


def name_ways(figure: "Figure", ax: "Axes", fit: str, hull: str) -> None:
    """One legend above all panels."""
    ways = [
        *ax.plot([], [], "o-", color=_DARK, markersize=4.5, label=fit),
        *ax.plot([], [], "o-", color=_ORANGE, markersize=4.5, markerfacecolor="white", label=hull),
    ]
    figure.legend(handles=ways, loc="outside upper center", ncols=2, fontsize=8)
    for way in ways:
        way.set_label("")


def draw_over_pixels(ax: "Axes", by_scale: list[Tried], quantities: Sequence[Quantity]) -> None:
    """Fit dark and filled, hull light and hollow."""
    scale = np.array([each.filming.scale * mm for each in by_scale])
    for quantity, marker, line in zip(quantities, "osD", ("-", "--", ":"), strict=False):
        for way, color, fill in (("fit", _DARK, _DARK), ("hull", _ORANGE, "white")):
            median = [middle(getattr(each, way), quantity) for each in by_scale]
            ax.plot(
                scale, median, color=color, marker=marker, linestyle=line, markersize=4.5, markerfacecolor=fill,
                label=quantity.name if way == "fit" else "",
            )  # fmt: skip
    if quantities[0].unit == "um":
        ax.plot(scale, 1000 / scale, color=_GREY, linewidth=1.0, linestyle=(0, (1, 2)), label="one pixel")
    ax.set(xscale="log", yscale="log", xlabel="pixels a millimetre", ylabel=f"median error [{_unit_of(quantities[0])}]")
    ax.set_xticks(scale, [f"{s:.0f}" for s in scale])
    ax.minorticks_off()
    ticks_at_1_2_5(ax)
    low, high = ax.get_ylim()
    ax.set_ylim(low, high * (high / low) ** 0.3)  # room for the names
    ax.legend(loc="upper left", fontsize=7.5, ncols=2, handlelength=2.2, columnspacing=1.2)


def ticks_at_1_2_5(ax: "Axes") -> None:
    """Enough numbers on a logarithmic axis of a decade or two."""
    from matplotlib.ticker import LogLocator

    from flycontrol.report.style import plain_log_ticks

    ax.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    plain_log_ticks(ax, "y")


def _unit_of(quantity: Quantity) -> str:
    return "µm" if quantity.unit == "um" else quantity.unit


def figure_of_filmings(found: Findings) -> "Figure":
    """Every way to film, every quantity: median to 95 % of frames."""
    from flycontrol.report.style import new_figure

    figure, shown = new_figure(6.6), QUANTITIES[:7]
    axes = figure.subplots(1, len(shown), sharey=True)
    names = [each.filming.name for each in found.tried]
    for ax, quantity in zip(axes, shown, strict=True):
        draw_filmings(ax, found.tried, quantity)
    axes[0].set_yticks(range(len(names)), names, fontsize=7)
    axes[0].set_ylim(len(names) - 0.4, -0.6)
    name_ways(figure, axes[0], "fit: median, line to 95 % of frames", "hull alone, likewise")
    return figure


def draw_filmings(ax: "Axes", rows: Sequence[Tried], quantity: Quantity) -> None:
    """One column."""
    from flycontrol.report.style import plain_log_ticks

    for way, color, fill, below in (("fit", _DARK, _DARK, -0.17), ("hull", _ORANGE, "white", 0.17)):
        ends = np.array([_quantiles(getattr(each, way), quantity) for each in rows])
        y = np.arange(len(rows)) + below
        gap = np.full(len(rows), np.nan)
        ax.plot(np.column_stack([ends, gap]).ravel(), np.column_stack([y, y, gap]).ravel(), color=color, linewidth=1.1)
        ax.plot(ends[:, 0], y, "o", color=color, markersize=3.2, markerfacecolor=fill)
    groups = [each.filming.group for each in rows]
    for k in range(1, len(rows)):
        if groups[k] != groups[k - 1]:
            ax.axhline(k - 0.5, color=_GREY, linewidth=0.5)
    ax.set(xscale="log", xlabel=f"[{_unit_of(quantity)}]")
    ax.set_title(quantity.name, fontsize=8)
    ax.minorticks_off()
    ax.grid(axis="x", color="#e3e3e3", linewidth=0.5)
    ax.set_axisbelow(True)
    plain_log_ticks(ax, "x")
    ax.tick_params(axis="x", labelsize=7)
    ax.tick_params(axis="y", length=0)


BINS = 12  # of a wingbeat


def figure_of_wingbeat(found: Findings) -> "Figure":
    """Errors of the wings' angles along the wingbeat, whole flight."""
    from flycontrol.report.style import new_figure

    figure = new_figure(2.9)
    axes = figure.subplots(1, 3)
    for ax, quantity in zip(axes, ANGLES[3:], strict=True):
        draw_along_wingbeat(ax, found, quantity)
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside upper center", ncols=4, fontsize=8)
    return figure


def draw_along_wingbeat(ax: "Axes", found: Findings, quantity: Quantity) -> None:
    """Medians and 95 % of frames by twelfths; reversals at 0, 0.5 and 1."""
    x = (np.arange(BINS) + 0.5) / BINS
    for part, name, color, line in ((found.whole, "fit", _DARK, "-"), (found.whole_hull, "hull", _ORANGE, "--")):
        ends = np.array([_quantiles(by_twelfth(part, k), quantity) for k in range(BINS)])
        ax.plot(x, ends[:, 0], color=color, linestyle=line, linewidth=1.8, label=f"{name}, median")
        ax.plot(x, ends[:, 1], color=color, linestyle=line, linewidth=0.8, label=f"{name}, 95 % of frames")
    for turn in (0, 0.5, 1):
        ax.axvline(turn, color=_GREY, linewidth=0.7, linestyle=(0, (1, 2)))
    ax.set(
        yscale="log", xlim=(0, 1), ylabel=f"error of {quantity.name} [deg]", xlabel="wingbeats from rear reversal",
    )  # fmt: skip
    ax.set_xticks([0, 0.25, 0.5, 0.75, 1], ["0", "0.25", "0.5", "0.75", "1"])
    ax.minorticks_off()
    ticks_at_1_2_5(ax)


def by_twelfth(found: Found, k: int) -> Found:
    """The frames of one twelfth of the wingbeat."""
    rows = (found.phase * BINS).astype(int) % BINS == k
    return Found(error=found.error[rows], spread=found.spread[rows], phase=found.phase[rows])


def _quantiles(found: Found, quantity: Quantity) -> FloatArray:
    values = sizes(found, quantity)
    return np.quantile(values, [0.5, 0.95]) if len(values) else np.full(2, np.nan)


def banded(found: Findings) -> dict[str, Found]:
    """What the tracker's bands are tried on."""
    named = {
        "whole flight, legs": found.whole,
        "no legs": _of(found, lambda filming: filming.name == "no legs"),
        "blur, noise, lost pixels": _of(found, lambda filming: filming.imaging != IDEAL),
        "other sizes": _of(found, lambda filming: filming.name.startswith(("wings 5", "body 10"))),
    }
    return {name: each for name, each in named.items() if len(each.error)}


def _of(found: Findings, which: Callable[[Filming], bool]) -> Found:
    nothing = Found(error=np.empty((0, 18)), spread=np.empty((0, 18)), phase=np.empty(0))
    return _joined([nothing, *(each.fit for each in found.tried if which(each.filming))])


def figure_of_bands(found: Findings) -> "Figure":
    """How often the stated 95 % bands hold the truth."""
    from flycontrol.report.style import new_figure

    figure = new_figure(2.9)
    ax = figure.subplots()
    looks = (("o", _DARK, _DARK), ("^", _BLUE, "white"), ("s", _ORANGE, _ORANGE), ("D", "#c8323c", "white"))
    rows = np.arange(len(QUANTITIES))
    for k, ((name, each), (marker, color, fill)) in enumerate(zip(banded(found).items(), looks, strict=False)):
        share = [100 * held_by_band(each, quantity) for quantity in QUANTITIES]
        ax.plot(
            share, rows + 0.2 * (k - 1.5), marker, color=color, markerfacecolor=fill, markersize=5.5, label=name,
            clip_on=False,
        )  # fmt: skip
    ax.axvline(95, color=_GREY, linewidth=0.8, linestyle=(0, (4, 2)))
    ax.set(xlabel="truth within the stated 95 % band [% of frames]", xlim=(0, 100), ylim=(len(QUANTITIES) - 0.5, -0.5))
    ax.set_yticks(range(len(QUANTITIES)), [quantity.name for quantity in QUANTITIES])
    ax.grid(axis="y", color="#e3e3e3", linewidth=0.5)
    ax.set_axisbelow(True)
    figure.legend(loc="outside right upper", fontsize=7.5)
    return figure


# ## The answer in numbers

#: Published, root mean square or mean as their authors have it: position [px], then yaw to wing pitch [deg].
HRMT = {"centre": "3 px", **dict.fromkeys((angle.name for angle in ANGLES), "5")}
MODEL_FIT = {
    "centre": "106 (4.4 % of the body)", "yaw": "3.4", "pitch": "3.2", "roll": "6.5", "stroke": "3.3",
    "deviation": "2.1", "wing pitch": "8.8 (attack)",
}  # fmt: skip
#: What the package aims at in this flight [deg].
AIMS = {"yaw": 1, "pitch": 1, "roll": 3, "stroke": 2, "deviation": 2, "wing pitch": 5}


def in_pixels(value: float, filming: Filming = REFERENCE) -> float:
    """A length in [um] as pixels."""
    return value * um * filming.scale


def as_text(found: Findings) -> str:
    """The note as Markdown."""
    return "\n".join([
        "# How well can silhouettes tell\n",
        "A simulated fly with legs turns by 100 deg in ten wingbeats at 8,000 frames a second, is filmed in "
        "silhouettes and tracked by its visual hull alone, and by a parametric fly fitted to all silhouettes. The "
        "fitted fly has no legs, and where nothing else is said the sizes of the drawn one; cameras are calibrated "
        "without error.\n",
        *_whole_table(found),
        "Published errors are those of the authors' abstracts: the first without saying what they are means of, the "
        "second beside a person who digitised six real films, whose own errors they contain. Ours are of a fly that "
        "bends nowhere.\n",
        *_answer(found), *_filmings_tables(found), *_bands_table(found),
        *[f"![{title}]({name})\n" for name, title in _TITLES.items()],
        "## How it was done\n",
        f"Each way to film: {len(found.reference.fit.error)} frames in stretches over the flight that together cover "
        "the wingbeat (reversals: around them). In each the tracker is set on the fly as wrongly as it is in "
        "mid-flight (standard deviations: 0.02 mm; 1 deg in yaw and pitch, 3 deg in roll; 5 deg in each turn of a "
        "wing; the wings' bases where the fitted fly has them), follows it by its own predictions, and counts from the "
        "fourth frame on. The hull is read in every second of those frames, told the truth of the frame before, as "
        "wrongly: kinder than following by the hull. Whole flight: followed by either from such a start, all frames "
        "counted. Errors of both wings are pooled; centre: length of the error's vector; bases: along each axis. Seeds "
        "are fixed.\n",
    ])  # fmt: skip


_TITLES = {
    f"{NAME}.svg": "Median errors over pixels a millimetre",
    f"{NAME}_filmed.svg": "Errors by cameras, images, shape and place of the wings",
    f"{NAME}_wingbeat.svg": "Errors along the wingbeat",
    f"{NAME}_bands.svg": "How often stated bands hold the truth",
}


def _whole_table(found: Findings) -> list[str]:
    first, second = cite("ristroph2009").label, cite("fontaine2009").label
    lines = [
        f"| whole flight, 35 px/mm, 3 orthogonal cameras | fit, rms | fit, median (95 %) | aim, rms | hull, rms "
        f"| hull, median (95 %) | {first}: under | {second}: within |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for q in QUANTITIES:
        unit = _unit_of(q)
        aim = AIMS.get(q.name, "")
        lines.append(
            f"| {q.name} [{unit}] | {rms(found.whole, q):.3g} | {_both(found.whole, q)} | {aim} "
            f"| {rms(found.whole_hull, q):.3g} | {_both(found.whole_hull, q)} | {HRMT.get(q.name, '')} "
            f"| {MODEL_FIT.get(q.name, '')} |"
        )
    return [*lines, ""]


def _both(found: Found, quantity: Quantity) -> str:
    """Median and 95 % quantile, two digits."""
    values = sizes(found, quantity)
    if not len(values):
        return "none"
    low, high = np.quantile(values, [0.5, 0.95])
    return f"{low:.2g} ({high:.2g})" if high < 99.5 else f"{low:.0f} ({high:.0f})"


def _filmings_tables(found: Findings) -> list[str]:
    lines: list[str] = []
    for way, title in (("fit", "By the fit"), ("hull", "By the hull alone")):
        lines += [
            f"## {title}: median error, and in brackets what 95 % of frames stay below\n",
            "| filmed | " + " | ".join(_headed(q) for q in QUANTITIES) + " | body not told [%] | wings not told [%] "
            "| wings 45 deg wrong [%] |",
            "|---|" + "---|" * (len(QUANTITIES) + 3),
        ]
        for each in found.tried:
            part = getattr(each, way)
            cells = " | ".join(_both(part, q) for q in QUANTITIES)
            shares = " | ".join(f"{100 * share:.0f}" for share in (part.missed, part.wings_missed, part.wings_wrong))
            lines.append(f"| {each.filming.name} | {cells} | {shares} |")
        lines.append("")
    return lines


def _headed(quantity: Quantity) -> str:
    return f"{quantity.name} [{_unit_of(quantity)}]"


def _bands_table(found: Findings) -> list[str]:
    lines = ["## Stated uncertainty of the fit\n",
             "| | " + " | ".join(q.name for q in QUANTITIES) + " |", "|---|" + "---|" * len(QUANTITIES)]  # fmt: skip
    for name, part in banded(found).items():
        lines.append(
            f"| {name}: truth in the 95 % band [%] | "
            + " | ".join(f"{100 * held_by_band(part, q):.0f}" for q in QUANTITIES) + " |"
        )  # fmt: skip
    lines.append(
        "| whole flight: rms stated over rms error | "
        + " | ".join(f"{stated(found.whole, q) / rms(found.whole, q):.2g}" for q in QUANTITIES) + " |"
    )  # fmt: skip
    return [*lines, ""]


def _answer(found: Findings) -> list[str]:
    """What the tables say, in sentences; medians where nothing else is said."""
    tellers = (_about_legs, _about_pixels, _about_cameras, _about_images, _about_shape, _about_wings)
    told = (line for teller in tellers for line in teller(found))
    return ["## What follows (medians)\n", _about_hull(found), *told, _about_bands(found), ""]


def _named(found: Findings, name: str) -> Found:
    """The fits of one way to film; none if it was not tried."""
    return _of(found, lambda filming: filming.name == name)


def _from_to(before: Found, after: Found, quantities: Sequence[Quantity] = QUANTITIES[:7]) -> str:
    """Medians of two, side by side."""
    return ", ".join(
        f"{q.name} {middle(before, q):.2g} → {middle(after, q):.2g}{' µm' if q.unit == 'um' else ''}"
        for q in quantities
    ) + (" deg" if quantities[-1].unit == "deg" else "")  # fmt: skip


def _between(rows: Sequence[Tried], quantities: Sequence[Quantity] = QUANTITIES[:7]) -> str:
    """The smallest and the largest median."""
    told: list[str] = []
    for q in quantities:
        medians = [middle(each.fit, q) for each in rows]
        told.append(f"{q.name} {min(medians):.2g} to {max(medians):.2g}{' µm' if q.unit == 'um' else ''}")
    return ", ".join(told) + (" deg" if quantities[-1].unit == "deg" else "")


def _percent(share: float) -> str:
    return f"{100 * share:.0f} %"


def _about_hull(found: Findings) -> str:
    hull = found.whole_hull
    yaw, pitch, roll, stroke = (middle(hull, q) for q in ANGLES[:4])
    return (
        f"- **The hull alone** places the centre to {in_pixels(middle(hull, QUANTITIES[0])):.1f} px and the body's "
        f"axis to {yaw:.1f} (yaw) and {pitch:.1f} deg (pitch). Roll, read off the wings, is {roll:.0f} deg "
        f"off, and stroke, seen from the rolled body, {stroke:.0f}. It gives no answer for "
        f"{_percent(hull.missed)} of the frames and puts {_percent(hull.wings_wrong)} of the wings 45 deg off or more "
        "in some angle."
    )


def _about_legs(found: Findings) -> list[str]:
    bare = _named(found, "no legs")
    if not len(bare.error):
        return []
    return [f"- **Legs**, which the fitted fly does not have. Without → with: {_from_to(bare, found.reference.fit)}."]


def _about_pixels(found: Findings) -> list[str]:
    fewest, most = (_named(found, name) for name in ("15 px/mm", "70 px/mm"))
    if not (len(fewest.error) and len(most.error)):
        return []
    hulls = [found.named(name).hull for name in ("15 px/mm", "70 px/mm")]
    lever = float(np.linalg.norm(FITTED.right_base_B[1:]))
    return [
        f"- **Pixels**, 15 → 70 px/mm: {_from_to(fewest, most)}. Roll, and stroke with it, gain nothing: the roll of a "
        f"round body hangs on the wings' bases, {lever / mm:.2f} mm from its axis, where "
        f"{lever * np.tan(1 * deg) / um:.0f} µm are 1 deg. Nor does the hull gain, 15 → 70 px/mm: {_from_to(*hulls)}."
    ]


def _about_cameras(found: Findings) -> list[str]:
    rows = found.group("reference", "cameras")
    told = "; ".join(
        f"{each.filming.name.partition(',')[0] if each is found.reference else each.filming.name}: "
        f"yaw {middle(each.fit, ANGLES[0]):.2g}, stroke {middle(each.fit, ANGLES[3]):.2g}, "
        f"{_percent(each.fit.wings_missed)}, {_percent(each.fit.wings_wrong)}"
        for each in rows
    )
    if len(rows) < 2:
        return []
    return [
        "- **Cameras**, yaw and stroke [deg], and the shares of wings that the fit says it does not know, and that are "
        "45 deg off or more all the same (a wing once lost stays lost for some frames: one case is some 5 %): "
        f"{told}."
    ]


def _about_images(found: Findings) -> list[str]:
    rows = found.group("images")
    return [f"- **Images** blurred, noisy, with holes or misplaced: {_between(rows)}."] if rows else []


def _about_shape(found: Findings) -> list[str]:
    told: list[str] = []
    for part, name in (("wings", "wings 5 % larger or smaller"), ("body", "a body 10 % larger or smaller")):
        rows = [each for each in found.group("shape") if each.filming.name.startswith(part)]
        told += [f"{name}: {_between(rows)}"] if rows else []
    return [f"- **Other sizes than those fitted.** {'; '.join(told)}."] if told else []


def _about_wings(found: Findings) -> list[str]:
    rows = found.group("wings")
    told = "; ".join(f"{each.filming.name}: {_from_to(each.hull, each.fit, ANGLES[3:])}" for each in rows)
    return [f"- **Where the wings are**, hull → fit. {told}."] if rows else []


def _about_bands(found: Findings) -> str:
    shares = {name: [100 * held_by_band(each, q) for q in QUANTITIES] for name, each in banded(found).items()}
    told = "; ".join(f"{name}: {min(each):.0f} to {max(each):.0f} %" for name, each in shares.items())
    return (
        f"- **Stated 95 % bands** hold the truth in these shares of frames, least and most of all quantities: {told}."
    )


# ## Claims


def claims(found: Findings) -> list[dict[str, str]]:
    """Section 2 of the review beside what was found, for `flycontrol validate`."""
    hull, fit, centre = found.whole_hull, found.whole, QUANTITIES[0]
    pixels = [in_pixels(rms(part, centre)) for part in (hull, fit)]
    common = {"where": "section 2, Fig. 2", "basis": "simulated"}
    return [
        {"claim": "positions by hull reconstruction: error [px]", "published": "under 3, in reference 1 of the review",
         "ours": f"{pixels[0]:.1f} by the hull alone, {pixels[1]:.2f} by a fitted fly (root mean square)",
         "agreement": "agrees" if pixels[0] < 3 else "fails", **common},
        {"claim": "orientations by hull reconstruction: error [deg]",
         "published": "under 5, in reference 1 of the review",
         "ours": "by our reading of the hull alone " + _angles_listed(hull), "agreement": _judged(hull), **common},
        {"claim": "orientations by a fly fitted to the silhouettes: error [deg]", "published": "not in the review",
         "ours": _angles_listed(fit), "agreement": "shown here", **common},
    ]  # fmt: skip


def _judged(part: Found) -> str:
    """Against 5 deg: root mean squares, else medians."""
    wide, off = ([q.name for q in ANGLES if not error(part, q) < 5] for error in (rms, middle))
    if not wide:
        return "agrees"
    if not off:
        return "roughly: medians, not root mean squares"
    return f"fails: medians not in {', '.join(off)}; single frames err by far more"


def _angles_listed(part: Found) -> str:
    both = ", ".join(f"{q.name} {middle(part, q):.2g} ({rms(part, q):.2g})" for q in ANGLES)
    return f"{both}: median (root mean square)"


def as_numbers(found: Findings) -> str:
    """The numbers as JSON, three digits."""
    rows: dict[str, Any] = {
        "claims": claims(found),
        "whole_flight": _numbers(found.whole),
        "whole_flight_rms_of_18_um_deg": _by_coordinate(found.whole),
        "whole_flight_hull": _numbers(found.whole_hull),
        "bands": {name: {q.name: held_by_band(each, q) for q in QUANTITIES} for name, each in banded(found).items()},
        "filmed": {each.filming.name: {"fit": _numbers(each.fit), "hull": _numbers(each.hull)} for each in found.tried},
    }
    short = json.loads(json.dumps(rows), parse_float=lambda text: float(f"{float(text):.3g}"), parse_constant=_nothing)
    return json.dumps(short, indent=1) + "\n"


def _nothing(_: str) -> None:
    """JSON has no NaN."""


def _numbers(part: Found) -> dict[str, Any]:
    """Everything about one set of frames."""
    return {
        "frames": len(part.error),
        "not_told": part.missed,
        "wings_not_told": part.wings_missed,
        "wings_45_deg_off": part.wings_wrong,
        "rms": {f"{q.name} [{q.unit}]": rms(part, q) for q in QUANTITIES},
        "median": {f"{q.name} [{q.unit}]": middle(part, q) for q in QUANTITIES},
    }


def _by_coordinate(part: Found) -> dict[str, float]:
    """Root mean square error of each of the 18, in [um] and [deg]."""
    unit = np.where(np.isin(np.arange(18), np.arange(3, 12)), deg, um)
    seen = part.error[np.isfinite(part.error[:, 0])] / unit
    each = np.sqrt(np.mean(seen**2, axis=0)) if len(seen) else np.full(18, np.nan)
    return dict(zip(COORDINATES, each.tolist(), strict=True))


def main(folder: Path = FOLDER, plan: Plan | None = None) -> Findings:
    """Film, track, draw and write."""
    found = findings(plan)
    text = as_text(found)
    write_files_atomically(folder, {f"{NAME}.md": text, f"{NAME}.json": as_numbers(found), **draw(found)})
    print(text)
    return found


if __name__ == "__main__":
    main(folder_named(__file__, __doc__, FOLDER))
