"""Yaw after a pulse at several strengths, the fly's torque, and what the Pade approximation gets wrong."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.legend_handler import HandlerTuple
from matplotlib.lines import Line2D

from flycontrol.model.stability import StabilityResult
from flycontrol.model.study import YawRecoveries
from flycontrol.report.style import (
    BAND,
    GUIDE_LINE,
    MARK,
    PADE,
    PULSE,
    colours_by_strength,
    in_house_style,
    new_figure,
    wingbeat_axis,
)
from flycontrol.units import deg, ms

_NANO = 1e-9
_LATE = 0.55  #: of the axis, from which words stand on the left


@in_house_style()
def recoveries(found: YawRecoveries, result: StabilityResult, wingbeat_frequency: float) -> Figure:
    """Three panels over time: yaw exact and Pade, the fly's torque, Pade's error (after Fig. 7c, d).

    Parameters
    ----------
    found
        The responses.
    result
        Gives inertia, pulse, tolerance and the recovery time that is marked.
    wingbeat_frequency
        For the second time axis [1/s].
    """
    figure = new_figure(6.2)
    yaw, torque, error = figure.subplots(3, 1, sharex=True, height_ratios=[2.4, 1.5, 0.9])
    time = found.time / ms
    inertia = result.loop.plant.inertia
    for ax in (yaw, torque, error):
        ax.axvspan(0, result.task.duration / ms, color=PULSE, linewidth=0, zorder=0)
        ax.axhline(0, **GUIDE_LINE)
    for k, colour in enumerate(colours_by_strength(len(found.peaks))):
        yaw.plot(time, found.yaw[k] / deg, color=colour, linewidth=1.7)
        yaw.plot(time, found.yaw_pade[k] / deg, color=PADE, linewidth=0.9, linestyle=(0, (3, 3)))
        torque.plot(time, found.torque[k] * inertia / _NANO, color=colour, linewidth=1.7)
        error.plot(time, (found.yaw_pade[k] - found.yaw[k]) / deg, color=colour, linewidth=1.3)
    _write_strengths(yaw, found)
    _mark_band(yaw, found, result)
    middle = sum(torque.get_ylim()) / 2
    torque.text(result.task.duration / ms / 2, middle, "pulse", ha="center", va="center", rotation=90)
    _tell_lines(yaw, found)
    yaw.set_ylabel("yaw [deg]")
    yaw.set_ylim(top=1.12 * float(found.yaw.max()) / deg)
    torque.set_ylabel("fly's torque [nN m]")
    error.set_ylabel("error [deg]")
    error.set_xlabel("time since pulse onset [ms]")
    error.set_xlim(0, time[-1])
    wingbeat_axis(yaw, wingbeat_frequency)
    figure.align_ylabels([yaw, torque, error])
    return figure


def _tell_lines(ax: Axes, found: YawRecoveries) -> None:
    """A legend with the shades that are drawn."""
    shades = tuple(Line2D([], [], color=colour, linewidth=1.7) for colour in colours_by_strength(len(found.peaks)))
    near = Line2D([], [], color=PADE, linewidth=0.9, linestyle=(0, (3, 3)))
    words = ["exact delay, darker for stronger pulses", f"Padé, order {found.pade_order}"]
    every = {tuple: HandlerTuple(ndivide=None, pad=0.0)}
    ax.legend([shades, near], words, loc="upper right", handler_map=every, handlelength=3.2)


def _write_strengths(ax: Axes, found: YawRecoveries) -> None:
    """Peak deflections above the peaks."""
    for k, peak in enumerate(found.peaks):
        when = float(found.time[found.yaw[k].argmax()]) / ms
        ax.annotate(
            f"{peak / deg:.0f}°",
            (when, peak / deg),
            xytext=(0, 2),
            textcoords="offset points",
            ha="center",
            va="bottom",
        )


def _mark_band(ax: Axes, found: YawRecoveries, result: StabilityResult) -> None:
    """Tolerance band, and where the nominal recovery ends, on the side that yaw enters from."""
    tolerance = result.task.tolerance / deg
    ax.axhspan(-tolerance, tolerance, color=BAND, linewidth=0, zorder=0)
    if result.recovery_time is not None:
        end = result.recovery_time / ms
        nearest = found.yaw[np.argmin(np.abs(found.peaks - result.task.peak))]
        side = np.sign(np.interp(result.recovery_time, found.time, nearest))
        ax.plot(end, side * tolerance, "o", color=MARK, markersize=5)
        late = result.recovery_time > _LATE * found.time[-1]
        ax.annotate(
            f"{result.task.peak / deg:.0f}° recovers to ±{tolerance:g}° in {end:.1f} ms", (end, side * tolerance),
            xytext=(-14 if late else 14, 26), textcoords="offset points", color=MARK, ha="right" if late else "left",
            arrowprops={"arrowstyle": "-", "color": MARK, "linewidth": 0.7},
        )  # fmt: skip
