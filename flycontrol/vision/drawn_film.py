"""A film of the parametric fly, each frame drawn when it is asked for."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flycontrol.model.camera import Camera
from flycontrol.model.pose import Pose
from flycontrol.vision.fly_shape import FlyShape
from flycontrol.vision.render import BRIGHT, IDEAL, Imaging, grey_frame, render_silhouettes

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class DrawnFilm:
    """Grey frames, dark fly on bright ground, by one camera; frame k is the same whenever it is asked for."""

    shape_of_fly: FlyShape
    pose: Pose  #: N instants
    camera: Camera
    imaging: Imaging = IDEAL
    seed: int = 0  #: of the noise; another one for each camera

    @property
    def name(self) -> str:
        """That of the camera."""
        return self.camera.name

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns [px]."""
        return self.camera.shape

    @property
    def binary(self) -> bool:
        """Never: the frames are grey."""
        return False

    def __len__(self) -> int:
        return len(self.pose)

    def image(self, k: int) -> NDArray[np.uint8]:
        """Frame k, (rows, columns); InvalidInputError if part of the fly is behind the camera."""
        ((mask,),) = render_silhouettes(self.shape_of_fly, self.pose[k], [self.camera])
        return grey_frame(mask, self.imaging, np.random.default_rng([self.seed, k]))

    @property
    def background(self) -> FloatArray:
        """(rows, columns) the empty ground."""
        return np.full(self.shape, BRIGHT)


def drawn_films(
    shape: FlyShape, pose: Pose, cameras: Sequence[Camera], imaging: Imaging = IDEAL, seed: int = 0
) -> tuple[DrawnFilm, ...]:
    """One film a camera, each with its own noise."""
    return tuple(
        DrawnFilm(shape_of_fly=shape, pose=pose, camera=camera, imaging=imaging, seed=len(cameras) * seed + number)
        for number, camera in enumerate(cameras)
    )
