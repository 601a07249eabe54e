"""The flight that is filmed where no film is given: a turn whose truth is known."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flycontrol.model.camera import Camera
from flycontrol.model.camera_forms import orthogonal_cameras
from flycontrol.model.flapping_pose import flapping_pose
from flycontrol.model.pose import Pose
from flycontrol.model.stroke_kinematics import hover_stroke
from flycontrol.model.wing_stroke import Modulation
from flycontrol.units import deg, mm
from flycontrol.vision.drawn_film import drawn_films
from flycontrol.vision.fly_shape import FlyShape, with_legs
from flycontrol.vision.follower import Fly
from flycontrol.vision.footage import Footage
from flycontrol.vision.render import Imaging

FRAME_RATE = 8000.0  #: [1/s]
_SCALE, _SHAPE, _DISTANCE = 35 / mm, (256, 256), 120 * mm
_FREQUENCY, _WINGBEATS = 220.0, 10
#: Of a good high-speed camera: an edge over two pixels, grey levels that scatter by some four of 160 (C).
_IMAGING = Imaging(blur=0.8, noise=0.025)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ExampleFlight:
    """A film, and what is true of it."""

    footage: Footage
    cameras: tuple[Camera, ...]
    truth: Pose
    shape: FlyShape  #: of the fly, with its legs


def example_flight(fly: Fly, wingbeats: float = _WINGBEATS) -> ExampleFlight:
    """A fly with legs before three orthogonal cameras of 35 px/mm, 8,000 frames a second, ten wingbeats.

    It turns by 100 deg to the right, banks by up to 25 deg, and its wings beat unequally. The motion is prescribed: no
    air and no mass have made it.
    """
    shape = with_legs(fly.shape)
    cameras = orthogonal_cameras(scale=_SCALE, shape=_SHAPE, distance=_DISTANCE)
    truth = turning_pose(shape, fly.stroke_plane_angle, wingbeats)
    films = drawn_films(shape, truth, cameras, _IMAGING)
    footage = Footage(films=films, frame_rate=FRAME_RATE, backgrounds=tuple(film.background for film in films))
    return ExampleFlight(footage=footage, cameras=cameras, truth=truth, shape=shape)


def turning_pose(shape: FlyShape, stroke_plane_angle: float, wingbeats: float = _WINGBEATS) -> Pose:
    """100 deg to the right in ten wingbeats, banked by up to 25 deg, wings beating unequally."""
    time = np.arange(int(wingbeats * FRAME_RATE / _FREQUENCY)) / FRAME_RATE
    stroke = hover_stroke(_FREQUENCY).modulated(
        Modulation(stroke_offset=6 * deg, pitch_offset=-8 * deg, stroke_gain=0.08),
        Modulation(deviation_offset=5 * deg, pitch_offset=8 * deg),
    )
    x = time * _FREQUENCY / _WINGBEATS
    yaw = 20 * deg + 100 * deg * (10 * x**3 - 15 * x**4 + 6 * x**5)
    bob = 2.4 * deg * np.sin(2 * np.pi * _FREQUENCY * time) + 10 * deg * np.sin(2 * np.pi * 25 * time)
    attitude = np.stack([yaw, 45 * deg + bob, 25 * deg * np.sin(2 * np.pi * x)], axis=1)
    position = np.stack([0.6 * x - 0.3, 0.3 * np.sin(6 * x), 0.3 * x**2], axis=1) * mm
    return flapping_pose(
        stroke,
        time,
        right_base_B=shape.right_base_B,
        stroke_plane_angle=stroke_plane_angle,
        position_W=position,
        attitude=attitude,
    )
