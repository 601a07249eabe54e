"""The views of a tracked flight as moving pictures: what was filmed, with the contours of the fitted fly, as a GIF."""

from __future__ import annotations

import io
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np
from matplotlib.colors import to_rgb
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont
from scipy.ndimage import binary_dilation, binary_erosion, uniform_filter1d

from flycontrol.report.style import INK, MARK, QUIET
from flycontrol.report.track.overlays import pose_at
from flycontrol.report.track.views import Window, backdrop, extent_of_fly, largest_side, part_masks, square_about
from flycontrol.units import ms
from flycontrol.vision.footage import FilmedFrame
from flycontrol.vision.tracked_flight import TrackedFlight

FloatArray = NDArray[np.float64]
PixelArray = NDArray[np.uint8]

FRAME_TIME = 80 * ms  #: that a picture stands [s]
HEAVIEST = 1_400_000  #: bytes of an animation
_SIDE, _HEAD, _NAME = 288, 24, 18  #: of a view, of the line above all, of a view's name [pixels]
_IN_A_ROW = 3  #: views
_AROUND = 8  #: pixels of the film around the fly
_GREYS = 12  #: levels of filmed images that are told apart
_CALM = 9  #: pictures over which the window's way is evened
_LINES = {"body": INK, "left": "#1c5c98", "right": "#b46a00"}


@dataclass(frozen=True, slots=True, kw_only=True)
class Stage:
    """What all pictures of an animation share: where each view's window is in each of them."""

    windows: tuple[tuple[Window, ...], ...]  #: picture by picture, view by view
    columns: int
    rows: int

    @property
    def size(self) -> tuple[int, int]:
        """Width and height of a picture [pixels]."""
        return self.columns * _SIDE, _HEAD + self.rows * (_SIDE + _NAME)


