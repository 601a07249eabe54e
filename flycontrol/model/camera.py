"""A calibrated camera: from points in the world to pixels of an image and back to rays.

World in metres. Pixels are (u, v): u counts columns to the right, v rows downwards, both from 0, whole numbers at the
centres of pixels, so that `image[v, u]` is the pixel (u, v).
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from flycontrol.errors import InvalidParameterError
from flycontrol.model.distortion import Distortion

FloatArray = NDArray[np.float64]

#: Least singular value of the rows that see directions, over the largest: below it a camera sees along a line only.
_SINGULAR = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True)
class Rays:
    """Lines of sight: points (N, 3) [m] and unit directions (N, 3) away from the camera."""

    origin: FloatArray
    direction: FloatArray


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Camera:
    """s (u, v, 1) = P (x, y, z, 1), then the lens.

    The matrix is kept scaled so that s is the depth in metres; s > 0 is in front of the camera. An orthographic camera
    has the last row (0, 0, 0, 1), and everything is in front of it.
    """

    matrix: FloatArray  #: P, (3, 4), from [m] to zero-based [px]
    shape: tuple[int, int]  #: rows, columns of its images
    name: str = "camera"
    distortion: Distortion | None = None
    orthographic: bool = field(init=False)

    def __post_init__(self) -> None:
        P = np.array(self.matrix, dtype=np.float64)
        _refuse_impossible(P, self.shape, self.name)
        length = float(np.linalg.norm(P[2, :3]))
        flat = length <= _SINGULAR * float(np.max(np.linalg.norm(P[:2, :3], axis=1)))
        if flat:
            P = P / P[2, 3] if P[2, 3] else P
            P[2, :3] = 0.0
        else:
            P = P / length
        _refuse_singular(P, flat, self.name)
        P.setflags(write=False)
        object.__setattr__(self, "matrix", P)
        object.__setattr__(self, "orthographic", flat)

    @property
    def direction(self) -> FloatArray:
        """(3,) unit vector of the optical axis, away from the camera."""
        if self.orthographic:
            axis = np.cross(self.matrix[0, :3], self.matrix[1, :3])
            return np.asarray(axis / np.linalg.norm(axis), dtype=np.float64)
        return self.matrix[2, :3].copy()

    @property
    def centre(self) -> FloatArray:
        """(3,) centre of projection [m]; InvalidParameterError for an orthographic camera, whose is at infinity."""
        if self.orthographic:
            raise InvalidParameterError(f"{self.name} is orthographic and has no centre; use its direction.")
        return np.asarray(np.linalg.solve(self.matrix[:, :3], -self.matrix[:, 3]), dtype=np.float64)

    @property
    def ideal(self) -> Camera:
        """The same camera without its lens distortion: itself, where it has none."""
        return self if self.distortion is None else replaced(self, distortion=None)

    def depth(self, points: ArrayLike) -> FloatArray:
        """(N,) distance along the optical axis of points (N, 3) [m], from the centre; orthographic: from the origin."""
        X = _rows(points, 3, "points")
        if self.orthographic:
            return X @ self.direction
        return X @ self.matrix[2, :3] + self.matrix[2, 3]

    def project(self, points: ArrayLike) -> FloatArray:
        """Pixels (N, 2) of points (N, 3) [m]; NaN for points that are not in front of the camera."""
        X = _rows(points, 3, "points")
        seen = X @ self.matrix[:, :3].T + self.matrix[:, 3]
        depth = np.where(seen[:, 2:] > 0, seen[:, 2:], np.nan)
        pixels = seen[:, :2] / depth
        return pixels if self.distortion is None else self.distortion.distorted(pixels)

    def rays(self, pixels: ArrayLike) -> Rays:
        """Lines of sight of pixels (N, 2), which need not be whole."""
        uv = _rows(pixels, 2, "pixels")
        uv = uv if self.distortion is None else self.distortion.undistorted(uv)
        if self.orthographic:
            rows = self.matrix[:2, :3]
            origin = np.linalg.lstsq(rows, (uv - self.matrix[:2, 3]).T, rcond=None)[0].T
            return Rays(origin=np.asarray(origin, dtype=np.float64), direction=np.tile(self.direction, (len(uv), 1)))
        homogeneous = np.column_stack([uv, np.ones(len(uv))])
        along = np.linalg.solve(self.matrix[:, :3], homogeneous.T).T
        along /= np.linalg.norm(along, axis=1, keepdims=True)
        return Rays(origin=np.tile(self.centre, (len(uv), 1)), direction=along)

    def pixels_per_metre(self, points: ArrayLike) -> FloatArray:
        """(N,) image scale at points (N, 3) [m]: the geometric mean over the two directions of the image [px/m]."""
        X = _rows(points, 3, "points")
        if self.orthographic:
            area = np.linalg.norm(np.cross(self.matrix[0, :3], self.matrix[1, :3]))
            return np.full(len(X), np.sqrt(area))
        # |det M| / s^3 is the area per area seen from the front, |m3| = 1
        s = np.abs(self.depth(X))
        return np.sqrt(abs(np.linalg.det(self.matrix[:, :3])) / s**2)

    def moved(self, rotation: ArrayLike, translation: ArrayLike = (0.0, 0.0, 0.0)) -> Camera:
        """The camera carried along by x -> R x + t: it sees a moved world as this one sees the world.

        Parameters
        ----------
        rotation : R, (3, 3), orthogonal; a reflection is allowed
        translation : t, (3,) [m]
        """
        R, t = np.asarray(rotation, dtype=np.float64), np.asarray(translation, dtype=np.float64)
        if R.shape != (3, 3) or t.shape != (3,) or not np.allclose(R @ R.T, np.eye(3), atol=1e-9):
            raise InvalidParameterError(f"A camera is moved by an orthogonal (3, 3) matrix and (3,) metres, got {R!r}.")
        M = self.matrix[:, :3] @ R.T
        return replaced(self, matrix=np.column_stack([M, self.matrix[:, 3] - M @ t]))

    def facing(self, point: ArrayLike) -> Camera:
        """The camera with the sign of P by which the point (3,) [m] is in front: calibrations leave it open."""
        if self.orthographic or self.depth(np.reshape(point, (1, 3)))[0] > 0:
            return self
        return replaced(self, matrix=-self.matrix)

    def sees(self, pixels: ArrayLike) -> NDArray[np.bool_]:
        """(N,) whether pixels (N, 2) lie on the image."""
        u, v = _rows(pixels, 2, "pixels").T
        rows, columns = self.shape
        return (u >= -0.5) & (u < columns - 0.5) & (v >= -0.5) & (v < rows - 0.5)


def replaced(camera: Camera, **changes: object) -> Camera:
    """A camera with some fields changed."""
    return replace(camera, **changes)  # pyright: ignore[reportArgumentType]


def _refuse_impossible(P: FloatArray, shape: tuple[int, int], name: str) -> None:
    if P.shape != (3, 4) or not np.all(np.isfinite(P)):
        raise InvalidParameterError(f"{name}: a camera's matrix must be (3, 4) and finite, got {P.tolist()!r}.")
    if not (len(shape) == 2 and all(int(n) == n and n > 0 for n in shape)):
        raise InvalidParameterError(f"{name}: an image needs two whole numbers of rows and columns, got {shape!r}.")


def _refuse_singular(P: FloatArray, flat: bool, name: str) -> None:
    sees = P[:2, :3] if flat else P[:, :3]
    rows = sees / np.maximum(np.linalg.norm(sees, axis=1, keepdims=True), np.finfo(float).tiny)
    if np.linalg.svd(rows, compute_uv=False)[-1] < _SINGULAR or (flat and P[2, 3] != 1.0):
        raise InvalidParameterError(
            f"{name}: its matrix is singular, so that whole planes of points fall on one pixel; check the order of its "
            "coefficients, and that the calibration points did not lie in one plane."
        )


def _rows(values: ArrayLike, columns: int, what: str) -> FloatArray:
    array = np.asarray(values, dtype=np.float64)
    if array.ndim != 2 or array.shape[1] != columns:
        raise InvalidParameterError(f"{what} must have the shape (N, {columns}), got {array.shape}.")
    return array
