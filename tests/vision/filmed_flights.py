"""Flights of the parametric fly with turns, drawn with legs, and how far a track is from their truth."""

import numpy as np

from flycontrol.model.camera_forms import orthogonal_cameras
from flycontrol.model.flapping_pose import flapping_pose
from flycontrol.model.planform import Planform
from flycontrol.model.stroke_kinematics import hover_stroke
from flycontrol.model.wing_stroke import Modulation
from flycontrol.units import deg, mm
from flycontrol.vision.fly_shape import fly_shape
from flycontrol.vision.render import render_silhouettes

RATE, FREQUENCY, SCALE = 8000.0, 220.0, 35 / mm
PLANFORM = Planform(length=2.4 * mm, mean_chord=2.4 * mm / 3.4, second_moment_radius=0.58)
BARE, WITH_LEGS = fly_shape(PLANFORM), fly_shape(PLANFORM, legs=True)
CAMERAS = orthogonal_cameras(scale=SCALE, shape=(256, 256), distance=120 * mm)
STROKE_PLANE = 50 * deg


def turning_flight(wingbeats):
    """Pose at 8,000 frames a second: 100 deg to the right, banked by up to 25 deg, with wings that beat unequally."""
    time = np.arange(int(wingbeats * RATE / FREQUENCY)) / RATE
    stroke = hover_stroke(FREQUENCY).modulated(
        Modulation(stroke_offset=6 * deg, pitch_offset=-8 * deg, stroke_gain=0.08),
        Modulation(deviation_offset=5 * deg, pitch_offset=8 * deg),
    )
    x = time / (10 / FREQUENCY)
    turn = 20 * deg + 100 * deg * (10 * x**3 - 15 * x**4 + 6 * x**5)
    pitch = 45 * deg + 2.4 * deg * np.sin(2 * np.pi * FREQUENCY * time) + 10 * deg * np.sin(2 * np.pi * 25 * time)
    attitude = np.stack([turn, pitch, 25 * deg * np.sin(2 * np.pi * x)], axis=1)
    position = np.stack([0.6 * x - 0.3, 0.3 * np.sin(6 * x), 0.3 * x**2], axis=1) * mm
    return flapping_pose(
        stroke, time, right_base_B=BARE.right_base_B, stroke_plane_angle=STROKE_PLANE,
        position_W=position, attitude=attitude,
    )  # fmt: skip


def drawn(pose, shape=WITH_LEGS, cameras=CAMERAS):
    return list(render_silhouettes(shape, pose, cameras))


def apart(pose, truth):
    """(N, 18) differences of two poses' coordinates, angles within +-180 deg."""
    away = pose.coordinates - truth.coordinates
    away[:, 3:12] = (away[:, 3:12] + np.pi) % (2 * np.pi) - np.pi
    return away
