"""What carving asks of the images: the silhouettes cropped, graded by their slack, and ready to be counted."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from flycontrol.errors import InvalidInputError, InvalidParameterError
from flycontrol.model.camera import Camera
from flycontrol.vision.kernels.distance import distance_to

BoolArray = NDArray[np.bool_]
FloatArray = NDArray[np.float64]

MASK, SLACK = 2, 1  #: grades of pixels on the silhouette and near it


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Views:
    """Silhouettes as ideal cameras see them, cropped to where their grades are not 0."""

    cameras: tuple[Camera, ...]  #: without lenses
    masks: tuple[BoolArray, ...]  #: (rows, columns) each
    grades: NDArray[np.uint8]  #: (C, H, W): 2 on the silhouette, 1 within the slack of it
    corner: FloatArray  #: (C, 2) u, v of the first pixel of each crop
    extent: FloatArray  #: (C, 2, 2) least and largest u, v of the pixels of grades above 0


def views_of(masks: Sequence[BoolArray] | BoolArray, cameras: Sequence[Camera], slack: float = 0.0) -> Views:
    """Silhouettes ready for carving; lens distortion is taken out of them.

    Parameters
    ----------
    masks : C boolean images (rows, columns), true on the animal
    cameras : C cameras
    slack : distance from the silhouette up to which a pixel may belong to it [px]

    Raises
    ------
    InvalidInputError
        If masks and cameras do not fit, or if a silhouette is empty.
    InvalidParameterError
        If the slack is negative.
    """
    if not slack >= 0:
        raise InvalidParameterError(f"The slack of a silhouette must be >= 0 px, got {slack!r}.")
    require_fitting(masks, cameras)
    ideal = tuple(without_lens(mask, camera) for mask, camera in zip(masks, cameras, strict=True))
    _refuse_empty(ideal, cameras)
    crops = [_graded(mask, slack) for mask in ideal]
    height, width = (max(grade.shape[axis] for grade, _ in crops) for axis in (0, 1))
    grades = np.zeros((len(crops), height, width), np.uint8)
    for padded, (grade, _) in zip(grades, crops, strict=True):
        padded[: grade.shape[0], : grade.shape[1]] = grade
    corner = np.array([place for _, place in crops], dtype=np.float64)
    size = np.array([[grade.shape[1] - 1, grade.shape[0] - 1] for grade, _ in crops])
    return Views(
        cameras=tuple(camera.ideal for camera in cameras),
        masks=ideal,
        grades=grades,
        corner=corner,
        extent=np.stack([corner, corner + size], axis=1),
    )


def require_fitting(masks: Sequence[BoolArray] | BoolArray, cameras: Sequence[Camera]) -> None:
    """Refuse images that are not those of the cameras, in number or in shape."""
    if len(masks) != len(cameras) or not len(cameras):
        raise InvalidInputError(
            f"Each camera needs its silhouette: got {len(masks)} images and {len(cameras)} cameras."
        )
    for mask, camera in zip(masks, cameras, strict=True):
        if np.asarray(mask).dtype != np.bool_ or np.shape(mask) != tuple(camera.shape):
            raise InvalidInputError(
                f"{camera.name}: a boolean silhouette of {camera.shape[0]} x {camera.shape[1]} pixels was needed, got "
                f"{np.asarray(mask).dtype} of {' x '.join(map(str, np.shape(mask)))}; check the cameras' order."
            )


def _refuse_empty(masks: Sequence[BoolArray], cameras: Sequence[Camera]) -> None:
    """Name all cameras whose silhouettes are empty; the words are a frame's reason too."""
    empty = [camera.name for mask, camera in zip(masks, cameras, strict=True) if not mask.any()]
    if len(empty) == 1:
        raise InvalidInputError(f"the silhouette of {empty[0]} is empty")
    if empty:
        raise InvalidInputError(f"the silhouettes of {', '.join(empty[:-1])} and {empty[-1]} are empty")


def without_lens(mask: BoolArray, camera: Camera) -> BoolArray:
    """The silhouette as the camera would see it without distortion, each pixel from the nearest one."""
    if camera.distortion is None:
        return np.asarray(mask)
    v, u, seen = _lens_map(camera)
    straight = np.zeros(camera.shape, dtype=np.bool_)
    straight.ravel()[seen] = np.asarray(mask)[v, u]
    return straight


@lru_cache(maxsize=16)
def _lens_map(camera: Camera) -> tuple[NDArray[np.intp], NDArray[np.intp], NDArray[np.intp]]:
    """Rows and columns where the lens puts the ideal pixels that it shows, and which those are."""
    assert camera.distortion is not None
    rows, columns = camera.shape
    v, u = np.mgrid[:rows, :columns].reshape(2, -1)
    bent = camera.distortion.distorted(np.stack([u, v], axis=1).astype(np.float64))
    seen = np.flatnonzero(camera.sees(bent))
    nearest = np.floor(bent[seen] + 0.5).astype(np.intp)
    return nearest[:, 1], nearest[:, 0], seen


def _graded(mask: BoolArray, slack: float) -> tuple[NDArray[np.uint8], tuple[int, int]]:
    """Grades around a silhouette, and (u, v) of their first pixel."""
    reach = int(np.ceil(min(slack, max(mask.shape))))
    rows, columns = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    top, bottom = max(rows[0] - reach, 0), min(rows[-1] + reach + 1, mask.shape[0])
    left, right = max(columns[0] - reach, 0), min(columns[-1] + reach + 1, mask.shape[1])
    near = mask[top:bottom, left:right]
    grade = np.where(near, np.uint8(MASK), np.uint8(0))
    if slack > 0:
        grade[~near & (distance_to(np.ascontiguousarray(near), True) <= slack)] = SLACK
    return grade, (int(left), int(top))