def stage_of(flight: TrackedFlight, frames: NDArray[np.int_]) -> Stage:
    """Windows of one size that follow the fly calmly; where it is lost they stay where it was."""
    extents = np.full((len(frames), len(flight.cameras), 2, 2), np.nan)
    for row, k in enumerate(frames):
        pose = pose_at(flight, int(k))
        if pose is not None:
            extents[row] = [extent_of_fly(flight.fly.shape, pose, camera) for camera in flight.cameras]
    middles = extents.mean(axis=2)
    sides = np.max(extents[:, :, 1] - extents[:, :, 0], axis=(1, 2))
    if np.all(np.isnan(sides)):
        whole = [np.array(camera.shape[::-1]) for camera in flight.cameras]
        side, middles[:] = int(max(size.max() for size in whole)), np.array(whole) / 2
    else:
        middles = _calmed(middles)
        side = int(np.ceil(np.nanpercentile(sides, 95) + np.nanmax(_strayed(extents, middles)))) + 2 * _AROUND
    side = min(side, largest_side(flight.cameras))
    rows = -(-len(flight.cameras) // _IN_A_ROW)
    return Stage(
        windows=tuple(tuple(square_about(middle, side) for middle in row) for row in middles),
        columns=-(-len(flight.cameras) // rows),
        rows=rows,
    )


def picture_of(flight: TrackedFlight, frame: FilmedFrame, k: int, stage: Stage, number: int) -> Image.Image:
    """Frame k of the flight, picture `number` of its animation, in a few colours."""
    picture = Image.new("RGB", stage.size, "white")
    draw = ImageDraw.Draw(picture)
    for c, camera in enumerate(flight.cameras):
        row, column = divmod(c, stage.columns)
        left, top = column * _SIDE, _HEAD + row * (_SIDE + _NAME)
        panel = _panel(flight, frame, k, c, stage.windows[number][c])
        picture.paste(Image.fromarray(panel), (left, top + _NAME))
        draw.text((left + 6, top + 1), camera.name, fill=QUIET, font=_font(12))
        draw.rectangle([(left, top + _NAME), (left + _SIDE - 1, top + _NAME + _SIDE - 1)], outline=QUIET)
    _write(draw, flight, k, bool(frame.images))
    return picture.quantize(palette=_palette(), dither=Image.Dither.NONE)


def gif(pictures: Sequence[Image.Image]) -> bytes:
    """An animation of these pictures, or of every second, third, ... of them if that would be too heavy."""
    every = 1
    while len(made := _gif(pictures[::every], every)) > HEAVIEST and 2 * every < len(pictures):
        every += 1
    return made


def _gif(pictures: Sequence[Image.Image], every: int) -> bytes:
    buffer = io.BytesIO()
    pictures[0].save(
        buffer, format="GIF", save_all=True, append_images=pictures[1:], loop=0,
        duration=round(FRAME_TIME / ms) * min(every, 3), disposal=1, optimize=False,
    )  # fmt: skip
    return buffer.getvalue()


@cache
def _palette() -> Image.Image:
    """Grey levels, and the colours of lines."""
    greys = [[g] * 3 for g in np.rint(np.linspace(0, 255, 2 * _GREYS)).astype(int)]
    colours = [[round(255 * part) for part in to_rgb(colour)] for colour in (*_LINES.values(), MARK)]
    picture = Image.new("P", (1, 1))
    picture.putpalette([int(value) for colour in (*greys, *colours) for value in colour])
    return picture


def _panel(flight: TrackedFlight, frame: FilmedFrame, k: int, c: int, window: Window) -> PixelArray:
    """(side, side, 3) image of a window, enlarged without smoothing, and the edges of the fly's parts."""
    camera, zoom = flight.cameras[c], _SIDE / window.width
    grey = backdrop(frame, c, window, camera.shape)
    if frame.images and np.asarray(frame.images[c]).dtype != np.bool_:
        grey = (np.rint(grey / 255 * (_GREYS - 1)) * (255 / (_GREYS - 1))).astype(np.uint8)
    at = np.minimum(((np.arange(_SIDE) + 0.5) / zoom).astype(int), window.width - 1)
    colours = np.repeat(grey[at[:, None], at][:, :, None], 3, axis=2)
    pose = pose_at(flight, k)
    for part, mask in ({} if pose is None else part_masks(flight.fly.shape, pose, camera, window, zoom)).items():
        here = colours[: mask.shape[0], : mask.shape[1]]
        around = np.asarray(binary_dilation(mask), dtype=np.bool_)
        within = np.asarray(binary_erosion(mask, iterations=2), dtype=np.bool_)
        here[around & ~mask] = 255
        here[mask & ~within] = [round(255 * level) for level in to_rgb(_LINES[part])]
    return colours


def _write(draw: ImageDraw.ImageDraw, flight: TrackedFlight, k: int, filmed: bool) -> None:
    status = flight.track.status[k]
    draw.text((6, 3), f"frame {flight.numbers[k]}   {flight.time[k] / ms:.2f} ms", fill=INK, font=_font(14))
    words = status if filmed else f"{status}, no image"
    draw.text((200, 3), words, fill=INK if status == "tracked" else MARK, font=_font(14))


def _calmed(middles: FloatArray) -> FloatArray:
    """(F, C, 2) with gaps filled by what is next to them, and evened."""
    known = np.flatnonzero(np.all(np.isfinite(middles), axis=(1, 2)))
    nearest = known[np.argmin(np.abs(np.arange(len(middles))[:, None] - known), axis=1)]
    return np.asarray(uniform_filter1d(middles[nearest], min(_CALM, len(middles)), axis=0, mode="nearest"))


def _strayed(extents: FloatArray, middles: FloatArray) -> FloatArray:
    """(F,) how far the fly is from the middle of its window at the most [px]."""
    return np.max(np.abs(extents.mean(axis=2) - middles), axis=(1, 2))


@cache
def _font(size: int) -> ImageFont.FreeTypeFont | ImageFont.ImageFont:
    return ImageFont.load_default(size)
