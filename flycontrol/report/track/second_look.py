"""A second look at the footage of a tracked flight, frame by frame: what its page shows of the images."""

from __future__ import annotations

from dataclasses import dataclass, replace

from PIL import Image

from flycontrol.jobs.progress import Progress, no_progress
from flycontrol.report.track.animation import picture_of, stage_of
from flycontrol.report.track.beats import StrokeReversals
from flycontrol.report.track.chosen import ChosenFrame, best_frame, chosen_frames, worst_frame
from flycontrol.report.track.hulls import SeenHull, seen_hull
from flycontrol.report.track.overlays import FrameOverlay, frame_overlay_of, pose_at
from flycontrol.report.track.survey import Survey, consistency_of, survey_of, surveyed_frames
from flycontrol.vision.footage import FilmedFrame, Footage
from flycontrol.vision.hull import ViewConsistency
from flycontrol.vision.stance import stances_of
from flycontrol.vision.tracked_flight import TrackedFlight

_LEAST_COVERED = "the most pixels of a silhouette that the hull leaves uncovered"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SecondLook:
    """What a second look at the footage brought."""

    survey: Survey
    pictures: tuple[Image.Image, ...]  #: of the animation
    overlays: tuple[tuple[ChosenFrame, FrameOverlay], ...]
    hulls: tuple[SeenHull, ...]


def second_look(
    flight: TrackedFlight, footage: Footage, reversals: StrokeReversals, progress: Progress = no_progress
) -> SecondLook:
    """Read some frames again: evenly spread ones, and those that are looked at closely; one at a time."""
    chosen = {each.frame: each for each in chosen_frames(flight, reversals)}
    of_hulls = sorted({k for k in (best_frame(flight), worst_frame(flight)) if k is not None})
    frames = surveyed_frames(len(flight.track))
    stage, spread = stage_of(flight, frames), {int(k): row for row, k in enumerate(frames)}
    wanted = sorted({*spread, *chosen, *of_hulls})
    pictures: list[Image.Image] = []
    consistencies: list[tuple[ViewConsistency, ...]] = []
    overlays: list[tuple[ChosenFrame, FrameOverlay]] = []
    hulls: list[SeenHull] = []
    for done, k in enumerate(wanted):
        frame = footage.frame(k)
        if k in spread:
            pictures.append(picture_of(flight, frame, k, stage, spread[k]))
            consistencies.append(consistency_of(flight, frame))
        if k in chosen:
            overlays.append((chosen[k], frame_overlay_of(flight, frame, k)))
        if k in of_hulls:
            hulls += _hull(flight, frame, k)
        progress(done + 1, len(wanted), "drawing")
    survey = survey_of(frames, consistencies, len(flight.cameras))
    return SecondLook(
        survey=survey,
        pictures=tuple(pictures),
        overlays=_with_least_covered(flight, footage, survey, overlays),
        hulls=tuple(hulls),
    )


def _with_least_covered(
    flight: TrackedFlight, footage: Footage, survey: Survey, overlays: list[tuple[ChosenFrame, FrameOverlay]]
) -> tuple[tuple[ChosenFrame, FrameOverlay], ...]:
    """The frames looked at, and among them that of the silhouette that the hull leaves uncovered most."""
    if survey.least_covered is None:
        return tuple(overlays)
    k = int(survey.frames[survey.least_covered[0]])
    known = {chosen.frame: (chosen, overlay) for chosen, overlay in overlays}
    if k in known:
        chosen, overlay = known[k]
        known[k] = (replace(chosen, rules=(*chosen.rules, _LEAST_COVERED)), overlay)
    else:
        chosen = ChosenFrame(frame=k, rules=(_LEAST_COVERED,))
        known[k] = (chosen, frame_overlay_of(flight, footage.frame(k), k))
    return tuple(known[frame] for frame in sorted(known))


def _hull(flight: TrackedFlight, frame: FilmedFrame, k: int) -> list[SeenHull]:
    pose = pose_at(flight, k)
    if pose is None or not frame.silhouettes:
        return []
    masks = [silhouette.mask for silhouette in frame.silhouettes]
    found = seen_hull(k, masks, flight.cameras, flight.fly.shape, stances_of(pose)[0])
    return [] if found is None else [found]
