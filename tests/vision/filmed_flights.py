"""Flights of the parametric fly with turns, drawn with legs, and how far a track is from their truth."""

import numpy as np

from flycontrol.model.camera_forms import orthogonal_cameras
from flycontrol.model.flapping_pose import flapping_pose
from flycontrol.model.planform import Planform
from flycontrol.model.stroke_kinematics import hover_stroke
from flycontrol.model.wing_stroke import Modulation
from flycontrol.units import deg, mm
from flycontrol.vision.example_flight import turning_pose
from flycontrol.vision.fly_shape import fly_shape
from flycontrol.vision.render import render_silhouettes

RATE, FREQUENCY, SCALE = 8000.0, 220.0, 35 / mm
PLANFORM = Planform(length=2.4 * mm, mean_chord=2.4 * mm / 3.4, second_moment_radius=0.58)
BARE, WITH_LEGS = fly_shape(PLANFORM), fly_shape(PLANFORM, legs=True)
CAMERAS = orthogonal_cameras(scale=SCALE, shape=(256, 256), distance=120 * mm)
STROKE_PLANE = 50 * deg


def turning_flight(wingbeats):
    """Pose at 8,000 frames a second: 100 deg to the right, banked by up to 25 deg, with wings that beat unequally."""
    return turning_pose(BARE, STROKE_PLANE, wingbeats)


def any_flight(rng, frames):
    """Pose at 8,000 frames a second: any heading, pitch, bank and phase, turning, each wing with a beat of its own."""

    def beat():
        return Modulation(
            stroke_offset=8 * deg * rng.normal(), pitch_offset=8 * deg * rng.normal(),
            deviation_offset=5 * deg * rng.normal(), stroke_gain=0.08 * rng.normal(),
        )  # fmt: skip

    frequency, since = rng.uniform(180, 240), np.arange(frames) / RATE
    stroke = hover_stroke(frequency).modulated(beat(), beat())
    start = np.array([rng.uniform(-180, 180), rng.uniform(15, 65), 20 * rng.normal()]) * deg
    rates = rng.normal(size=3) * [1500, 500, 1000] * deg
    position = 0.3 * mm * rng.normal(size=3) + np.outer(since, 0.3 * rng.normal(size=3))
    return flapping_pose(
        stroke, since + rng.uniform(0, 1 / frequency), right_base_B=BARE.right_base_B,
        stroke_plane_angle=STROKE_PLANE, position_W=position, attitude=start + np.outer(since, rates),
    )  # fmt: skip


def drawn(pose, shape=WITH_LEGS, cameras=CAMERAS):
    return list(render_silhouettes(shape, pose, cameras))


def apart(pose, truth):
    """(N, 18) differences of two poses' coordinates, angles within +-180 deg."""
    away = pose.coordinates - truth.coordinates
    away[:, 3:12] = (away[:, 3:12] + np.pi) % (2 * np.pi) - np.pi
    return away
