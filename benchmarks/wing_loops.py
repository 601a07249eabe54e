"""The wing level: flycontrol's side, and the problem as plain numbers for its peers.

The published fly on a stroke that carries its weight; a deviation on top, so that every angle moves.
"""

from dataclasses import replace
from functools import cache

import numpy as np

from flycontrol.flight.drive import drive_table
from flycontrol.flight.ensemble import FlightPlan
from flycontrol.flight.flapping_fly import FlappingFly
from flycontrol.flight.kernels.lanes import BODY_STATES, LANE_DRIVE, LANES, march_lanes
from flycontrol.flight.kernels.march import SAMPLE, march
from flycontrol.flight.lanes import drive_in_lanes, in_lanes, lane_constants
from flycontrol.flight.multibody.constants import constants_of
from flycontrol.flight.multibody.freedoms import Hinge
from flycontrol.flight.settings import MarchSettings
from flycontrol.flight.state_vector import level_start, packed
from flycontrol.io.morphology import read_morphology_table
from flycontrol.model.hinge import SteeredSpring
from flycontrol.model.morphology import morphology_from_table
from flycontrol.model.stroke_kinematics import StrokeKinematics
from flycontrol.model.wing_stroke import BermanWangStroke

STEPS, SAMPLES, WINGBEATS = 200, 50, 100
FREQUENCY = 228.7  # [1/s], weight support of this stroke
SETTINGS = MarchSettings(
    steps=STEPS,
    samples=SAMPLES,
)
FOLLOWING = {
    "stroke": 8000.0,
    "deviation": 8000.0,
    "pitch": 14000.0,
}  # joints on springs [rad/s]


def stroke():
    wing = BermanWangStroke(
        stroke_amplitude=np.radians(70), stroke_shape=0.7, stroke_offset=0.13, pitch_shape=2.0, pitch_lead=0.087,
        pitch_offset=-0.0166, deviation_amplitude=np.radians(5), deviation_phase=0.4,
    )  # fmt: skip
    return StrokeKinematics.symmetric(wing, FREQUENCY)


@cache
def fly():
    return FlappingFly(morphology=morphology_from_table(read_morphology_table(), "Drosophila melanogaster", FREQUENCY))


def joint_inertias():
    """About the axes of stroke, deviation and pitch [kg m^2]."""
    wing = fly().morphology.wing_body
    return {"stroke": wing.normal_inertia, "deviation": wing.normal_inertia, "pitch": wing.span_inertia}


def fly_on_springs():
    """Every joint of the wings free, drawn along the stroke by a spring and a damper."""
    joints = {
        name: SteeredSpring(stiffness=inertia * FOLLOWING[name] ** 2, damping=1.4 * inertia * FOLLOWING[name])
        for name, inertia in joint_inertias().items()
    }
    hinge = Hinge(**joints)
    return replace(fly(), left=hinge, right=hinge)


def plans():
    """As many flies as there are lanes, their masses spread by 10 %."""
    masses = fly().morphology.mass * np.linspace(0.95, 1.05, LANES)
    flies = [replace(fly(), morphology=replace(fly().morphology, mass=float(mass))) for mass in masses]
    return [FlightPlan(fly=own, stroke=stroke()) for own in flies]


def kernel_march(own):
    """A function that flies WINGBEATS by the compiled march alone, what precedes it done."""
    beats = stroke()
    drive = drive_table(own, beats, _phase())
    arguments = constants_of(own, FREQUENCY).arguments
    start, outside = packed(level_start(beats)), np.zeros((STEPS, 6))
    room = np.empty((SAMPLES, SAMPLE))

    def fly_on():
        y = start.copy()
        for _ in range(WINGBEATS):
            march(y, drive, 1 / (FREQUENCY * STEPS), outside, STEPS // SAMPLES, *arguments, room)
        return y

    return fly_on


def kernel_march_in_lanes(flown):
    """The same for flies side by side."""
    drive = drive_in_lanes([drive_table(plan.fly, plan.stroke, _phase()) for plan in flown])
    arguments = lane_constants([plan.fly for plan in flown], [plan.stroke for plan in flown]).arguments
    start = in_lanes([packed(level_start(plan.stroke))[:BODY_STATES] for plan in flown])
    step, outside = np.full(LANES, 1 / (FREQUENCY * STEPS)), np.zeros((STEPS, 6 * LANES))
    room = np.empty((SAMPLES, 19 * LANES))

    def fly_on():
        y = start.copy()
        for _ in range(WINGBEATS):
            march_lanes(y, drive, step, outside, STEPS // SAMPLES, *arguments, room)
        return y

    return fly_on


def _phase():
    return np.arange(2 * STEPS + 1) / (2 * STEPS)


def as_plain_numbers(flown, flights):
    """Arrays for a hand-written kernel, flies fastest, and the end that flycontrol reaches."""
    constants = [constants_of(plan.fly, FREQUENCY) for plan in flown]
    tables = [drive_table(plan.fly, plan.stroke, _phase())[:, :, :LANE_DRIVE] for plan in flown]
    rows = {
        "y": [packed(level_start(plan.stroke))[:BODY_STATES] for plan in flown],
        "drive": tables,
        "body": [own.body for own in constants],
        "wings": [own.wings for own in constants],
        "blades": [own.blades.transpose(0, 2, 1)[:, : flown[0].fly.air.nodes] for own in constants],
        "end": [np.r_[f.position_W[-1], f.q_WS[-1], f.velocity_S[-1], f.angular_velocity_S[-1]] for f in flights],
    }
    return {
        "lanes": len(flown), "nodes": flown[0].fly.air.nodes, "steps": STEPS, "samples": SAMPLES,
        "wingbeats": WINGBEATS, "step": [1 / (FREQUENCY * STEPS)] * len(flown),
        "gravity": list(flown[0].fly.gravity_W), "polynomials": constants[0].polynomials.ravel().tolist(),
        **{name: np.stack(arrays, axis=-1).ravel().tolist() for name, arrays in rows.items()},
    }  # fmt: skip


def as_ellipsoids():
    """The same fly for MuJoCo: masses, inertias, hinges, the wing's ellipsoid, and the stroke at every step."""
    morphology = fly().morphology
    wing = morphology.wing_body
    at = stroke().right(np.arange(STEPS) / STEPS)
    return {
        "steps": STEPS, "wingbeats": WINGBEATS, "frequency": FREQUENCY, "density": fly().air.air_density,
        "body_mass": morphology.mass - 2 * wing.mass, "body_inertia": morphology.inertia_S.tolist(),
        "hinge": list(morphology.right_hinge), "wing_length": morphology.wing_length,
        "mean_chord": morphology.mean_chord, "pitch_axis": morphology.pitch_axis,
        "wing_mass": wing.mass, "wing_centre": list(wing.centre),
        "wing_inertia": [wing.span_inertia, wing.chord_inertia, wing.normal_inertia, wing.product],
        "joint_inertias": list(joint_inertias().values()), "following": list(FOLLOWING.values()),
        "angles": at.angles.tolist(), "rates": (at.first * FREQUENCY).tolist(),
        "accelerations": (at.second * FREQUENCY**2).tolist(),
    }  # fmt: skip
