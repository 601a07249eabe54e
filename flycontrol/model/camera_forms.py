"""Cameras from and to the forms in which calibrations come: DLT coefficients, intrinsics and pose, ideal cameras."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.linalg import rq

from flycontrol.errors import InvalidParameterError
from flycontrol.model.camera import Camera
from flycontrol.model.distortion import Distortion
from flycontrol.units import mm

FloatArray = NDArray[np.float64]
Shape = tuple[int, int]

DLT_COEFFICIENTS = 11


@dataclass(frozen=True, slots=True, kw_only=True)
class PixelConvention:
    """How a calibration counts pixels: the centre of the first one, and whether v counts rows from below."""

    first: float = 1.0  #: 1 for MATLAB's tools and DLTdv, 0 for OpenCV's
    from_below: bool = False  #: then its v is the last row's number - ours

    def to_ours(self, shape: Shape) -> FloatArray:
        """(3, 3) matrix from its homogeneous pixels to the package's zero-based columns and rows."""
        flip = np.array([[1.0, 0.0, 0.0], [0.0, -1.0, shape[0] - 1.0], [0.0, 0.0, 1.0]])
        shift = np.array([[1.0, 0.0, -self.first], [0.0, 1.0, -self.first], [0.0, 0.0, 1.0]])
        return flip @ shift if self.from_below else shift


