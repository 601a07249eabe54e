"""Flights of the parametric fly with turns, drawn with legs, and how far a track is from their truth."""

import numpy as np

from flycontrol.model.camera_forms import orthogonal_cameras
from flycontrol.model.planform import Planform
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


def drawn(pose, shape=WITH_LEGS, cameras=CAMERAS):
    return list(render_silhouettes(shape, pose, cameras))


def apart(pose, truth):
    """(N, 18) differences of two poses' coordinates, angles within +-180 deg."""
    away = pose.coordinates - truth.coordinates
    away[:, 3:12] = (away[:, 3:12] + np.pi) % (2 * np.pi) - np.pi
    return away
