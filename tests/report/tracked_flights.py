"""A short flight that was tracked, made up from its truth: what a page is made of, without the work of tracking."""

from dataclasses import dataclass, replace

import numpy as np

from flycontrol.errors import InvalidInputError
from flycontrol.model.camera_forms import looking_at
from flycontrol.model.flapping_pose import flapping_pose
from flycontrol.model.planform import Planform
from flycontrol.model.pose import Pose
from flycontrol.model.stroke_kinematics import hover_stroke
from flycontrol.units import deg, mm
from flycontrol.vision.checks.calibration_check import check_calibration
from flycontrol.vision.fly_shape import fly_shape
from flycontrol.vision.follower import Fly
from flycontrol.vision.footage import Footage
from flycontrol.vision.render import render_silhouettes
from flycontrol.vision.smoothed_pose import SmoothedPose
from flycontrol.vision.tracked_flight import TrackedFlight
from flycontrol.vision.tracked_frame import Track

RATE, FREQUENCY = 4000.0, 200.0  #: 20 frames a wingbeat
FLY = fly_shape(Planform(length=2.4 * mm, mean_chord=0.7 * mm, second_moment_radius=0.58))
STROKE_PLANE = 50 * deg
SPREAD = np.concatenate([np.full(3, 0.01 * mm), np.full(9, 0.5 * deg), np.full(6, 0.01 * mm)])
PLACES = ((1, 0, 0), (0, 1, 0), (0, 0, 1), (0.7, 0.7, 0.2), (-0.6, 0.5, 0.6))


@dataclass(frozen=True)
class DrawnFilm:
    """Frames held in memory; those named are damaged."""

    name: str
    frames: tuple
    damaged: tuple = ()

    @property
    def shape(self):
        return self.frames[0].shape

    @property
    def binary(self):
        return self.frames[0].dtype == np.bool_

    def __len__(self):
        return len(self.frames)

    def image(self, k):
        if k in self.damaged:
            raise InvalidInputError(f"{self.name}, frame {k}: the image is damaged; leave it out.")
        return self.frames[k]


def cameras_around(count):
    return tuple(
        looking_at((0, 0, 0), 120 * mm * np.array(place), focal=20 / mm * 120 * mm, shape=(160, 160), name=f"view {k}")
        for k, place in enumerate(PLACES[:count])
    )


def motion(frames):
    """Pose of N frames of a fly that turns to the right by 360 deg a second beyond 180 deg."""
    time = np.arange(frames) / RATE
    attitude = np.stack([170 * deg + 2000 * deg * time, np.full(frames, 40 * deg), 300 * deg * time], axis=1)
    return time, flapping_pose(
        hover_stroke(FREQUENCY), time, right_base_B=FLY.right_base_B, stroke_plane_angle=STROKE_PLANE,
        position_W=np.stack([0.1 * time, 0 * time, 0.05 * time], axis=1), attitude=attitude,
    )  # fmt: skip


def tracked_flight(frames=8, *, cameras=3, status=None, truth=True, grey=False, damaged=()):
    """A flight and its footage; `status` by frame, all tracked by default, errors of a tenth of a degree known."""
    time, pose = motion(frames)
    views = cameras_around(cameras)
    drawn = list(render_silhouettes(FLY, pose, views))
    status = status or ("tracked",) * frames
    track = _track(pose, status, cameras)
    flight = TrackedFlight(
        name="made-up flight",
        time=time,
        frame_rate=RATE,
        cameras=views,
        fly=Fly(shape=FLY, stroke_plane_angle=STROKE_PLANE),
        sizes_fitted=False,
        refined=True,
        track=track,
        smoothed=_smoothed(time, track),
        check=check_calibration(drawn, views),
        truth=pose if truth else None,
    )
    look = (lambda mask: np.where(mask, 40, 200).astype(np.uint8)) if grey else (lambda mask: mask)
    films = tuple(
        DrawnFilm(camera.name, tuple(look(masks[c]) for masks in drawn), damaged) for c, camera in enumerate(views)
    )
    backgrounds = tuple(np.full(camera.shape, 200.0) if grey else None for camera in views)
    return flight, Footage(films=films, frame_rate=RATE, backgrounds=backgrounds)


def renamed(flight, name):
    return replace(flight, name=name)


def _track(pose, status, cameras):
    X = pose.coordinates + np.concatenate([np.zeros(3), np.full(9, 0.1 * deg), np.zeros(6)])
    lost = np.array(status) == "lost"
    unseen = lost | (np.array(status) == "bridged")
    X[lost] = np.nan
    overlap = np.linspace(0.85, 0.95, len(pose))[:, None] + np.zeros(cameras)
    overlap[unseen] = np.nan
    reasons = {"tracked": "", "partial": "the silhouette reaches the border of the image of view 0"}
    return Track(
        pose=Pose(coordinates=X, stroke_plane_angle=STROKE_PLANE),
        uncertainty=np.where(lost[:, None], np.nan, np.where(unseen[:, None], 5.0, 1.0) * SPREAD),
        status=tuple(status),
        reasons=tuple(reasons.get(each, "view 0: the silhouette is empty") for each in status),
        overlap=overlap,
        precision=0.99 * np.ones_like(overlap) + 0 * overlap,
    )


def _smoothed(time, track):
    shape = track.uncertainty.shape
    known = np.where(np.isnan(track.uncertainty), np.nan, 1.0)
    return SmoothedPose(
        pose=track.pose,
        uncertainty=track.uncertainty / 2,
        rate=np.zeros(shape) * known,
        rate_uncertainty=10 * SPREAD * known,
        acceleration=np.zeros(shape) * known,
        acceleration_uncertainty=100 * SPREAD * known,
        angular_velocity_B=np.ones((len(time), 3)) * known[:, :1],
        angular_velocity_uncertainty=np.ones((len(time), 3)) * known[:, :1],
    )
