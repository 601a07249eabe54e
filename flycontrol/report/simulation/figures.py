"""The figures of a simulated flight, each with a caption that states what it shows."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from flycontrol.flight.experiment_ensemble import FlownEnsemble
from flycontrol.flight.flight_record import Closely, FlightRecord
from flycontrol.report.figures.flight_attitude import body_attitude, yaw_response
from flycontrol.report.figures.flight_ensemble import ensemble_attitude
from flycontrol.report.figures.flight_loads import force_terms, torque_terms
from flycontrol.report.figures.flight_means import wingbeat_mean_loads
from flycontrol.report.figures.flight_power import hinge_power
from flycontrol.report.figures.flight_track import body_track
from flycontrol.report.figures.flight_wings import wing_angles_over_time, wing_tip_paths
from flycontrol.report.numbers import degrees, fixed, milliseconds, significant
from flycontrol.report.page_figures import PageFigure
from flycontrol.report.style import svg
from flycontrol.units import deg, mm

FIGURES = ("yaw", "attitude", "track", "means", "forces", "torques", "wings", "tips", "power", "ensemble")
_MICRO = 1e-6


def simulation_figures(record: FlightRecord, ensemble: FlownEnsemble | None = None) -> dict[str, PageFigure]:
    """Draw every figure that the flight has parts for, by name."""
    held = not record.planned.experiment.free
    drawn = [] if held else [_attitude(record), _track(record)]
    if not held and any(pulse.torque_S[2] for pulse in record.planned.plan.pulses):
        drawn.append(_yaw(record))
    if record.wingbeats:
        drawn.append(_means(record))
    if record.closely is not None and len(record.closely.flight.time) > 1:
        drawn += _of_a_few_wingbeats(record, record.closely)
    if ensemble is not None:
        drawn.append(_ensemble(record, ensemble))
    return {figure.name: figure for figure in drawn}


def _ensemble(record: FlightRecord, ensemble: FlownEnsemble) -> PageFigure:
    ends = ensemble.yaw[np.isfinite(ensemble.yaw[:, -1]), -1] / deg
    low, middle, high = np.percentile(ends, [5, 50, 95]) if len(ends) else [np.nan] * 3
    stopped = sum(status != "complete" for status in ensemble.status)
    caption = (
        f"{ensemble.flights} flights, each with its own fly, stroke and pulse, drawn about those of the flight above. "
        f"At the end the heading’s median is {fixed(middle, 1)}°, and nine tenths lie between {fixed(low, 1)}° and "
        f"{fixed(high, 1)}°."
    )
    if stopped:
        caption += f" {stopped} of them diverged and are drawn until then."
    return _page_figure("ensemble", ensemble_attitude(record, ensemble), "Attitude of the ensemble", caption)


def _of_a_few_wingbeats(record: FlightRecord, closely: Closely) -> list[PageFigure]:
    drawn = [_wings(record, closely), _tips(record, closely)]
    if record.planned.plan.fly.air.terms:
        drawn += [_forces(record, closely), _torques(record, closely)]
    if record.wingbeats:
        drawn.append(_power(record, closely))
    return drawn


def _page_figure(name: str, figure: Figure, title: str, caption: str) -> PageFigure:
    return PageFigure(name=name, title=title, caption=caption, drawing=svg(figure, name, title))


def _yaw(record: FlightRecord) -> PageFigure:
    impulse = sum(pulse.torque_S[2] * pulse.duration for pulse in record.planned.plan.pulses)
    peak = float(np.max(np.abs(record.beats.angular_velocity_S[:, 2]), initial=0))
    caption = (
        f"An angular impulse of {significant(impulse, 3, 'N m s')} from outside turns the fly at up to "
        f"{fixed(peak, 1, 'rad/s')} in the mean of a wingbeat; the heading of its stroke plane is farthest from the "
        f"old one, by {_sided(record.peak_yaw / deg, '°')}, at {milliseconds(record.peak_yaw_time)}. No controller "
        "acts: flapping alone damps the turn."
    )
    return _page_figure("yaw", yaw_response(record), "Yaw response", caption)


def _attitude(record: FlightRecord) -> PageFigure:
    body = record.body
    caption = "Angles are those of the stroke plane, which is level in trimmed hover."
    if len(body.time):
        caption += (
            f" It ends turned by {_sided(body.yaw[-1] / deg, '°')}, {degrees(body.nose_up[-1])} nose up and rolled by "
            f"{_sided(body.roll[-1] / deg, '°')}."
        )
    caption += (
        " Where the nose passes the vertical, heading and roll jump. The ripple is the wings’ inertia and their "
        "changing load within each wingbeat."
    )
    return _page_figure("attitude", body_attitude(record), "Attitude and rates of the body", caption)


def _track(record: FlightRecord) -> PageFigure:
    x, y, z = (record.body.position_W[-1] if len(record.body.time) else np.zeros(3)) / mm
    along, up = ("ahead" if x >= 0 else "back"), ("up" if z >= 0 else "down")
    caption = (
        f"The centre of mass of the body starts at the dot and ends at the square, {fixed(abs(x), 2, 'mm')} {along}, "
        f"{_sided(-y, ' mm', 2)} and {fixed(abs(z), 2, 'mm')} {up}. Ahead is where the fly looked at first."
    )
    return _page_figure("track", body_track(record), "Track of the body", caption)


def _means(record: FlightRecord) -> PageFigure:
    lift = record.beats.lift.sum(axis=1) / record.planned.experiment.morphology.weight
    first, last = (fixed(float(lift[k]), 3) for k in (0, -1))
    caption = (
        f"Each dot is the mean of one wingbeat. The air carries {first} of the weight in the first and {last} in the "
        "last. Torques are about the body’s centre of mass, positive right side down, nose up and to the right."
    )
    return _page_figure("means", wingbeat_mean_loads(record), "Load of the air, wingbeat by wingbeat", caption)


def _forces(record: FlightRecord, closely: Closely) -> PageFigure:
    up = -closely.loads.total.force[:, 2] / record.planned.experiment.morphology.weight
    caption = (
        f"The upward force of both wings runs from {fixed(float(up.min()), 1)} to {fixed(float(up.max()), 1)} weights. "
        "Stroke-plane frame. Added mass is what the air’s inertia adds; it nearly averages out."
    )
    return _page_figure("forces", force_terms(record, closely), "Forces of the air by term", caption)


def _torques(record: FlightRecord, closely: Closely) -> PageFigure:
    caption = (
        "Torques of both wings about the body’s centre of mass, stroke-plane frame. A mirror-symmetric stroke of a fly "
        "at rest makes no roll and no yaw torque; those here answer the body’s own motion, and steering."
    )
    return _page_figure("torques", torque_terms(record, closely), "Torques of the air by term", caption)


def _wings(record: FlightRecord, closely: Closely) -> PageFigure:
    stroke = closely.flight.right.stroke / deg
    caption = (
        f"The right wing sweeps from {fixed(float(stroke.min()), 1)}° to {fixed(float(stroke.max()), 1)}°. Stroke is "
        "positive forward, deviation above the stroke plane, and a pitch of 90° is a vertical chord."
    )
    return _page_figure("wings", wing_angles_over_time(record, closely), "Wing angles", caption)


def _tips(record: FlightRecord, closely: Closely) -> PageFigure:
    caption = (
        "Stroke-plane frame, origin in the body’s centre of mass: one wingbeat from the side, and all that are shown "
        "closely from above. Dots in the right panel are the hinges."
    )
    return _page_figure("tips", wing_tip_paths(record, closely), "Paths of the wing tips", caption)


def _power(record: FlightRecord, closely: Closely) -> PageFigure:
    mean = 0.0 if record.mean is None else float(record.mean.power[0])
    over_mass = mean / record.planned.experiment.morphology.mass
    caption = (
        f"What hinges and muscles give to both wings, from inverse dynamics: {significant(mean / _MICRO, 3, 'µW')} in "
        f"the mean, {significant(over_mass, 3, 'W/kg')} of body mass. Where it is negative the wings give back."
    )
    return _page_figure("power", hinge_power(record, closely), "Mechanical power at the wing hinges", caption)


def _sided(value: float, unit: str, digits: int = 1) -> str:
    return f"{fixed(abs(value), digits)}{unit} to the {'right' if value >= 0 else 'left'}"
