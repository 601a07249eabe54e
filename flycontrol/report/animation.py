"""Body and wings from three sides as moving pictures: frames through Pillow, a GIF of them."""

from __future__ import annotations

import io
from collections.abc import Iterator
from functools import cache

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from flycontrol.flight.flight_record import FlightRecord
from flycontrol.model.stroke import Side
from flycontrol.report.fly_outlines import VIEWS, FlyOutlines, View, fly_outlines
from flycontrol.report.style import INK, MARK, PULSE, QUIET
from flycontrol.units import mm, ms

FloatArray = NDArray[np.float64]

FRAME_TIME = 60 * ms  #: that a frame stands [s]
_SIDE, _HEAD, _FINE = 240, 44, 2  #: of a view, of the line above it [pixels]; finer while drawing
_MOST_COLOURS = 48
_HALF = 3.6 * mm  #: of a view [m], for the wing length of 2.4 mm
_DOWNWARD = np.array([1.0, -1.0])  #: pictures count downwards
_GRID = "#ececec"
_TRACK = "#3a87c0"
_FILLS = {"left": "#bcd3e6", "right": "#f5d9ab", "body": "#8f8f8f", "head": "#5b2b2b"}
_EDGES = {"left": "#0b3954", "right": "#b46a00", "body": INK, "head": INK}


def gif(record: FlightRecord) -> bytes:
    """The animation as GIF, always the same bytes for the same flight."""
    pictures = frames(record)
    first = next(pictures)
    palette = _palette(record)
    rest = (picture.quantize(palette=palette, dither=Image.Dither.NONE) for picture in pictures)
    buffer = io.BytesIO()
    first.quantize(palette=palette, dither=Image.Dither.NONE).save(
        buffer, format="GIF", save_all=True, append_images=rest, duration=round(FRAME_TIME / ms), loop=0, disposal=1
    )
    return buffer.getvalue()


def frames(record: FlightRecord) -> Iterator[Image.Image]:
    """Pictures of 720 x 284 pixels, one for each instant of the record's film."""
    outlines = fly_outlines(record.planned.experiment.morphology, record.film)
    for k in range(len(record.film.time)):
        yield _frame(record, outlines, k)


