"""Real silhouettes of a take-off with their calibrated cameras, world z up; legs and lost pixels included."""

import numpy as np
import pytest

from flycontrol.model.camera_forms import camera_from_dlt
from flycontrol.units import mm
from flycontrol.vision.silhouettes import cleaned

UPRIGHT = np.diag([1.0, -1.0, -1.0])  # the file's z points down


def real_views(real_data, every):
    """Some frames of three masks, and the cameras."""
    path = real_data / "silhouettes" / "exp095_first47.npz"
    if not path.is_file():
        pytest.skip(f"The silhouettes are not at {path}.")
    with np.load(path) as file:
        shape = tuple(int(n) for n in file["mask_shape"])
        masks = np.unpackbits(file["masks_packed"][::every], axis=-1).reshape(-1, 3, *shape).astype(bool)
        near = UPRIGHT @ file["xh"][:, :3].mean(axis=0) * mm
        cameras = [camera_from_dlt(L, shape, name=f"camera {k + 1}") for k, L in enumerate(file["DLT"].T)]
    frames = [tuple(cleaned(mask).mask for mask in views) for views in masks]
    return frames, [camera.moved(UPRIGHT).facing(near) for camera in cameras]
