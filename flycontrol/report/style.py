"""The house style of all figures, and how a figure becomes SVG inside a page: the same bytes for the same figure.

Colours differ in lightness, so that they survive greyscale, and every pair that shares a panel differs in line style or
marker too. Labels are plain text, no mathematics set by matplotlib, so that the page's own fonts can show them.
"""

from __future__ import annotations

import io
import re
from typing import Any

import matplotlib.style
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, NullFormatter

WIDTH = 7.0  #: of a figure [inch]

INK = "#1a1a1a"
EXACT = "#0b3954"  #: dark blue, solid: exact
PADE = "#e08a00"  #: light orange, dashed: approximated
MARK = "#c8323c"  #: red, middle lightness: margins, limits and where a boundary is crossed
QUIET = "#7d7d7d"  #: guide lines
BAND = "#e6edf1"  #: tolerance band
PULSE = "#f4dfc6"  #: while the pulse acts
FORBIDDEN = "#f1efec"  #: where a loop is unstable
STRENGTHS = ("#9cc9e3", "#69add5", "#3a87c0", "#1c5c98", "#0a2d57")  #: weak to strong, light to dark

EXACT_LINE: dict[str, Any] = {"color": EXACT, "linewidth": 1.6}
PADE_LINE: dict[str, Any] = {"color": PADE, "linewidth": 1.6, "linestyle": (0, (4, 2))}
GUIDE_LINE: dict[str, Any] = {"color": QUIET, "linewidth": 0.7, "linestyle": (0, (1, 2))}

_HOUSE: dict[str, Any] = {
    "font.family": "DejaVu Sans",  # comes with matplotlib, hence the same layout everywhere
    "font.size": 8.5,
    "axes.labelsize": 8.5,
    "axes.titlesize": 9,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.edgecolor": INK,
    "axes.labelcolor": INK,
    "axes.linewidth": 0.7,
    "xtick.color": INK,
    "ytick.color": INK,
    "xtick.labelsize": 8,
    "ytick.labelsize": 8,
    "text.color": INK,
    "legend.frameon": False,
    "legend.fontsize": 8,
    "figure.constrained_layout.use": True,
    "svg.fonttype": "none",
    "svg.hashsalt": "flycontrol",
    "path.simplify_threshold": 0.05,
}
_FONTS = (
    "'Helvetica Neue', Helvetica, Arial, 'Liberation Sans', 'DejaVu Sans', sans-serif"  # narrower than the layout's
)


def in_house_style() -> Any:
    """Decorate a function that draws a figure: the house style, whatever the user's own matplotlibrc says."""
    return matplotlib.style.context(["default", _HOUSE])


def new_figure(height: float) -> Figure:
    """Create an empty figure of the page's width, with no global state behind it; the height is in inches."""
    return Figure(figsize=(WIDTH, height))


def plain_log_ticks(ax: Axes, which: str = "x") -> None:
    """Label a logarithmic axis with 1, 10, 100 instead of powers."""
    axis = ax.xaxis if which == "x" else ax.yaxis
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axis.set_minor_formatter(NullFormatter())


def wingbeat_axis(ax: Axes, frequency: float, which: str = "x") -> None:
    """Second axis in wingbeats for an axis in ms; the frequency is in 1/s."""
    turn = (lambda t: t * frequency * 1e-3, lambda n: n / frequency * 1e3)
    second = ax.secondary_xaxis("top", functions=turn) if which == "x" else ax.secondary_yaxis("right", functions=turn)
    (second.set_xlabel if which == "x" else second.set_ylabel)("time [wingbeats]")
    second.spines[["top", "right"]].set_visible(True)


def svg(figure: Figure, name: str, title: str) -> str:
    """Inline SVG of a figure: no prolog, metadata or namespaces, ids that begin with `name`, coordinates to 0.01 pt.

    Parameters
    ----------
    name
        Unique within the page.
    title
        Read aloud instead of the figure.
    """
    buffer = io.StringIO()
    with in_house_style():
        figure.savefig(buffer, format="svg", metadata={"Date": None, "Creator": None, "Format": None, "Type": None})
    text = buffer.getvalue()
    text = text[text.index("<svg") :]
    text = re.sub(r"<!--.*?-->\s*|<metadata>.*?</metadata>\s*", "", text, flags=re.DOTALL)
    text = text.replace("xlink:href=", "href=").replace("'DejaVu Sans'", _FONTS)
    text = _with_prefix(text, name)
    text = re.sub(r"<[^>]+>", lambda tag: re.sub(r"-?\d+\.\d{3,}", _rounded, tag[0]), text)
    _, _, body = text.partition(">")
    box = f'viewBox="0 0 {figure.get_figwidth() * 72:g} {figure.get_figheight() * 72:g}" preserveAspectRatio="xMinYMid"'
    return f'<svg {box} role="img" aria-label="{_attribute(title)}">{body.strip()}'


def _with_prefix(text: str, name: str) -> str:
    text = re.sub(r'\bid="', f'id="{name}-', text)
    text = re.sub(r'href="#', f'href="#{name}-', text)
    return re.sub(r"url\(#", f"url(#{name}-", text)


def _rounded(number: re.Match[str]) -> str:
    return f"{round(float(number[0]), 2):g}"


def _attribute(text: str) -> str:
    return text.replace("&", "&amp;").replace('"', "&quot;").replace("<", "&lt;").replace(">", "&gt;")


def colours_by_strength(count: int) -> list[str]:
    """A colour for each strength, light to dark; more strengths than colours share the darkest."""
    return [STRENGTHS[min(k, len(STRENGTHS) - 1)] for k in range(count)]