#: One-based pixels from above, as MATLAB's images are.
MATLAB_PIXELS = PixelConvention()
#: Zero-based pixels from above, as OpenCV's and anipose's.
OPENCV_PIXELS = PixelConvention(first=0.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class Pinhole:
    """P = K (R | t): what a camera's matrix says of its lens and place."""

    intrinsic: FloatArray  #: K, (3, 3), upper triangular, K[2, 2] = 1 [px]
    rotation: FloatArray  #: R, (3, 3), world to camera: right, down, ahead; proper
    translation: FloatArray  #: t, (3,) [m]


def camera_from_dlt(
    coefficients: ArrayLike,
    shape: Shape,
    *,
    unit: float = mm,
    pixels: PixelConvention = MATLAB_PIXELS,
    name: str = "camera",
) -> Camera:
    """u = (L1 x + L2 y + L3 z + L4) / (L9 x + L10 y + L11 z + 1), v = (L5 x + ... + L8) / (same).

    The world's origin counts as in front of the camera; where it is not, use `Camera.facing`.

    Parameters
    ----------
    coefficients : (11,) L1 to L11
    shape : rows, columns of the images
    unit : of x, y, z [m]
    pixels : how u and v count
    name : for messages
    """
    L = np.asarray(coefficients, dtype=np.float64)
    if L.shape != (DLT_COEFFICIENTS,):
        raise InvalidParameterError(f"{name}: a DLT camera has 11 coefficients, got {L.shape}.")
    P = np.append(L, 1.0).reshape(3, 4)
    return camera_from_matrix(P, shape, unit=unit, pixels=pixels, name=name)


def camera_from_matrix(
    matrix: ArrayLike,
    shape: Shape,
    *,
    unit: float = mm,
    pixels: PixelConvention = OPENCV_PIXELS,
    name: str = "camera",
) -> Camera:
    """Camera of a (3, 4) matrix that maps (x, y, z, 1) in `unit` [m] to homogeneous pixels counted by `pixels`."""
    P = np.asarray(matrix, dtype=np.float64)
    if P.shape != (3, 4):
        raise InvalidParameterError(f"{name}: a camera's matrix must be (3, 4), got {P.shape}.")
    scale = np.array([1.0 / unit, 1.0 / unit, 1.0 / unit, 1.0])
    return Camera(matrix=pixels.to_ours(shape) @ P * scale, shape=shape, name=name)


def dlt_coefficients(camera: Camera, *, unit: float = mm, pixels: PixelConvention = MATLAB_PIXELS) -> FloatArray:
    """(11,) L1 to L11 of a camera: inverse of `camera_from_dlt`; distortion is left out.

    Raises
    ------
    InvalidParameterError
        If the world's origin lies in the plane of the camera, where no DLT exists.
    """
    P = np.linalg.inv(pixels.to_ours(camera.shape)) @ camera.matrix * np.array([unit, unit, unit, 1.0])
    if abs(P[2, 3]) <= 1e-12 * np.max(np.abs(P[2])):
        raise InvalidParameterError(
            f"{camera.name}: the world's origin lies in the plane of the camera, where DLT coefficients are infinite; "
            "move the origin, or keep the (3, 4) matrix."
        )
    return np.asarray((P / P[2, 3]).ravel()[:DLT_COEFFICIENTS])


def camera_from_pinhole(
    pinhole: Pinhole,
    shape: Shape,
    *,
    radial: tuple[float, float, float] = (0.0, 0.0, 0.0),
    tangential: tuple[float, float] = (0.0, 0.0),
    name: str = "camera",
) -> Camera:
    """P = K (R | t), with Brown's lens coefficients k1, k2, k3 and p1, p2 about K's centre."""
    K = pinhole.intrinsic
    lens = None
    if any(radial) or any(tangential):
        focal, centre = (float(K[0, 0]), float(K[1, 1])), (float(K[0, 2]), float(K[1, 2]))
        lens = Distortion(focal=focal, centre=centre, radial=radial, tangential=tangential)
    P = K @ np.column_stack([pinhole.rotation, pinhole.translation])
    return Camera(matrix=P, shape=shape, name=name, distortion=lens)


def pinhole_of(camera: Camera) -> Pinhole:
    """K, R, t with P = K (R | t), K[0, 0] > 0 and R proper; K[1, 1] < 0 tells of mirrored images.

    Raises
    ------
    InvalidParameterError
        For an orthographic camera, which has no such form.
    """
    if camera.orthographic:
        raise InvalidParameterError(f"{camera.name} is orthographic: it has no focal length.")
    K, R = rq(camera.matrix[:, :3])
    signs = np.sign(np.diag(K))
    signs[signs == 0] = 1.0
    K, R = K * signs, R * signs[:, None]
    if np.linalg.det(R) < 0:
        mirror = np.array([1.0, -1.0, 1.0])
        K, R = K * mirror, R * mirror[:, None]
    t = np.asarray(np.linalg.solve(K, camera.matrix[:, 3]), dtype=np.float64)
    return Pinhole(intrinsic=K / K[2, 2], rotation=R, translation=t)


def looking_at(target: ArrayLike, place: ArrayLike, *, focal: float, shape: Shape, name: str = "camera") -> Camera:
    """An ideal projective camera at `place` (3,) [m] whose axis passes through `target` (3,) [m].

    The world's z points up in its images, or its x where it looks along z.

    Parameters
    ----------
    focal : image distance [px]; the scale at the target is focal / distance [px/m]
    """
    R = _view_rotation(np.asarray(target, dtype=np.float64) - np.asarray(place, dtype=np.float64), name)
    K = np.array([[focal, 0.0, (shape[1] - 1) / 2], [0.0, focal, (shape[0] - 1) / 2], [0.0, 0.0, 1.0]])
    t = np.asarray(-R @ np.asarray(place, dtype=np.float64), dtype=np.float64)
    return camera_from_pinhole(Pinhole(intrinsic=K, rotation=R, translation=t), shape, name=name)


def orthographic_camera(
    direction: ArrayLike, *, scale: float, shape: Shape, target: ArrayLike = (0.0, 0.0, 0.0), name: str = "camera"
) -> Camera:
    """An ideal camera at infinity that looks along `direction` (3,), `target` (3,) [m] in the middle of its image.

    Parameters
    ----------
    scale : [px/m]
    """
    R = _view_rotation(np.asarray(direction, dtype=np.float64), name)[:2]
    middle = (np.array(shape[::-1], dtype=np.float64) - 1) / 2
    offset = middle - scale * R @ np.asarray(target, dtype=np.float64)
    P = np.vstack([np.column_stack([scale * R, offset]), [0.0, 0.0, 0.0, 1.0]])
    return Camera(matrix=P, shape=shape, name=name)


def orthogonal_cameras(
    *, scale: float, shape: Shape, target: ArrayLike = (0.0, 0.0, 0.0), distance: float | None = None
) -> tuple[Camera, Camera, Camera]:
    """Three ideal cameras that look along -x, -y and -z, as in a flight arena.

    Parameters
    ----------
    scale : at the target [px/m]
    shape : rows, columns
    target : in the middle of all images, (3,) [m]
    distance : of projective cameras from the target [m]; None: orthographic cameras
    """
    middle = np.asarray(target, dtype=np.float64)
    views: list[Camera] = []
    for name, axis in zip(("from x", "from y", "from z"), np.eye(3), strict=True):
        if distance is None:
            views.append(orthographic_camera(-axis, scale=scale, shape=shape, target=middle, name=name))
        else:
            place = middle + distance * axis
            views.append(looking_at(middle, place, focal=scale * distance, shape=shape, name=name))
    return views[0], views[1], views[2]


def facing_the_scene(cameras: Sequence[Camera]) -> tuple[Camera, ...]:
    """Cameras with signs of P by which the point nearest to all optical axes is in front of each.

    One camera alone, or parallel ones, stay as they are.
    """
    axes = [camera.rays(np.array([[(n - 1) / 2 for n in camera.shape[::-1]]])) for camera in cameras]
    origins = np.vstack([ray.origin for ray in axes])
    directions = np.vstack([ray.direction for ray in axes])
    point = nearest_point(origins, directions)
    return tuple(cameras) if point is None else tuple(camera.facing(point) for camera in cameras)


def nearest_point(origins: FloatArray, directions: FloatArray) -> FloatArray | None:
    """x = (sum of 1 - d d^T)^-1 (sum of (1 - d d^T) o): nearest to lines in the mean square; None where parallel.

    Parameters
    ----------
    origins, directions : (N, 3), points on the lines [m] and unit vectors along them
    """
    across = np.eye(3) - directions[:, :, None] * directions[:, None, :]
    normal = across.sum(axis=0)
    if np.linalg.cond(normal) > 1e9:
        return None
    return np.linalg.solve(normal, np.einsum("nij,nj->i", across, origins))


def _view_rotation(direction: FloatArray, name: str) -> FloatArray:
    """(3, 3) rows right, down, ahead of a camera that looks along `direction`."""
    length = float(np.linalg.norm(direction))
    if direction.shape != (3,) or not (length > 0 and np.isfinite(length)):
        raise InvalidParameterError(f"{name} needs a direction to look at, got {direction.tolist()!r}.")
    ahead = direction / length
    up = np.array([0.0, 0.0, 1.0]) if abs(ahead[2]) < 0.99 else np.array([1.0, 0.0, 0.0])
    right = np.cross(ahead, up)
    right /= np.linalg.norm(right)
    return np.stack([right, np.cross(ahead, right), ahead])
