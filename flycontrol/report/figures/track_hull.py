"""A dissected hull from two sides, with the fitted fly's outlines."""

from __future__ import annotations

from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.patheffects import Normal, withStroke

from flycontrol.report.style import INK, in_house_style, new_figure
from flycontrol.report.track.hulls import FILLS, HullPicture, SeenHull
from flycontrol.vision.dissection import BODY, LEFT, REST, RIGHT

_NAMES = {BODY: "body", LEFT: "left wing", RIGHT: "right wing", REST: "none of them: legs, ghosts"}
_WIRE: dict[str, Any] = {"color": INK, "linewidth": 0.6}
_HALO = [withStroke(linewidth=1.5, foreground="white", alpha=0.5), Normal()]


@in_house_style()
def hull_from_two_sides(seen: SeenHull) -> Figure:
    """Voxels coloured by the part that they belong to, in body axes [mm]."""
    wide = [picture.extent[1] - picture.extent[0] for picture in seen.pictures]
    high = [picture.extent[3] - picture.extent[2] for picture in seen.pictures]
    figure = new_figure(min(5.0, 5.9 * max(high) / sum(wide) + 0.9))
    axes = figure.subplots(1, len(seen.pictures), width_ratios=wide)
    for ax, picture in zip(axes, seen.pictures, strict=True):
        _draw(ax, picture, max(high))
    keys: list[Patch | Line2D] = [
        Patch(facecolor=FILLS[label], label=_NAMES[label]) for label, count in seen.voxels.items() if count
    ]
    keys.append(Line2D([], [], label="fitted fly", **_WIRE))
    figure.legend(handles=keys, loc="outside upper left", ncols=5, borderaxespad=0)
    return figure


def _draw(ax: Axes, picture: HullPicture, high: float) -> None:
    ax.imshow(picture.colours, origin="lower", extent=picture.extent, interpolation="none")
    for part, lines in picture.wires.items():
        for number, line in enumerate(lines):
            fine: dict[str, Any] = {**_WIRE, "linewidth": 0.35 if number and part != "body" else _WIRE["linewidth"]}
            ax.plot(line[:, 0], line[:, 1], **fine, path_effects=_HALO)
    ax.set_aspect("equal", adjustable="box")
    middle = (picture.extent[2] + picture.extent[3]) / 2
    ax.set_xlim(picture.extent[0], picture.extent[1])
    ax.set_ylim(middle - high / 2, middle + high / 2)
    ax.set_title(picture.side.name)
    ax.set_xlabel(picture.side.labels[0])
    ax.set_ylabel(picture.side.labels[1])
