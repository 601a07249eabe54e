"""Whether a fly can fill a plausible part of what the cameras see, before any image is looked at."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from flycontrol.errors import InvalidInputError
from flycontrol.model.camera import Camera
from flycontrol.model.camera_forms import nearest_point
from flycontrol.units import mm

#: Fields in wing lengths (C). In a larger one a wing has fewer than three pixels of a thousand; a smaller one does not
#: hold a wing.
_SMALLEST, _LARGEST = 0.5, 500.0


def field_of_view(cameras: Sequence[Camera]) -> float | None:
    """Diagonal of the images where the cameras look [m], median of them; None where they look along one line."""
    rays = [camera.rays((np.array([camera.shape[::-1]]) - 1) / 2) for camera in cameras]
    middle = nearest_point(np.vstack([ray.origin for ray in rays]), np.vstack([ray.direction for ray in rays]))
    if middle is None:
        return None
    fields = [np.hypot(*camera.shape) / float(camera.pixels_per_metre(middle[None])[0]) for camera in cameras]
    return float(np.median(fields))


def require_field_of_a_fly(cameras: Sequence[Camera], wing_length: float) -> None:
    """Refuse cameras that see a field in which no fly can be tracked, as of another unit.

    Parameters
    ----------
    cameras : C cameras
    wing_length : of the fly that is expected [m]

    Raises
    ------
    InvalidInputError
        If the field is smaller than half a wing, or larger than 500 wings.
    """
    field = field_of_view(cameras)
    if field is not None and not _SMALLEST * wing_length < field < _LARGEST * wing_length:
        raise InvalidInputError(
            f"These cameras see a field that is {metres(field)} across, where a fly with wings of "
            f"{wing_length / mm:.3g} mm is expected; check the unit of the calibration's lengths, and whether these "
            "are the films' cameras."
        )


def metres(length: float) -> str:
    """Write a length [m] in m or mm."""
    return f"{length:.3g} m" if length >= 0.1 else f"{length / mm:.3g} mm"
