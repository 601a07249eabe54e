"""Whether films, cameras and fly belong together, from a few frames, before hours of work on many."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flycontrol.errors import InvalidInputError
from flycontrol.model.camera import Camera
from flycontrol.model.camera_forms import nearest_point
from flycontrol.units import mm
from flycontrol.vision.checks.calibration_check import CalibrationCheck
from flycontrol.vision.checks.camera_fit import Frames, compared_frames, extent, fit_of_cameras
from flycontrol.vision.checks.field_of_view import metres
from flycontrol.vision.footage import FilmedFrame, Footage
from flycontrol.vision.sighting import Sighting, sighting_of
from flycontrol.vision.views import require_fitting

FloatArray = NDArray[np.float64]

_SPREAD = 24  #: frames
#: [1/s] With 8000 fewer than one in a hundred of the wings that are believed, in simulated flights of some 210 Hz, is
#: more than 20 deg off; with 4000 none in seven flights of eight, with 2700 and 2000 up to one in ten (C)
_FEW = 3500.0
_SMALLEST, _LARGEST = 0.4, 8.0  #: largest extent of silhouettes, in wing lengths, that a fly can have (C)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FootageCheck:
    """What a few frames say."""

    calibration: CalibrationCheck
    scale: float  #: mean of the cameras at the animal [px/m]
    doubt: str  #: a sentence about cameras or frame rate, or empty
    sha256: str  #: over the pixels of the frames that were looked at


def spread_frames(count: int, wanted: int = _SPREAD) -> list[int]:
    """Numbers of up to `wanted` frames spread evenly over a film, the first and the last included."""
    return np.unique(np.round(np.linspace(0, count - 1, min(count, wanted))).astype(np.int64)).tolist()


def checked_footage(footage: Footage, cameras: Sequence[Camera], wing_length: float) -> FootageCheck:
    """Refuse films whose cameras, silhouettes or sizes cannot be meant; frames spread over the film are looked at.

    Parameters
    ----------
    footage : films and how silhouettes are made
    cameras : C cameras
    wing_length : of the fly that is expected [m]

    Raises
    ------
    InvalidInputError
        If cameras and films differ in number or size, no frame shows an animal in every view, silhouettes fill the
        images, the animal has no fly's size, or rays of the same animal miss each other.
    """
    frames = [footage.frame(k) for k in spread_frames(len(footage))]
    for frame in frames:
        if not frame.fault:
            require_fitting([silhouette.mask for silhouette in frame.silhouettes], cameras)
    sightings = [sighting_of(frame, cameras) for frame in frames]
    whole = [sighting for sighting in sightings if not sighting.fault and all(mask.any() for mask in sighting.masks)]
    if not whole:
        raise InvalidInputError(_why_nothing(frames, sightings, footage))
    compared = compared_frames(whole, cameras)
    scale = _scale(compared.frames, cameras)
    _refuse_other_size(compared.frames, scale, wing_length)
    fit = fit_of_cameras(compared, cameras)
    doubt = "; ".join(filter(None, (fit.doubt, _of_few_frames(footage.frame_rate) if len(footage) > 1 else "")))
    return FootageCheck(calibration=fit.calibration, scale=scale, doubt=doubt, sha256=_digest(frames))


def _of_few_frames(rate: float) -> str:
    if rate >= _FEW:
        return ""
    return (
        f"{rate:g} frames a second show too little of a wingbeat to follow the wings safely, and of those that count "
        f"as seen some may stand with their edges exchanged; the body is not concerned, films of {_FEW:g} frames a "
        "second and more are not either"
    )


def _digest(frames: Sequence[FilmedFrame]) -> str:
    total = hashlib.sha256()
    for frame in frames:
        for image in frame.images:
            total.update(f"{image.dtype.str} {image.shape}".encode() + np.ascontiguousarray(image).tobytes())
    return total.hexdigest()


def _why_nothing(frames: Sequence[FilmedFrame], sightings: Sequence[Sighting], footage: Footage) -> str:
    faults = [sighting.fault for sighting in sightings if sighting.fault]
    looked = f"{len(frames)} frames spread over the film"
    if len(faults) == len(sightings):
        return f"None of {looked} can be used: {faults[0]}; check the films, the background and the threshold."
    seen = [frame for frame in frames if not frame.fault]
    empty = [
        film.name for k, film in enumerate(footage.films) if not any(frame.silhouettes[k].mask.any() for frame in seen)
    ]
    views = f"{', '.join(empty)} shows none in any of them" if empty else "it leaves one view before it is in another"
    return (
        f"None of {looked} shows an animal in every view: {views}; check the threshold, the background, and whether "
        "the animal is darker or brighter than its ground."
    )


def _scale(frames: Frames, cameras: Sequence[Camera]) -> float:
    """Pixels a metre where the middles of the silhouettes are seen, mean of the cameras and median of the frames."""
    scales: list[float] = []
    for masks in frames:
        rays = [
            camera.rays(np.argwhere(mask)[:, ::-1].mean(axis=0, keepdims=True))
            for mask, camera in zip(masks, cameras, strict=True)
        ]
        point = nearest_point(np.vstack([ray.origin for ray in rays]), np.vstack([ray.direction for ray in rays]))
        if point is not None:
            scales.append(float(np.mean([camera.pixels_per_metre(point[None])[0] for camera in cameras])))
    if not scales:
        raise InvalidInputError("All cameras look along one line, so that depth is not seen; check the calibration.")
    return float(np.median(scales))


def _refuse_other_size(frames: Frames, scale: float, wing_length: float) -> None:
    largest = float(np.median([max(extent(mask) for mask in masks) for masks in frames])) / scale
    if not _SMALLEST * wing_length < largest < _LARGEST * wing_length:
        raise InvalidInputError(
            f"With these cameras the animal would be {metres(largest)} across, where a fly with wings of "
            f"{wing_length / mm:.3g} mm is expected; check the unit of the calibration's lengths, and which fly it is."
        )
