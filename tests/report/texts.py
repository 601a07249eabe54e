"""Where the texts of a figure lie: outside it, on one another, or without a unit."""

import re
from itertools import combinations

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.text import Text


def unlabelled(figure):
    """Axis labels without a unit in brackets."""
    panels = [panel for main in figure.axes for panel in (main, *main.child_axes)]
    labels = [label for ax in panels for label in (ax.get_xlabel(), ax.get_ylabel()) if label]
    assert labels
    return [label for label in labels if not re.search(r"\[[^\]]+\]$", label)]


def texts_outside(figure):
    width, height = figure.bbox.width + 1, figure.bbox.height + 1
    return [words for words, b in _drawn(figure) if b.x0 < -1 or b.y0 < -1 or b.x1 > width or b.y1 > height]


def overlapping_texts(figure):
    return [(a, b) for (a, p), (b, q) in combinations(list(_drawn(figure)), 2) if p.overlaps(q)]


def _drawn(figure):
    """Every text that is drawn and its box, a little shrunk: neighbouring tick labels may touch."""
    FigureCanvasAgg(figure).draw()
    renderer = figure.canvas.get_renderer()
    texts = [text for legend in figure.legends for text in legend.get_texts()]
    for ax in [panel for main in figure.axes for panel in (main, *main.child_axes)]:
        legend = ax.get_legend()
        texts += [*ax.texts, ax.title, ax._left_title, ax.xaxis.label, ax.yaxis.label]
        texts += [*(legend.get_texts() if legend else []), *_ticks(ax.xaxis), *_ticks(ax.yaxis)]
    for text in texts:
        if text.get_text().strip():
            yield text.get_text(), Text.get_window_extent(text, renderer).shrunk(0.98, 0.9)


def _ticks(axis):
    low, high = sorted(axis.get_view_interval())
    for tick in [*axis.get_major_ticks(), *axis.get_minor_ticks()]:
        if low <= tick.get_loc() <= high:
            yield from (label for label in (tick.label1, tick.label2) if label.get_visible())