def _palette(record: FlightRecord) -> Image.Image:
    """Colours of a few frames, during a pulse too."""
    outlines = fly_outlines(record.planned.experiment.morphology, record.film)
    last = len(record.film.time) - 1
    acting = np.flatnonzero([_acting(record, time) for time in record.film.time])
    chosen = sorted({0, last // 3, 2 * last // 3, last, *(int(k) for k in acting[:1])})
    size = (len(VIEWS) * _SIDE, _SIDE + _HEAD)
    sheet = Image.new("RGB", (size[0], size[1] * len(chosen)))
    for row, k in enumerate(chosen):
        sheet.paste(_frame(record, outlines, k), (0, row * size[1]))
    return sheet.quantize(colors=_MOST_COLOURS, method=Image.Quantize.MAXCOVERAGE)


def _frame(record: FlightRecord, outlines: FlyOutlines, k: int) -> Image.Image:
    size = (len(VIEWS) * _SIDE * _FINE, (_SIDE + _HEAD) * _FINE)
    picture = Image.new("RGB", size, "white")
    draw = ImageDraw.Draw(picture)
    for number, view in enumerate(VIEWS):
        panel = Image.new("RGB", (_SIDE * _FINE, _SIDE * _FINE), "white")
        _draw_view(ImageDraw.Draw(panel), record, outlines, k, view)
        picture.paste(panel, (number * _SIDE * _FINE, _HEAD * _FINE))
    picture.paste(_names_of_views(), (0, _HEAD * _FINE // 2))
    for number in range(1, len(VIEWS)):
        left = number * _SIDE * _FINE
        draw.line([(left, _HEAD * _FINE), (left, size[1])], fill=QUIET, width=1)
    _write_time(draw, record, k)
    return picture.reduce(_FINE)


def _draw_view(draw: ImageDraw.ImageDraw, record: FlightRecord, outlines: FlyOutlines, k: int, view: View) -> None:
    """The fly in the middle, a grid of 1 mm that stands in the world, and the way that it came."""
    scale = _SIDE * _FINE / (2 * _HALF) * (2.4 * mm / record.planned.experiment.morphology.wing_length)
    centre = record.film.position_W[k]
    _draw_grid(draw, np.array([view.across, view.up]) @ centre, scale)
    way = (record.film.position_W[: k + 1] - centre) @ np.array([view.across, view.up]).T
    if k:
        draw.line(_pixels(way, scale), fill=_TRACK, width=_FINE)
    for part in outlines.far_to_near(k, view):
        if part == "head":
            middle, radius = outlines.head_seen(k, view), outlines.head_radius
            corners = [middle - radius * _DOWNWARD, middle + radius * _DOWNWARD]
            draw.ellipse(_pixels(np.array(corners), scale), fill=_FILLS[part], outline=_EDGES[part], width=_FINE)
            continue
        side: Side = "left" if part == "left" else "right"
        shape = outlines.body_seen(k, view) if part == "body" else outlines.wing_seen(k, side, view)
        draw.polygon(_pixels(shape, scale), fill=_FILLS[part], outline=_EDGES[part], width=_FINE)
        if part != "body":  # the leading edge
            draw.line(_pixels(shape[: len(shape) // 2], scale), fill=_EDGES[part], width=2 * _FINE)


def _draw_grid(draw: ImageDraw.ImageDraw, centre: FloatArray, scale: float) -> None:
    reach = _SIDE * _FINE / 2 / scale
    whole = _SIDE * _FINE
    for axis in (0, 1):
        first = np.ceil((centre[axis] - reach) / mm)
        for line in np.arange(first, (centre[axis] + reach) / mm):
            at = whole / 2 + (1 if axis == 0 else -1) * (line * mm - centre[axis]) * scale
            ends = [(at, 0), (at, whole)] if axis == 0 else [(0, at), (whole, at)]
            draw.line(ends, fill=_GRID, width=_FINE)


@cache
def _names_of_views() -> Image.Image:
    """A strip above the views."""
    strip = Image.new("RGB", (len(VIEWS) * _SIDE * _FINE, _HEAD * _FINE // 2), "white")
    for number, view in enumerate(VIEWS):
        ImageDraw.Draw(strip).text((number * _SIDE * _FINE + 6 * _FINE, _FINE), view.name, fill=INK, font=_font())
    return strip


def _write_time(draw: ImageDraw.ImageDraw, record: FlightRecord, k: int) -> None:
    time, phase = record.film.time[k], record.film.phase[k]
    acting = _acting(record, time)
    if acting:
        draw.rectangle([(0, 0), (len(VIEWS) * _SIDE * _FINE, 20 * _FINE)], fill=PULSE)
    words = f"{time / ms:6.1f} ms   wingbeat {phase:4.1f}"
    draw.text((6 * _FINE, 3 * _FINE), words, fill=INK, font=_font())
    draw.text((2 * _SIDE * _FINE + 6 * _FINE, 3 * _FINE), "grid: 1 mm", fill=QUIET, font=_font())
    if acting:
        draw.text((_SIDE * _FINE + 6 * _FINE, 3 * _FINE), "torque from outside", fill=MARK, font=_font())


def _acting(record: FlightRecord, time: float) -> bool:
    return any(pulse.start <= time < pulse.start + pulse.duration for pulse in record.planned.plan.pulses)


def _pixels(points: FloatArray, scale: float) -> list[tuple[float, float]]:
    half = _SIDE * _FINE / 2
    return [(half + scale * float(x), half - scale * float(y)) for x, y in points]


@cache
def _font() -> ImageFont.FreeTypeFont | ImageFont.ImageFont:
    return ImageFont.load_default(12 * _FINE)
