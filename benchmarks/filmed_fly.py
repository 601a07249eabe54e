"""A turning flight of the parametric fly with legs, seen by three cameras at 8,000 frames a second, 35 px/mm."""

import numpy as np

from flycontrol.model.camera_forms import orthogonal_cameras
from flycontrol.model.flapping_pose import flapping_pose
from flycontrol.model.planform import Planform
from flycontrol.model.stroke_kinematics import hover_stroke
from flycontrol.units import deg, mm
from flycontrol.vision.fly_shape import fly_shape
from flycontrol.vision.follower import Fly
from flycontrol.vision.render import render_silhouettes

RATE, FREQUENCY = 8000.0, 220.0
PLANFORM = Planform(length=2.4 * mm, mean_chord=0.7 * mm, second_moment_radius=0.58)
BARE, WITH_LEGS = fly_shape(PLANFORM), fly_shape(PLANFORM, legs=True)
FLY = Fly(shape=BARE, stroke_plane_angle=50 * deg)
CAMERAS = orthogonal_cameras(scale=35 / mm, shape=(256, 256), distance=120 * mm)


def pose(frames):
    """Turns by 2 deg a wingbeat, however long, in the middle of all images."""
    time = np.arange(frames) / RATE
    attitude = np.stack([2 * deg * FREQUENCY * time, np.full(frames, 45 * deg), np.full(frames, 5 * deg)], axis=1)
    return flapping_pose(
        hover_stroke(FREQUENCY), time, right_base_B=BARE.right_base_B, stroke_plane_angle=50 * deg,
        position_W=(0, 0, 0), attitude=attitude,
    )  # fmt: skip


def silhouettes(frames):
    """One instant after the other."""
    return render_silhouettes(WITH_LEGS, pose(frames), CAMERAS)
