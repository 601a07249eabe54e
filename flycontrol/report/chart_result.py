"""The part of result.json on the stability chart; `flycontrol.report.result.FIELDS` says what each field holds."""

from __future__ import annotations

from typing import Any

import numpy as np

from flycontrol.delay.dcurve import PDGains
from flycontrol.model.gain_plane import DelaySlice
from flycontrol.model.study import StabilityStudy
from flycontrol.units import ms

_EVERY = 10  #: point of a curve that is written


def chart_fields(study: StabilityStudy) -> dict[str, Any] | None:
    """Return the fields below `chart`; None without a delay, where there is no chart."""
    plane, slice_ = study.plane, study.delay_slice
    if plane is None:
        return None
    charts = [plane, *([] if slice_ is None else [slice_])]
    roots, points = np.unique(plane.chart.unstable_roots, return_counts=True)
    return {
        "own": _place(plane.own, -float(study.result.poles[0].real)),
        "fastest_decay": _place(plane.fastest, plane.fastest_rate),
        "boundary": {
            "frequency_rad_per_s": plane.edge_omega[::_EVERY].tolist(),
            **_gains(PDGains(plane.edge.kp[::_EVERY], plane.edge.kd[::_EVERY])),
        },
        "regions": [
            {"unstable_roots": int(count), "grid_points": int(many)} for count, many in zip(roots, points, strict=True)
        ],
        "grid": {
            **_gains(PDGains(plane.chart.x.values[[0, -1]], plane.chart.y.values[[0, -1]])),
            "points": sum(part.chart.stable.size for part in charts),
            "points_agreeing": sum(part.agreeing for part in charts),
        },
        "delay_slice": None if slice_ is None else _slice(slice_),
    }


def _place(gains: tuple[float, float], rate: float) -> dict[str, float]:
    return {
        "proportional_gain_per_s2": gains[0],
        "derivative_gain_per_s": gains[1],
        "decay_rate_per_s": rate,
    }


def _gains(gains: PDGains) -> dict[str, list[float]]:
    return {"proportional_gain_per_s2": gains.kp.tolist(), "derivative_gain_per_s": gains.kd.tolist()}


def _slice(slice_: DelaySlice) -> dict[str, list[float]]:
    return {
        "gain_factor": slice_.factor[::_EVERY].tolist(),
        "largest_stable_delay_ms": (slice_.largest_stable_delay[::_EVERY] / ms).tolist(),
    }
