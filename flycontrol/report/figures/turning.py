"""A real flight against Eq. 3: paddling, yaw rate and yaw acceleration over time, wingbeat by wingbeat."""

from __future__ import annotations

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from flycontrol.identify.turns import TurnIdentification
from flycontrol.report.style import BAND, EXACT, GUIDE_LINE, PADE_LINE, in_house_style, new_figure
from flycontrol.units import deg, ms


@in_house_style()
def turning(found: TurnIdentification) -> Figure:
    """d_alpha [deg], yaw rate [rad/s] and yaw acceleration [rad/s^2], measured and by the identified plant."""
    figure = new_figure(5.4)
    paddled, rate, acceleration = figure.subplots(3, 1, sharex=True)
    for ax in (paddled, rate, acceleration):
        ax.axhline(0, **GUIDE_LINE)
        for turn in found.turns:
            ax.axvspan(turn.start / ms, turn.end / ms, color=BAND, linewidth=0, zorder=0)
            ax.axvline(turn.start / ms, color="white", linewidth=1.5, zorder=0.5)
    measured = {"color": EXACT, "linewidth": 1.2, "marker": "o", "markersize": 3, "label": "measured"}
    modelled = {**PADE_LINE, "label": "Eq. 3, from the paddling alone"}
    paddled.errorbar(
        found.time / ms, found.d_alpha / deg, yerr=found.d_alpha_noise / deg, color=EXACT, marker="o", markersize=3,
        linewidth=1.2, elinewidth=0.6,
    )  # fmt: skip
    rate.plot(found.reversals / ms, found.yaw_rate_at_reversals, **measured)
    if found.plant is not None:
        rate.plot(found.reversals / ms, found.plant.simulated_yaw_rate, **modelled)
        acceleration.plot(found.time / ms, found.plant.acceleration, **measured)
        modelled["label"] = "Eq. 3, from paddling and yaw rate"
        acceleration.plot(found.time / ms, found.plant.modelled_acceleration, **modelled)
    _labels(paddled, rate, acceleration)
    _number_turns(paddled, found)
    figure.align_ylabels([paddled, rate, acceleration])
    return figure


def _labels(paddled: Axes, rate: Axes, acceleration: Axes) -> None:
    paddled.set_ylabel("paddling Δα [deg]")
    rate.set_ylabel("yaw rate [rad/s]")
    acceleration.set_ylabel("yaw acceleration [rad/s²]")
    acceleration.set_xlabel("time [ms]")
    for ax in (rate, acceleration):
        if ax.get_legend_handles_labels()[0]:
            ax.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=2, borderaxespad=0.1)


def _number_turns(ax: Axes, found: TurnIdentification) -> None:
    low, high = ax.get_ylim()
    ax.set_ylim(low, high + 0.14 * (high - low))
    for number, turn in enumerate(found.turns, start=1):
        middle = 0.5 * (turn.start + turn.end) / ms
        ax.text(middle, high + 0.13 * (high - low), str(number), ha="center", va="top", weight="bold")
