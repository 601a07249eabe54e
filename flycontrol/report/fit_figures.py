"""The figures of a fit report, each with a caption that states what it shows."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from flycontrol.identify.gains.study import FitStudy, RecordingFit, autocorrelation
from flycontrol.report.figures.fit_paddling import paddling_angles
from flycontrol.report.figures.fit_recordings import fitted_recordings
from flycontrol.report.figures.fit_residuals import residuals
from flycontrol.report.fit_words import digits_for
from flycontrol.report.numbers import fixed
from flycontrol.report.page_figures import PageFigure
from flycontrol.report.style import svg
from flycontrol.units import deg

MOST = 24  #: recordings drawn; of more, those that the fit explains least


def fit_figures(study: FitStudy) -> dict[str, PageFigure]:
    """Draw every figure that the study has parts for, by name."""
    drawn = [_recordings(study), _residuals(study), _paddling(study)]
    return {figure.name: figure for figure in drawn if figure is not None}


def _page_figure(name: str, figure: Figure, title: str, caption: str) -> PageFigure:
    return PageFigure(name=name, title=title, caption=caption, drawing=svg(figure, name, title))


def shown(study: FitStudy) -> list[RecordingFit]:
    """All recordings, or of many the worst, in their own order."""
    if len(study.recordings) <= MOST:
        return list(study.recordings)
    worst = sorted(study.recordings, key=lambda recording: -recording.yaw.rms)[:MOST]
    return [recording for recording in study.recordings if recording in worst]


def _recordings(study: FitStudy) -> PageFigure:
    rms = np.array([recording.yaw.rms for recording in study.recordings]) / deg
    worst = study.recordings[int(np.argmax(rms))]
    which = (
        f"All {len(rms)} recordings"
        if len(rms) <= MOST
        else f"The {MOST} recordings of {len(rms)} that the fit explains least"
    )
    spread = f"from {fixed(float(rms.min()), 2)}° to {fixed(float(rms.max()), 2)}°" if len(rms) > 1 else ""
    caption = (
        f"{which}, dots measured, lines fitted, the perturbation shaded. Root mean square residuals, written into the "
        f"panels, have the median {fixed(float(np.median(rms)), 2)}°{', ' + spread if spread else ''}; the largest is "
        f"that of {worst.trial.name}."
    )
    return _page_figure("recordings", fitted_recordings(shown(study)), "Measured and fitted yaw", caption)


def _residuals(study: FitStudy) -> PageFigure:
    recordings = shown(study)
    left = [autocorrelation(r.yaw.residual, r.yaw.firsts, 1)[1] for r in recordings]
    orders = np.array([r.yaw.noise.order for r in study.recordings])
    outside = [_share_outside(r) for r in recordings]
    caption = (
        f"From one sample to the next the residuals are correlated by {fixed(float(np.nanmedian(left)), 2)} (median). "
        f"The noise of each recording is modelled as autoregressive, of orders {orders.min()} to {orders.max()}, and "
        "the intervals carry it. If the model of fly and noise were exact, 5 % of the innovations’ autocorrelations "
        f"would lie outside of the band; {100 * float(np.mean(outside)):.0f} % do."
    )
    return _page_figure("residuals", residuals(recordings), "What the fit leaves", caption)


def _share_outside(recording: RecordingFit) -> float:
    found = autocorrelation(recording.yaw.innovation, recording.yaw.firsts)[1:]
    return float(np.nanmean(np.abs(found) > 1.96 / np.sqrt(len(recording.yaw.time))))


def _paddling(study: FitStudy) -> PageFigure | None:
    recordings = [r for r in shown(study) if len(r.channels) > 1]
    if not recordings:
        return None
    gains = [e for e in study.result.estimates if e.kind == "paddling_gain"]
    sizes = [fixed(e.value / 1e3, digits_for(e.standard_error / 1e3, e.value / 1e3)) for e in gains[:6]]
    rms = np.median([r.channels[1].rms for r in recordings]) / deg
    gain = f"γ/I = {', '.join(sizes)} · 1000/s² per rad" if gains else "the given γ/I"
    caption = (
        "Dots: measured Δα, right wing at α₀ + Δα, left wing at α₀ − Δα. Lines: the torque of the fitted loop divided "
        f"by {gain}. They differ by {fixed(float(rms), 2)}° (root mean square, median of recordings)."
    )
    return _page_figure("paddling", paddling_angles(recordings), "Predicted torque and measured paddling", caption)
