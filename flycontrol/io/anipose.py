"""Calibrations as anipose and aniposelib keep them: TOML, one table a camera, OpenCV's lens model."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from flycontrol.errors import InvalidInputError
from flycontrol.io.toml_files import Table, read_toml_file, structured
from flycontrol.model.camera import Camera
from flycontrol.model.camera_forms import Pinhole, camera_from_pinhole, pinhole_of
from flycontrol.units import mm

FloatArray = NDArray[np.float64]

_SKEW = 1e-6  #: relative to the focal length: what rounding leaves


class _AniposeCamera(Table):
    name: str
    size: list[int]  #: columns, rows
    matrix: list[list[float]]
    distortions: list[float]
    rotation: list[float]  #: Rodrigues' vector
    translation: list[float]
    fisheye: bool = False


def read_anipose(path: Path, *, unit: float = mm) -> tuple[Camera, ...]:
    """Cameras of a calibration.toml, in the order of the file; translations in `unit` [m]."""
    toml = read_toml_file(path)
    cameras: list[Camera] = []
    for key, table in toml.data.items():
        if key == "metadata" or not isinstance(table, dict):
            continue
        told = structured(_AniposeCamera, table, toml, key)
        cameras.append(_camera(told, f"{path}, [{key}]", unit))
    if not cameras:
        raise InvalidInputError(f"{path} has no camera; anipose writes tables [cam_0], [cam_1] and so on.")
    return tuple(cameras)


def anipose_text(cameras: Sequence[Camera], *, unit: float = mm) -> str:
    """A calibration.toml that anipose reads, translations in `unit` [m].

    Raises
    ------
    InvalidInputError
        If a camera is orthographic, mirrored or skewed, which that format cannot hold: see `without_skew`.
    """
    parts: list[str] = []
    for k, camera in enumerate(cameras):
        if camera.orthographic:
            raise InvalidInputError(f"{camera.name} is orthographic; anipose keeps projective cameras only.")
        pinhole = pinhole_of(camera)
        _refuse_skew(camera, pinhole)
        parts.append(_table(k, camera, pinhole, unit))
    return "\n".join([*parts, "[metadata]\nadjusted = false\nerror = 0.0\n"])


def without_skew(camera: Camera, points: FloatArray) -> Camera:
    """The camera with right angles between rows and columns whose images of points (N, 3) [m] are nearest.

    DLT coefficients leave the angle free; anipose, OpenCV and most other tools do not. How much is lost is the distance
    of both cameras' projections.
    """
    pinhole = pinhole_of(camera.ideal)
    K = pinhole.intrinsic
    seen = camera.ideal.project(points)
    near = np.mean(np.linalg.norm(points @ pinhole.rotation.T + pinhole.translation, axis=1))
    scale = np.array([K[0, 0], K[1, 1], K[0, 0], K[0, 0], 1, 1, 1, near, near, near])

    def built(x: FloatArray) -> Camera:
        s = x * scale
        straight = np.array([[s[0], 0, s[2]], [0, s[1], s[3]], [0, 0, 1.0]])
        R = Rotation.from_rotvec(s[4:7]).as_matrix() @ pinhole.rotation
        moved = Pinhole(intrinsic=straight, rotation=R, translation=s[7:] + pinhole.translation)
        lens = camera.distortion
        if lens is None:
            return camera_from_pinhole(moved, camera.shape, name=camera.name)
        return camera_from_pinhole(
            moved, camera.shape, radial=lens.radial, tangential=lens.tangential, name=camera.name
        )

    start = np.array([K[0, 0], K[1, 1], K[0, 2], K[1, 2], 0, 0, 0, 0, 0, 0]) / scale
    found = least_squares(lambda x: (built(x).ideal.project(points) - seen).ravel(), start, xtol=1e-14, ftol=1e-14)
    return built(np.asarray(found.x))


def _refuse_skew(camera: Camera, pinhole: Pinhole) -> None:
    K = pinhole.intrinsic
    if K[1, 1] < 0:
        raise InvalidInputError(
            f"{camera.name} sees mirrored images, which anipose cannot keep; count its rows from the other side."
        )
    if abs(K[0, 1]) > _SKEW * K[0, 0]:
        shift = abs(K[0, 1] / K[1, 1]) * camera.shape[0] / 2
        raise InvalidInputError(
            f"{camera.name}: its rows and columns are not at right angles (a skew of {K[0, 1]:.4g} px, {shift:.2g} px "
            "at the border of the image), which anipose cannot keep; replace it by io.anipose.without_skew first."
        )
    lens = camera.distortion
    if lens is not None and not np.allclose(
        [*lens.focal, *lens.centre], [K[0, 0], K[1, 1], K[0, 2], K[1, 2]], rtol=1e-6, atol=1e-3
    ):
        raise InvalidInputError(
            f"{camera.name}: its lens distortion is about another centre or focal length than its matrix has, which "
            "anipose cannot keep."
        )


def _table(k: int, camera: Camera, pinhole: Pinhole, unit: float) -> str:
    lens = camera.distortion
    radial, tangential = (lens.radial, lens.tangential) if lens else ((0.0, 0.0, 0.0), (0.0, 0.0))
    K = pinhole.intrinsic
    matrix = [[K[0, 0], 0.0, K[0, 2]], [0.0, K[1, 1], K[1, 2]], [0.0, 0.0, 1.0]]
    name = "".join(c if c.isprintable() and c not in '"\\' else "_" for c in camera.name)
    return (
        f'[cam_{k}]\nname = "{name}"\nsize = [{camera.shape[1]}, {camera.shape[0]}]\n'
        f"matrix = [{', '.join(_numbers(row) for row in matrix)}]\n"
        f"distortions = {_numbers([*radial[:2], *tangential, radial[2]])}\n"
        f"rotation = {_numbers(Rotation.from_matrix(pinhole.rotation).as_rotvec())}\n"
        f"translation = {_numbers(pinhole.translation / unit)}\n"
    )


def _numbers(values: Sequence[float] | FloatArray) -> str:
    return f"[{', '.join(repr(float(value)) for value in values)}]"


def _camera(told: _AniposeCamera, place: str, unit: float) -> Camera:
    K = np.array(told.matrix, dtype=np.float64) if _is_square(told.matrix) else np.empty(0)
    lens = [*told.distortions, 0.0, 0.0, 0.0, 0.0, 0.0][:5]
    lengths = (len(told.size), len(told.rotation), len(told.translation))
    if K.shape != (3, 3) or lengths != (2, 3, 3) or len(told.distortions) > 5:
        raise InvalidInputError(
            f"{place}: a camera needs size (2 numbers), matrix (3 x 3), up to five distortions, rotation (3) and "
            "translation (3)."
        )
    if told.fisheye:
        raise InvalidInputError(f"{place}: fisheye lenses are not read here; calibrate with the ordinary lens model.")
    k1, k2, p1, p2, k3 = lens
    R = Rotation.from_rotvec(np.array(told.rotation, dtype=np.float64)).as_matrix()
    pinhole = Pinhole(intrinsic=K, rotation=R, translation=np.array(told.translation, dtype=np.float64) * unit)
    return camera_from_pinhole(
        pinhole, (told.size[1], told.size[0]), radial=(k1, k2, k3), tangential=(p1, p2), name=told.name
    )


def _is_square(rows: list[list[float]]) -> bool:
    return len(rows) == 3 and all(len(row) == 3 for row in rows)
