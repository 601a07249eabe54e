"""What do the numbers mean that another tracker left beside its silhouettes?

Run with `python analyses/conventions_of_another_tracker.py`; the silhouettes are looked for in $FLYCONTROL_DATA, else
in ../shared/data. It prints a table and writes nothing; `beside_another_tracker.py` goes on from here.
"""

from dataclasses import dataclass, replace
from itertools import product
from typing import Literal

import numpy as np
from _by_hand import DATA, measured, nothing_named
from _drawn_flies import Drawing, Masks, Placed, drawing_of, overlap, placed
from numpy.typing import NDArray
from scipy.interpolate import BSpline
from scipy.spatial.transform import Rotation

from flycontrol.io.movies.open_films import open_films
from flycontrol.model.camera import Camera
from flycontrol.model.camera_forms import camera_from_dlt
from flycontrol.units import mm
from flycontrol.vision.footage import FilmedFrame, Footage

FloatArray = NDArray[np.float64]
FILE = "silhouettes/exp095_first47.npz"

# ## The file
#
# A fly takes off before three cameras at 6,000 frames a second. 47 frames, of which the first are quiet, are kept as
# silhouettes with legs in them, along with the calibration and with what the tracker of Fontaine et al. (2009, J Exp
# Biol 212) made of them: fifteen numbers a frame. World z points down in it; half a turn about x sets it upright.

UPRIGHT = np.diag([1.0, -1.0, -1.0])


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Take:
    """What the file has, N frames seen by C cameras; lengths in [m], world z up."""

    frames: NDArray[np.int64]  #: (N,) their numbers
    filmed: list[FilmedFrame]  #: N, legs and all
    cameras: list[Camera]
    state: FloatArray  #: (N, 15) of the other tracker: position [mm], three quaternions, world z down
    model: dict[str, FloatArray]  #: its fly

    @property
    def masks(self) -> list[Masks]:
        """Silhouettes without dust."""
        return [tuple(silhouette.mask for silhouette in frame.silhouettes) for frame in self.filmed]


def read_take() -> Take:
    """Silhouettes, cameras and the other tracker's answer."""
    measured(DATA, FILE)
    path = DATA / FILE
    opened = open_films([path])
    with np.load(path) as file:
        found = {name: file[name] for name in file.files if name in ("frames", "DLT", "xh") or "model" in name}
    middle = UPRIGHT @ found["xh"][:, :3].mean(axis=0) * mm
    cameras = [
        camera_from_dlt(L, film.shape, name=f"camera {k + 1}").moved(UPRIGHT).facing(middle)
        for k, (L, film) in enumerate(zip(found["DLT"].T, opened.films, strict=True))
    ]
    assert opened.frame_rate
    footage = Footage(films=opened.films, frame_rate=opened.frame_rate, backgrounds=opened.backgrounds)
    return Take(
        frames=found["frames"],
        filmed=list(footage),
        cameras=cameras,
        state=found["xh"],
        model={name: value for name, value in found.items() if name.startswith("model_")},
    )


# ## The other tracker's fly
#
# The file does not say how its arrays are posed; the tracker's published source does (`flymodQ.m` and what it calls, in
# the public repository FlyRanch/flytracker at 7ec22ba). The body's radius and the head's are cubic B-splines over their
# lengths, clamped at the ends; the head sits at the end of the body, both straight along x, scaled by `bodyscale`, the
# origin in the middle of the body without the head. The wing's outline is a closed uniform cubic B-spline whose base
# lies at (-1.294, 0.1225); scaled by `wingscale` it hangs at 0.2021, +-0.1055 and -0.1477 of the length of head and
# body. The state is position, body, left and right wing, quaternions with the scalar last, wings relative to the body.
# That is how the source reads; whether this file was written by it, its silhouettes shall say.

BASE_IN_OUTLINE = np.array([-1.294, 0.1225])
JOINT = np.array([0.2021, 0.1055, -0.1477])


def spline(points: FloatArray, knots: FloatArray, at: FloatArray) -> FloatArray:
    """Cubic B-spline."""
    return np.asarray(BSpline(knots, points, 3)(at))


def clamped(points: FloatArray, at: FloatArray) -> FloatArray:
    """Cubic B-spline over 0 to 1 that starts at the first point and ends at the last."""
    return spline(points, np.concatenate([[0.0] * 3, np.linspace(0, 1, len(points) - 2), [1.0] * 3]), at)


def other_drawing(model: dict[str, FloatArray]) -> tuple[Drawing, float]:
    """The other tracker's fly, and how far ahead of its origin the centre of its body's volume lies [m]."""
    scale = float(model["model_bodyscale"].item()) * mm
    body, head = (float(model[f"model_{part}len"].item()) for part in ("body", "head"))
    at = np.linspace(0, 1, 60)
    profile = np.concatenate([
        np.stack([(at - 0.5) * body, clamped(model["model_bodyrad"][:, 0], at)], axis=1),
        np.stack([body / 2 + at[1:] * head, clamped(model["model_headrad"][:, 0], at[1:])], axis=1),
    ])  # fmt: skip
    corners = model["model_wing"]  # its last three repeat the first three
    outline = spline(corners, np.arange(len(corners) + 4.0), np.linspace(3, len(corners), 120, endpoint=False))
    outline = (outline - BASE_IN_OUTLINE) * float(model["model_wingscale"].item()) * mm
    drawing = drawing_of(profile * scale, 1.2, outline)
    return drawing, float(profile[0, 0] * scale - drawing.body[0, 0])


