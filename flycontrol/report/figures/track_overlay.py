"""Each camera's image of one frame, with the contours of the fitted fly and of the hull."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle
from matplotlib.patheffects import Normal, withStroke
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter

from flycontrol.report.figures.track_panels import PART_LINES
from flycontrol.report.style import INK, MARK, QUIET, WIDTH, in_house_style, new_figure
from flycontrol.report.track.overlays import FrameOverlay, ViewOverlay

BoolArray = NDArray[np.bool_]

HULL_LINE: dict[str, Any] = {"color": "#7b2d8e", "linewidth": 0.7, "linestyle": "solid"}
_HALO = [withStroke(linewidth=2.4, foreground="white", alpha=0.75), Normal()]
_IN_A_ROW = 3  #: views
_EVERY = 3  #: manieth point of a contour that is kept: about one a pixel


@in_house_style()
def frame_overlay(overlay: FrameOverlay) -> Figure:
    """Windows of one size, pixels as they are; lines in points finer than pixels."""
    rows = -(-len(overlay.views) // _IN_A_ROW)
    columns = -(-len(overlay.views) // rows)
    side = (WIDTH - 0.1) / max(columns, _IN_A_ROW)
    figure = new_figure(rows * (side + 0.24) + 0.25)
    axes = figure.subplots(rows, columns, squeeze=False)
    for ax in axes.flat[len(overlay.views) :]:
        ax.set_axis_off()
    for number, (ax, view) in enumerate(zip(axes.flat, overlay.views, strict=False)):
        _draw(ax, view, number)
    present = {name for view in overlay.views for name in view.parts}
    keys = [Line2D([], [], label=_NAMES[part], **PART_LINES[part]) for part in PART_LINES if part in present]
    if any(view.hull is not None for view in overlay.views):
        keys.append(Line2D([], [], label="edge of the hull", **HULL_LINE))
    if keys:
        figure.legend(handles=keys, loc="outside upper left", ncols=4, borderaxespad=0)
    return figure


_NAMES = {"body": "fitted body", "left": "left wing", "right": "right wing"}


def _draw(ax: Axes, view: ViewOverlay, number: int) -> None:
    left, right, bottom, top = view.window.edges
    image = ax.imshow(
        view.image, cmap="gray", vmin=0, vmax=255, interpolation="none", extent=(left, right, bottom, top)
    )
    image.set_gid(f"image-{number}")  # two images that are alike would share an id
    if view.hull is not None:
        _contour(ax, view, view.hull, HULL_LINE, halo=False)
    for part, mask in view.parts.items():
        _contour(ax, view, mask, PART_LINES[part], halo=True)
    ax.set_xlim(left, right)
    ax.set_ylim(bottom, top)
    ax.set_xticks([])
    ax.set_yticks([])
    ax.spines[["top", "right"]].set_visible(True)
    ax.spines[:].set_color(QUIET)
    ax.set_title(view.name, fontsize=8.5, fontweight="normal")
    if view.note:
        ax.text(0.5, 0.5, view.note, transform=ax.transAxes, ha="center", va="center", color=MARK)
    _scale_bar(ax, view)


def _contour(ax: Axes, view: ViewOverlay, mask: BoolArray, line: dict[str, Any], *, halo: bool) -> None:
    """The border of a mask whose points are finer than pixels, rounded by less than a pixel."""
    if not mask.any():
        return
    framed = gaussian_filter(np.pad(mask, 2).astype(np.float64), 1.0)
    found = ax.contour(framed, levels=[0.5])
    found.remove()
    for outline in found.get_paths()[0].to_polygons(closed_only=False):
        polygon = np.asarray(outline, dtype=np.float64)
        points = np.concatenate([polygon[:-1:_EVERY], polygon[-1:]])
        points = (points - 1.5) / view.zoom - 0.5 + np.array([view.window.left, view.window.top])
        ax.plot(points[:, 0], points[:, 1], **line, path_effects=_HALO if halo else None)


def _scale_bar(ax: Axes, view: ViewOverlay) -> None:
    """A millimetre at the fly, or less where that is too long, in the emptiest corner."""
    if view.pixels_per_mm is None:
        return
    length = next((mm for mm in (1.0, 0.5, 0.2, 0.1) if mm * view.pixels_per_mm < 0.4 * view.window.width), 0.05)
    left, right, bottom, top = view.window.edges
    side, wide = right - left, length * view.pixels_per_mm
    on_right, on_top = _emptiest_corner(view)
    x = right - 0.05 * side - wide if on_right else left + 0.05 * side
    y = top + 0.12 * side if on_top else bottom - 0.05 * side
    ax.add_patch(Rectangle((x, y), wide, 0.012 * side, facecolor=INK, edgecolor="white", linewidth=0.5))
    ax.text(
        x + wide / 2, y - 0.015 * side, f"{length:g} mm", ha="center", va="bottom", fontsize=7.5,
        path_effects=[withStroke(linewidth=2, foreground="white")],
    )  # fmt: skip


def _emptiest_corner(view: ViewOverlay) -> tuple[bool, bool]:
    """Whether on the right and whether on top fewest points of fly and silhouette are."""
    busy = (view.image < view.image.max() - 30).astype(np.float64)
    for mask in view.parts.values():
        v, u = (np.nonzero(mask)[axis] / view.zoom for axis in (0, 1))
        busy[np.minimum(v.astype(int), len(busy) - 1), np.minimum(u.astype(int), busy.shape[1] - 1)] = 1
    high, wide = max(len(busy) // 6, 1), max(busy.shape[1] * 2 // 5, 1)
    corners = {
        (True, False): busy[-high:, -wide:], (False, False): busy[-high:, :wide], (True, True): busy[:high, -wide:],
        (False, True): busy[:high, :wide],
    }  # fmt: skip
    return min(corners, key=lambda corner: float(corners[corner].mean()))
