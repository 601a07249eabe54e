"""The figures of a fit report, each with a caption that states what it shows."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import scipy.stats
from matplotlib.figure import Figure
from numpy.typing import NDArray

from flycontrol.identify.gains.recording_fits import RecordingFit, autocorrelation
from flycontrol.identify.gains.study import FitStudy, Group
from flycontrol.model.trial import Pulse
from flycontrol.report.figures.fit_cloud import gain_cloud
from flycontrol.report.figures.fit_flies import MOST as MOST_FITS
from flycontrol.report.figures.fit_flies import fits_compared
from flycontrol.report.figures.fit_paddling import paddling_angles
from flycontrol.report.figures.fit_profiles import likelihood_profiles
from flycontrol.report.figures.fit_recordings import fitted_recordings
from flycontrol.report.figures.fit_residuals import residuals
from flycontrol.report.figures.fit_ridge import deviance_ridge
from flycontrol.report.figures.fit_strength import recovery_points
from flycontrol.report.fit.words import digits_for, ridge_words
from flycontrol.report.numbers import fixed
from flycontrol.report.page_figures import PageFigure
from flycontrol.report.style import svg
from flycontrol.units import deg

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
_MUCH = 0.10  #: share outside of a band that 5 % should miss, from which something is wrong
MOST = 24  #: recordings drawn; of more, those that the fit explains least


def fit_figures(study: FitStudy) -> dict[str, PageFigure]:
    """Draw every figure that the study has parts for, by name."""
    drawn = [
        _recordings(study),
        _residuals(study),
        _profiles(study),
        _ridge(study),
        _cloud(study),
        _group(study.flies, study, "flies"),
        _group(study.single, study, "single"),
        _strength(study),
        _paddling(study),
    ]
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
        ("The recording" if len(rms) == 1 else f"All {len(rms)} recordings")
        if len(rms) <= MOST
        else f"The {MOST} recordings of {len(rms)} that the fit explains least"
    )
    perturbations = [recording.trial.perturbation for recording in study.recordings]
    shade = ", the perturbation shaded" if any(isinstance(each, Pulse) for each in perturbations) else ""
    shade = "; no perturbation is known" if all(each is None for each in perturbations) else shade
    spread = f"from {fixed(float(rms.min()), 2)}° to {fixed(float(rms.max()), 2)}°" if len(rms) > 1 else ""
    caption = (
        f"{which}, dots measured, lines fitted{shade}. Root mean square residuals, written into the "
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
        f"The noise of each recording is modelled as autoregressive, of {_orders(orders)}, and "
        "the intervals carry it. If the model of fly and noise were exact, 5 % of the innovations’ autocorrelations "
        f"would lie outside of the band; {100 * float(np.mean(outside)):.0f} % do. {_conclusion(study, outside)}"
    ).strip()
    return _page_figure("residuals", residuals(recordings), "What the fit leaves", caption)


def _orders(orders: IntArray) -> str:
    low, high = int(orders.min()), int(orders.max())
    return f"order {low}" if low == high else f"orders {low} to {high}"


def _conclusion(study: FitStudy, outside: Sequence[float]) -> str:
    """What too much correlation left in the innovations means, and what to do."""
    if float(np.mean(outside)) <= _MUCH:
        return ""
    flies = {recording.trial.fly for recording in study.recordings}
    pooled = len(flies) > 1 and any(e.name == "kp" for e in study.result.estimates)
    cause = (
        "the flies differ, or the model misses something" if pooled else "the model of fly or noise misses something"
    )
    mend = "Fit the flies apart (--shared fly)" if pooled else "Look for what the lines in the panels above miss"
    return f"That is more than chance: {cause}, and the intervals may be too narrow. {mend}, and compare controllers."


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


def _profiles(study: FitStudy) -> PageFigure | None:
    if not study.profiles:
        return None
    estimates = {e.name: e for e in study.result.estimates}
    bent = [name for name in study.profiles if estimates[name].method == "profile"]
    finding = (
        f"Of {' and '.join(bent)} the profile departs from the parabola, and the reported interval is the profile’s."
        if bent
        else "The parabolas follow the profiles, so intervals by the covariance are good."
    )
    caption = (
        "Solid: the least deviance for each value of an unknown, all others fitted again at the dots; its root is "
        "interpolated in between. Dashed: the parabola of the covariance. Band: the interval reported; dotted: the "
        f"deviance at its ends. {finding}"
    )
    figure = likelihood_profiles(study.profiles, estimates)
    return _page_figure("profiles", figure, "Profile likelihoods", caption)


def _ridge(study: FitStudy) -> PageFigure | None:
    found = study.ridge
    if found is None:
        return None
    return _page_figure("ridge", deviance_ridge(found), "What the data cannot tell apart", ridge_words(found))


def _cloud(study: FitStudy) -> PageFigure | None:
    plane, found, result = study.plane, study.bootstrap, study.result
    if plane is None or result.found_nothing or not {"kp", "kd"} <= set(result.problem.names):
        return None
    draws = np.zeros((0, 2)) if found is None else found.draws[:, [found.names.index(name) for name in ("kp", "kd")]]
    level = f"{100 * result.level:g} %"
    cloud = (
        f"Dots: {len(draws)} fits to data drawn anew from the fitted fly and its noise"
        + (f", {found.failed} more found no minimum and are left out. " if found is not None and found.failed else ". ")
        if len(draws)
        else ""
    )
    ellipse = _ellipse(study) if result.usable else None
    region = (
        f"Ellipse: the region that holds both gains with a confidence of {level}, by the covariance. "
        if ellipse is not None
        else "No region of confidence is drawn, since the covariance does not give one here. "
    )
    caption = (
        f"Shaded: gains that are stable at the fitted damping and delay. {cloud}{region}Damping and delay vary "
        "too; the boundary is drawn at their estimates."
    )
    figure = gain_cloud(plane, draws, ellipse)
    return _page_figure("cloud", figure, "The fly among all gains", caption)


def _ellipse(study: FitStudy) -> FloatArray | None:
    """Edge of the joint confidence region of kp and kd (m, 2); None where the covariance is not finite."""
    result = study.result
    at = [result.problem.names.index(name) for name in ("kp", "kd")]
    C = result.covariance[np.ix_(at, at)]
    if not np.all(np.isfinite(C)):
        return None
    freedom = min(result.estimates[i].freedom for i in at)
    size = np.sqrt(2.0 * scipy.stats.f.ppf(result.level, 2, freedom))
    turn = np.linspace(0.0, 2 * np.pi, 121)
    circle = np.column_stack([np.cos(turn), np.sin(turn)])
    centre = np.array([result.estimates[i].value for i in at])
    return np.asarray(centre + size * circle @ np.linalg.cholesky(C).T, dtype=np.float64)


def _strength(study: FitStudy) -> PageFigure | None:
    found = study.recovery
    if found is None:
        return None
    band = found.band
    unstable = f" {band.unstable} of them are unstable and never recover." if band.unstable else ""
    caption = (
        f"{found.sentence} Dots: the last entry of yaw into ±{fixed(band.tolerance / deg, 0)}° around the heading, "
        f"with {100 * band.level:g} % intervals from the noise, long where yaw runs along the edge of the band and "
        "noise may hide a later exit; a triangle at the top marks a recording that ends before the recovery. "
        f"Band: {band.draws} loops drawn from the estimates’ "
        f"distribution, each with its exact recovery after a pulse of {fixed(band.duration * 1e3, 1, 'ms')}.{unstable}"
    )
    return _page_figure("strength", recovery_points(found), "Recovery time against strength", caption)


def _group(group: Group | None, study: FitStudy, name: str) -> PageFigure | None:
    if group is None or not any(fit.usable for fit in group.fits):
        return None
    pooled = {e.kind: e for e in study.result.estimates if e.name == e.kind}
    who, level = ("fly" if name == "flies" else "recording"), f"{100 * study.result.level:g} %"
    count = sum(fit.usable for fit in group.fits)
    shown = f"Each {who} by itself, {level} intervals"
    if count > MOST_FITS:
        shown = f"The first {MOST_FITS} of {count} {who}s by themselves, {level} intervals"
    caption = (
        f"{shown}. Band: the pooled estimate. Diamond: the mean, with an interval that carries the spread between them."
    )
    figure = fits_compared(group.fits, pooled, group.effects, study.result.level)
    return _page_figure(name, figure, f"Every {who} by itself", caption)