@dataclass(frozen=True, slots=True, kw_only=True)
class Reading:
    """What the twelve numbers after a position may mean."""

    first: Literal["left", "right"] = "left"  #: wing
    scalar: Literal["last", "first"] = "last"
    relative: Literal["body", "world"] = "body"  #: what the wings' quaternions are seen from
    inverse: bool = False

    def __str__(self) -> str:
        turned = ", inverse" if self.inverse else ""
        return f"{self.first} wing first, scalar {self.scalar}, wings relative to the {self.relative}{turned}"


def rotations(quaternions: FloatArray, reading: Reading) -> FloatArray:
    """(N, 3, 3) of (N, 4)."""
    turn = Rotation.from_quat(quaternions, scalar_first=reading.scalar == "first")
    return (turn.inv() if reading.inverse else turn).as_matrix()


def other_flies(take: Take, drawing: Drawing, ahead: float, reading: Reading) -> list[Placed]:
    """Where the other tracker has the fly."""
    body = rotations(take.state[:, 3:7], reading)
    pair = [rotations(take.state[:, k : k + 4], reading) for k in (7, 11)]
    if reading.first == "right":
        pair.reverse()
    length = np.ptp(drawing.body[:, 0])
    flies = []
    for k, position in enumerate(take.state[:, :3] * mm):
        R = UPRIGHT @ body[k]
        bases, wings = [], []
        for mirror, turns in zip((-1.0, 1.0), pair, strict=True):
            W = R @ turns[k] if reading.relative == "body" else UPRIGHT @ turns[k]
            wings.append(W @ np.array([[0.0, 1.0, 0.0], [mirror, 0.0, 0.0], [0.0, 0.0, -1.0]]))
            bases.append(UPRIGHT @ position + R @ (JOINT * [1.0, mirror, 1.0]) * length)
        centre = UPRIGHT @ position + R[:, 0] * ahead
        flies.append(placed(centre, R, np.array(bases), np.array(wings), drawing))
    return flies


# ## What the silhouettes say
#
# Draw the other tracker's own fly by every reading: either wing first, the scalar first or last, wings relative to the
# body or to the world, rotations or their inverses. One reading alone looks like the silhouettes, with an intersection
# over union of 0.64, and no other exceeds 0.40. The origin is right as well: moved by 0.1 mm, 3.5 pixels, along its
# axes the fly looks less like them, but for a move towards the legs, which its drawing lacks.


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ReadingRow:
    """The other fly by one reading."""

    reading: Reading
    overlap: FloatArray  #: (C,) intersection over union with the silhouettes, mean over frames
    flies: list[Placed]


def reading_rows(take: Take) -> list[ReadingRow]:
    """All sixteen, best first."""
    drawing, ahead = other_drawing(take.model)
    rows = []
    for first, scalar, relative, inverse in product(
        ("left", "right"), ("last", "first"), ("body", "world"), (False, True)
    ):
        reading = Reading(first=first, scalar=scalar, relative=relative, inverse=inverse)
        flies = other_flies(take, drawing, ahead, reading)
        seen = [overlap(drawing, fly, masks, take.cameras) for fly, masks in zip(flies, take.masks, strict=True)]
        rows.append(ReadingRow(reading=reading, overlap=np.mean(seen, axis=0), flies=flies))
    return sorted(rows, key=lambda row: -row.overlap.mean())


def moved_overlaps(take: Take, flies: list[Placed], step: float = 0.1 * mm) -> FloatArray:
    """(3, 2) mean overlap of a fly moved along its body's axes, back and forth."""
    drawing = other_drawing(take.model)[0]
    found = np.empty((3, 2))
    for axis, sign in product(range(3), (-1, 1)):
        seen = []
        for fly, masks in zip(flies, take.masks, strict=True):
            shift = sign * step * fly.body[:, axis]
            moved = replace(fly, position=fly.position + shift, wing_centres=fly.wing_centres + shift)
            seen.append(overlap(drawing, moved, masks, take.cameras))
        found[axis, (sign + 1) // 2] = np.mean(seen)
    return found


def main() -> list[ReadingRow]:
    """Print the table."""
    take = read_take()
    rows = reading_rows(take)
    for row in rows:
        print(f"{row.overlap.mean():.3f} ({', '.join(f'{x:.2f}' for x in row.overlap)})  {row.reading}")
    print("moved by 0.1 mm along its axes, back and forth:", moved_overlaps(take, rows[0].flies).round(3).tolist())
    return rows


if __name__ == "__main__":
    nothing_named(__file__, __doc__)
    main()
