"""Time responses."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from flycontrol.delay.plots.comparison import Curve, listed, pade_label
from flycontrol.delay.plots.style import GUIDE, AxesArray, legend, line_of, panels, tell
from flycontrol.delay.response import Response
from flycontrol.delay.system import FloatArray
from flycontrol.delay.timeresponse import TimeResponse
from flycontrol.errors import InvalidParameterError

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_POINTS = 500  # of a response that has no samples


def time_response_plot(
    data: Any,
    *,
    ax: Axes | AxesArray | None = None,
    pade: int | None = None,
    approximation: Any = None,
    label: str | Sequence[str] | None = None,
    title: str | None = None,
) -> AxesArray:
    """Outputs against time [s], one row an output, one column a trace (an input of a step or impulse response).

    Parameters
    ----------
    data
        `TimeResponse` or `Response`, or a list of these with equally many outputs and traces.
    ax
        As many axes as outputs times traces.
    pade
        Order n: the same experiment on the Padé approximation [n/n] of each system is drawn beside.
    approximation
        `TimeResponse` or `Response` drawn beside, one for each in `data`.
    label
        Of each in `data`.

    Returns
    -------
    The axes, shape (outputs, traces).

    Raises
    ------
    InvalidParameterError
        If something is no response, responses differ in shape, or a response cannot be repeated on an approximation.
    """
    shown = _shown(data, pade, approximation, label)
    traces = [_traces(curve.result) for curve in shown]
    rows, columns = {(found[0].series.shape[1], len(found)) for found in traces}.pop()
    if any((found[0].series.shape[1], len(found)) != (rows, columns) for found in traces):
        shapes = ", ".join(str((found[0].series.shape[1], len(found))) for found in traces)
        raise InvalidParameterError(f"Responses in one plot need one shape (outputs, traces), got {shapes}.")
    places = panels(ax, rows, columns, (3.2 + 3.2 * columns, 2.0 + 1.8 * rows), sharex=True)
    for curve, found in zip(shown, traces, strict=True):
        for k, trace in enumerate(found):
            times = _times(curve.result, trace)
            for panel, line in zip(places[:, k], trace(times), strict=True):
                panel.plot(times, line, **line_of(curve), label=curve.label or None)
    _impulses(places, [curve.result for curve in shown if curve.exact])
    _name(places)
    legend(places[0, 0])
    tell(places[0, 0], title, "from input 0" if columns > 1 else "")
    return places


def _shown(data: Any, order: int | None, given: Any, label: str | Sequence[str] | None) -> list[Curve[Any]]:
    items = listed(data)
    labels = [""] * len(items) if label is None else [label] if isinstance(label, str) else [*label]
    if label is None and len(items) > 1:
        labels = [f"response {k + 1}" for k in range(len(items))]
    others = [None] * len(items) if given is None else listed(given)
    if not len(items) == len(labels) == len(others):
        raise InvalidParameterError(
            f"{len(items)} response(s) need as many labels and approximations, got {len(labels)} and {len(others)}."
        )
    found: list[Curve[Any]] = []
    for k, (item, name, other) in enumerate(zip(items, labels, others, strict=True)):
        beside: list[tuple[Any, str]] = [] if order is None else [(_repeated(item, order), pade_label(order))]
        beside += [] if other is None else [(other, "approximation")]
        words = "exact" if beside else ""
        for result, what in [(item, words), *beside]:
            if not isinstance(result, TimeResponse | Response):
                raise InvalidParameterError(
                    f"A time response is drawn from a TimeResponse or a Response, got {type(result).__name__}; compute "
                    "step_response(system) or another one first."
                )
            text = ", ".join(part for part in (name, what) if part)
            found.append(Curve(result, text, exact=result is item, series=k, alone=len(items) == 1))
    return found


def _repeated(item: Any, order: int) -> TimeResponse:
    if not isinstance(item, TimeResponse) or item.approximated is None:
        raise InvalidParameterError(
            "This response cannot be repeated on a Padé approximation, whose states know no history: compute that "
            "response yourself and give it as `approximation`."
        )
    return item.approximated(order)


def _traces(result: TimeResponse | Response) -> tuple[Response, ...]:
    return result.exact if isinstance(result, TimeResponse) else (result,)


def _times(result: TimeResponse | Response, trace: Response) -> FloatArray:
    """Times to draw at: the samples, and both sides of every kink or jump."""
    samples = result.time if isinstance(result, TimeResponse) else np.linspace(trace.starts[0], trace.end, _POINTS)
    kinks = trace.starts[(trace.starts > samples[0]) & (trace.starts < samples[-1])]
    before = kinks - 1e-9 * (samples[-1] - samples[0])
    return np.unique(np.concatenate([samples, kinks, before]))


def _impulses(places: AxesArray, results: list[Any]) -> None:
    """Impulses of outputs as arrows, with their weights."""
    for result in results:
        for k, impulses in enumerate(result.impulses if isinstance(result, TimeResponse) else ()):
            for t, weights in zip(impulses.times, impulses.weights, strict=True):
                for panel, weight in zip(places[:, k], weights, strict=True):
                    if weight:
                        top = panel.get_ylim()[int(weight > 0)]
                        arrow = {"arrowstyle": "-|>", "linewidth": 1.4}
                        panel.annotate("", (t, top), xytext=(t, 0.0), arrowprops=arrow)
                        panel.annotate(
                            f"{weight:.3g} δ", (t, top), xytext=(5, -3 if weight > 0 else 3),
                            textcoords="offset points", va="top" if weight > 0 else "bottom",
                        )  # fmt: skip


def _name(places: AxesArray) -> None:
    rows, columns = places.shape
    for i in range(rows):
        places[i, 0].set_ylabel("output" if rows == 1 else f"output {i}")
    for k in range(columns):
        places[-1, k].set_xlabel("time [s]")
        if columns > 1:
            places[0, k].set_title(f"from input {k}", fontsize="medium")
    for panel in places.flat:
        panel.axhline(0.0, **GUIDE)
