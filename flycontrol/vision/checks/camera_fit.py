"""Whether cameras and a few frames of a film belong together, one animal being in view or several."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from flycontrol.errors import InvalidInputError
from flycontrol.model.camera import Camera
from flycontrol.vision.checks.calibration_check import CalibrationCheck, PairResidual, check_calibration
from flycontrol.vision.checks.camera_order import fitting_order
from flycontrol.vision.sighting import Sighting, one_animal
from flycontrol.vision.views import BoolArray

Frames = Sequence[Sequence[BoolArray]]

#: Epipolar residual over the silhouettes' size from which cameras do not fit, and from which it is told (C), medians of
#: frames. Three cameras of a laboratory: 0.01, single frames of legs and folds up to 0.04; true simulated ones: 0.002;
#: two cameras exchanged: 0.07 at the least; images upside down: 0.15 and more.
_UNFIT, _DOUBTFUL = 0.05, 0.03
_EITHER = (
    "either the calibration is off, or legs or lost pixels shift the silhouettes of these frames; look at the "
    "overlays, track more frames, and check the calibration"
)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ComparedFrames:
    """Silhouettes of one animal that are compared between views."""

    alone: Frames  #: of frames that show one animal in every view
    chosen: Frames  #: of frames that show several: of them the one on which the views agree best
    cut: bool  #: every frame has a silhouette that the border of its image may cut

    @property
    def frames(self) -> Frames:
        """Those of animals alone, if there are any."""
        return self.alone or self.chosen

    @property
    def crowded(self) -> bool:
        """Too many frames show several animals to blame cameras for what does not fit.

        Animals that touch in one view and leave another are not told apart, nor are they one.
        """
        return len(self.chosen) >= len(self.alone) or bool(self.chosen and self.cut)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class CameraFit:
    """How well cameras fit."""

    calibration: CalibrationCheck
    doubt: str  #: a sentence, or empty


def compared_frames(sightings: Sequence[Sighting], cameras: Sequence[Camera]) -> ComparedFrames:
    """Take of sightings that have an animal in every view those that the borders of the images do not cut, if any."""
    inside = [sighting for sighting in sightings if not any(_at_border(mask) for mask in sighting.masks)]
    usable = inside or sightings
    return ComparedFrames(
        alone=[sighting.masks for sighting in usable if not sighting.crowded],
        chosen=[one_animal(sighting.masks, cameras) for sighting in usable if sighting.crowded],
        cut=not inside,
    )


def fit_of_cameras(compared: ComparedFrames, cameras: Sequence[Camera]) -> CameraFit:
    """Compare the extremes of silhouettes across epipolar planes.

    Raises
    ------
    InvalidInputError
        If rays of the same animal miss each other by more than a twentieth of its size.
    """
    calibration, share = _checked(compared.frames, cameras)
    if share > _UNFIT and compared.alone and compared.chosen:  # the former may be animals that touch
        of_chosen, least = _checked(compared.chosen, cameras)
        if least <= _UNFIT:
            calibration, share = of_chosen, least
    if share <= _DOUBTFUL:
        return CameraFit(calibration=calibration, doubt="")
    told = _told(calibration, share)
    if share > _UNFIT and compared.crowded:
        doubt = f"several animals are in view, so that the calibration could not be checked: {told}"
        return CameraFit(calibration=calibration, doubt=doubt)
    other = fitting_order(compared.frames, cameras, _worst(calibration).median)
    better = f"; {other}" if other else ""
    if share > _UNFIT:
        raise InvalidInputError(
            f"The cameras do not fit the images: {told}{better}; check the order of the cameras, how their file counts "
            "pixels (rows from above or below), and whether the images were turned or cropped."
        )
    return CameraFit(calibration=calibration, doubt=f"{told}{better}; {_EITHER}")


def extent(mask: BoolArray) -> float:
    """Diagonal of a silhouette [px]."""
    rows, columns = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    return float(np.hypot(rows[-1] - rows[0] + 1, columns[-1] - columns[0] + 1))


def _checked(frames: Frames, cameras: Sequence[Camera]) -> tuple[CalibrationCheck, float]:
    """The residuals, and the worst pair's over the silhouettes' size."""
    calibration = check_calibration(frames, cameras)
    size = float(np.median([extent(mask) for masks in frames for mask in masks]))
    return calibration, _worst(calibration).median / size


def _worst(calibration: CalibrationCheck) -> PairResidual:
    return max(calibration.pairs, key=lambda pair: pair.median)


def _told(calibration: CalibrationCheck, share: float) -> str:
    worst = _worst(calibration)
    return (
        f"silhouettes of {' and '.join(worst.cameras)} miss each other by {worst.median:.3g} px (median of frames), "
        f"{100 * share:.0f} % of their size"
    )


def _at_border(mask: BoolArray) -> bool:
    return bool(mask[0].any() or mask[-1].any() or mask[:, 0].any() or mask[:, -1].any())
