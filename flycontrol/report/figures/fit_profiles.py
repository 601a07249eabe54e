"""Profile likelihood of what all recordings share, beside the parabola of the covariance."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from scipy.interpolate import PchipInterpolator

from flycontrol.identify.gains.profile import Profile
from flycontrol.identify.gains.result import Estimate
from flycontrol.report.fit.words import KINDS
from flycontrol.report.style import BAND, EXACT, EXACT_LINE, GUIDE_LINE, PADE_LINE, in_house_style, new_figure

_COLUMNS = 3
_PLAIN = {
    "kp": "K_P/I", "kd": "K_D/I", "ki": "K_I/I", "delay": "delay", "damping": "damping β/I", "limit": "largest torque",
    "paddling_gain": "γ/I",
}  # fmt: skip


def axis_label(kind: str) -> str:
    """Name and unit as written on an axis."""
    return f"{_PLAIN[kind]} [{KINDS[kind][2]}]"


@in_house_style()
def likelihood_profiles(profiles: Mapping[str, Profile], estimates: Mapping[str, Estimate]) -> Figure:
    """Deviance over each unknown: line exact, dashes the parabola of the covariance, band the interval reported."""
    columns = min(_COLUMNS, len(profiles))
    rows = -(-len(profiles) // columns)
    figure = new_figure(0.4 + 1.9 * rows)
    axes = figure.subplots(rows, columns, sharey=True, squeeze=False)
    for ax, (name, profile) in zip(axes.flat, profiles.items(), strict=False):
        _draw(ax, profile, estimates[name])
    for ax in axes.flat[len(profiles) :]:
        ax.set_visible(False)
    for ax in axes[:, 0]:
        ax.set_ylabel("deviance [1]")
    return figure


def _draw(ax: Axes, profile: Profile, e: Estimate) -> None:
    size = KINDS[e.kind][3]
    x = profile.values / size
    low, high = (end / size if np.isfinite(end) else edge for end, edge in ((e.low, x[0]), (e.high, x[-1])))
    ax.axvspan(low, high, color=BAND, linewidth=0, zorder=0)
    room = 0.04 * (max(high, x[-1]) - min(low, x[0]))
    ax.set_xlim(min(low, x[0]) - room, max(high, x[-1]) + room)
    ax.axhline(profile.threshold, **GUIDE_LINE)
    centre = float(profile.values[np.argmin(profile.deviance)])
    if np.isfinite(e.standard_error):
        grid = np.linspace(profile.values[0], profile.values[-1], 200)
        ax.plot(grid / size, ((grid - centre) / e.standard_error) ** 2, **PADE_LINE)
    fine = np.linspace(x[0], x[-1], 200)
    roots = np.sign(profile.values - centre) * np.sqrt(np.maximum(profile.deviance, 0.0))
    ax.plot(fine, PchipInterpolator(x, roots)(fine) ** 2, **EXACT_LINE)
    ax.plot(x, profile.deviance, "o", color=EXACT, markersize=3)
    ax.set_ylim(0, 2.2 * profile.threshold)
    ax.set_xlabel(axis_label(e.kind))
