"""What `flycontrol track` is asked to do, from options to films, cameras and a fly."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass
from glob import glob
from math import pi
from pathlib import Path
from typing import TYPE_CHECKING

from flycontrol.errors import InvalidInputError

if TYPE_CHECKING:
    from flycontrol.model.camera import Camera
    from flycontrol.model.film import Film
    from flycontrol.model.provenance import SourcedMorphology
    from flycontrol.model.world_axes import Axis
    from flycontrol.report.track.result import TrackOrigin
    from flycontrol.vision.checks.footage_check import FootageCheck
    from flycontrol.vision.flight_of_film import FilmedFlight
    from flycontrol.vision.silhouettes import Segmentation
    from flycontrol.vision.tracked_film import Asked


DUST, WINGBEATS = 0.02, 10  #: unless they are typed


@dataclass(frozen=True, slots=True, kw_only=True)
class FilmOptions:
    """Options that say what was filmed, as typed."""

    inputs: tuple[str, ...]
    cameras: Path | None
    frame_rate: float | None
    frames: str | None
    up: str
    unit: str
    camera_variable: str | None
    first_pixel: int | None
    rows_from_below: bool
    film_variable: str | None
    silhouettes: bool | None
    background: str | None
    bright: bool
    contrast: float | None
    dust: float
    wingbeats: int


@dataclass(frozen=True, slots=True, kw_only=True)
class FlyOptions:
    """Options that say which fly, and how it is tracked, as typed."""

    file: str
    body_length: str | None
    stroke_plane_angle: str | None
    fit_sizes: bool | None
    hull_only: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class TrackInputs:
    """All that is needed to track, checked."""

    filmed: FilmedFlight
    asked: Asked
    check: FootageCheck
    fly: SourcedMorphology
    cameras_file: Path | None
    notes: tuple[str, ...]

    def origin(self, command: str) -> TrackOrigin:
        """For result.json."""
        from flycontrol.report.track.result import TrackOrigin

        file = self.cameras_file
        return TrackOrigin(
            command=command,
            films=tuple(film.name for film in self.filmed.footage.films),
            images_sha256=self.check.sha256,
            cameras=None if file is None else file.name,
            cameras_sha256=None if file is None else hashlib.sha256(file.read_bytes()).hexdigest(),
            fly=self.fly.file,
            fly_sha256=self.fly.sha256,
            notes=self.notes,
        )


def track_inputs(films: FilmOptions, which: FlyOptions) -> TrackInputs:
    """Read and check everything; InvalidInputError for what cannot be meant, before any frame is tracked."""
    from flycontrol.io.morphology_files import read_morphology
    from flycontrol.vision.checks.footage_check import checked_footage

    fly = read_morphology(which.file)
    asked = _asked(fly, which, simulated=not films.inputs)
    notes: tuple[str, ...] = ()
    if films.inputs:
        filmed, notes = _filmed(films, fly.morphology.wing_length)
    else:
        filmed = _simulated(films, asked)
    check = checked_footage(filmed.footage, filmed.cameras, fly.morphology.wing_length)
    return TrackInputs(
        filmed=filmed,
        asked=asked,
        check=check,
        fly=fly,
        cameras_file=films.cameras if films.inputs else None,
        notes=notes,
    )


def identity_of(given: TrackInputs, films: FilmOptions) -> str:
    """Digest of all that the coordinates depend on: films, cameras, fly and options."""
    from dataclasses import replace

    from flycontrol.jobs.digest import stamp_of
    from flycontrol.jobs.packed import Packing
    from flycontrol.vision.kept_state import kept

    packing, footage = Packing(), given.filmed.footage
    packing.add(kept(given.asked.fly), "the fly")
    packing.add([camera.matrix for camera in given.filmed.cameras], "the cameras")
    packing.add(list(footage.backgrounds), "the backgrounds")
    options = replace(films, cameras=None, inputs=(), background=None)
    told = (options, given.asked.fit_sizes, given.asked.refine, given.filmed.frames, given.check.sha256)
    total = hashlib.sha256(packing.to_bytes() + repr(told).encode())
    total.update(repr([repr(camera.distortion) for camera in given.filmed.cameras]).encode())
    total.update(stamp_of([path for name in films.inputs for path in _matching(name)]).encode())
    return total.hexdigest()


def _matching(name: str) -> list[Path]:
    if Path(name).exists():
        return [Path(name)]
    return sorted(Path(match) for match in glob(name, recursive=True))  # noqa: PTH207 (a pattern may be absolute)


def _asked(fly: SourcedMorphology, which: FlyOptions, *, simulated: bool) -> Asked:
    from flycontrol.io.quantities import ANGLE, LENGTH, read_quantity
    from flycontrol.units import mm
    from flycontrol.vision.flies import fly_of
    from flycontrol.vision.tracked_film import Asked

    found, angle, length = fly.morphology, None, None
    if which.stroke_plane_angle is not None:
        angle = read_quantity(which.stroke_plane_angle, ANGLE, key="--stroke-plane-angle").value
        if not abs(angle) <= pi:
            raise InvalidInputError(
                f"--stroke-plane-angle is {which.stroke_plane_angle}, outside -180 to 180 deg; it is the angle from "
                "the body's long axis to the stroke plane, about 50 deg."
            )
    if which.body_length is not None:
        length = read_quantity(which.body_length, LENGTH, key="--body-length").value
        if not found.wing_length / 3 < length < found.wing_length * 3:
            raise InvalidInputError(
                f"--body-length is {which.body_length}, but the wings of {found.species} are "
                f"{found.wing_length / mm:.3g} mm long; a fly's body is about as long as a wing."
            )
    followed = fly_of(found, body_length=length, stroke_plane_angle=angle)
    fit = not simulated if which.fit_sizes is None else which.fit_sizes
    return Asked(fly=followed, fit_sizes=fit, refine=not which.hull_only)


def _simulated(films: FilmOptions, asked: Asked) -> FilmedFlight:
    from flycontrol.vision.example_flight import example_flight
    from flycontrol.vision.flight_of_film import FilmedFlight

    _refuse_options_of_films(films)
    made = example_flight(asked.fly, films.wingbeats)
    return FilmedFlight(
        name="Simulated fly",
        footage=made.footage,
        frames=range(len(made.truth)),
        cameras=made.cameras,
        world="z up",
        truth=made.truth,
    )


def _refuse_options_of_films(films: FilmOptions) -> None:
    given = {
        "--cameras": films.cameras is not None, "--frame-rate": films.frame_rate is not None,
        "--frames": films.frames is not None, "--up": films.up != "z", "--unit": films.unit != "mm",
        "--camera-variable": films.camera_variable is not None, "--first-pixel": films.first_pixel is not None,
        "--rows-from-below": films.rows_from_below, "--film-variable": films.film_variable is not None,
        "--silhouettes": films.silhouettes is True, "--grey": films.silhouettes is False,
        "--background": films.background is not None, "--bright": films.bright,
        "--contrast": films.contrast is not None, "--dust": films.dust != DUST,
    }  # fmt: skip
    named = next((name for name, typed in given.items() if typed), None)
    if named is not None:
        raise InvalidInputError(f"{named} belongs to films, but none is given; name the films, or leave it out.")


def _refuse_options_of_grey_films(films: FilmOptions, opened: Sequence[Film]) -> None:
    given = {
        "--contrast": films.contrast is not None, "--bright": films.bright, "--background": films.background is not None
    }  # fmt: skip
    named = next((name for name, typed in given.items() if typed), None)
    if named is not None and all(film.binary for film in opened):
        raise InvalidInputError(
            f"{named} says how silhouettes are made from grey images, but these films are silhouettes already; leave "
            "it out, or say --grey if they are grey images."
        )


def _filmed(films: FilmOptions, wing_length: float) -> tuple[FilmedFlight, tuple[str, ...]]:
    """Films as asked for, and what was decided in reading them."""
    from flycontrol.io.frame_ranges import frame_range
    from flycontrol.io.movies.open_films import open_films
    from flycontrol.model.film_part import FilmPart
    from flycontrol.model.world_axes import upright, upright_words
    from flycontrol.vision.checks.field_of_view import require_field_of_a_fly
    from flycontrol.vision.flight_of_film import FilmedFlight
    from flycontrol.vision.footage import Footage

    if films.wingbeats != WINGBEATS:
        raise InvalidInputError("--wingbeats belongs to the simulated fly; leave it out where films are named.")
    if films.cameras is None:
        raise InvalidInputError("--cameras is missing: films need the file of their cameras' calibration.")
    up = _up(films.up)
    how = _segmentation(films)
    opened = open_films(films.inputs, binary=films.silhouettes, variable=films.film_variable)
    _refuse_options_of_grey_films(films, opened.films)
    frames = frame_range(films.frames, len(opened.films[0]))
    rate = _frame_rate(films.frame_rate, opened.frame_rate) / frames.step
    cameras = _cameras(films, films.cameras, [film.shape for film in opened.films])
    require_field_of_a_fly(cameras, wing_length)
    parts = tuple(FilmPart(film, frames) for film in opened.films)
    backgrounds = _backgrounds(films.background, parts, opened.backgrounds, how)
    turned = tuple(camera.moved(upright(up)) for camera in cameras)
    footage = Footage(films=parts, frame_rate=rate, backgrounds=tuple(backgrounds), how=how)
    name = ", ".join(Path(each).stem for each in films.inputs)
    filmed = FilmedFlight(
        name=name, footage=footage, frames=frames, cameras=_facing(turned), world=upright_words(up)
    )  # fmt: skip
    return filmed, tuple(opened.notes)


def _up(name: str) -> Axis:
    from flycontrol.model.world_axes import AXES

    for axis in AXES:
        if axis == name:
            return axis
    raise InvalidInputError(f"--up must be one of {', '.join(AXES)}, got '{name}'.")


def _segmentation(films: FilmOptions) -> Segmentation:
    from flycontrol.vision.silhouettes import Segmentation

    if not 0 <= films.dust <= 1:
        raise InvalidInputError(
            f"--dust is {films.dust:g}, but it is a share of the largest part's area, from 0 to 1; give 0.02, or leave "
            "it out."
        )
    if films.contrast is not None and not films.contrast > 0:
        raise InvalidInputError(
            f"--contrast is {films.contrast:g}, but it must be above 0 grey levels; leave it out for half the fly's "
            "own."
        )
    return Segmentation(contrast=films.contrast, dark=not films.bright, smallest_share=films.dust)


def _frame_rate(typed: float | None, told: float | None) -> float:
    from flycontrol.io.clock import FASTEST, SLOWEST

    rate = told if typed is None else typed
    if rate is None:
        raise InvalidInputError("--frame-rate is missing: the films do not say how many frames a second they have.")
    if not SLOWEST <= rate <= FASTEST:
        raise InvalidInputError(
            f"{'--frame-rate' if typed is not None else 'the frame rate of the films'} is {rate:g} frames a second, "
            f"outside the plausible {SLOWEST:g} to {FASTEST:g}; a fruit fly beats its wings some 200 times a second."
        )
    return rate


def _cameras(films: FilmOptions, file: Path, shapes: Sequence[tuple[int, int]]) -> tuple[Camera, ...]:
    from flycontrol.io.cameras import read_cameras
    from flycontrol.io.quantities import LENGTH, unit_factor
    from flycontrol.model.camera_forms import PixelConvention

    if films.rows_from_below and films.first_pixel is None:
        raise InvalidInputError("--rows-from-below needs --first-pixel too: 1 as MATLAB counts, 0 as OpenCV does.")
    pixels = None
    if films.first_pixel is not None:
        pixels = PixelConvention(first=float(films.first_pixel), from_below=films.rows_from_below)
    unit = unit_factor(films.unit, LENGTH, key="--unit")
    return read_cameras(file, shapes, unit=unit, pixels=pixels, variable=films.camera_variable)


def _facing(cameras: tuple[Camera, ...]) -> tuple[Camera, ...]:
    from flycontrol.model.camera_forms import facing_the_scene

    return facing_the_scene(cameras)


def _backgrounds(path: str | None, films: Sequence[Film], told: Sequence[object], how: Segmentation) -> list:
    from flycontrol.vision.backgrounds import film_background, median_of

    if path is None:
        return [film_background(film, how) if known is None else known for film, known in zip(films, told, strict=True)]
    empty = _scenes(path, len(films))
    if [film.shape for film in empty] != [film.shape for film in films]:
        raise InvalidInputError(
            f"--background {path} has pictures of {_sizes(empty)} pixels, but the films have {_sizes(films)}; one "
            "picture or film for each camera is needed, of its size and in the cameras' order."
        )
    return [None if film.binary else median_of(scene) for scene, film in zip(empty, films, strict=True)]


def _scenes(path: str, count: int) -> Sequence[Film]:
    """A film for each camera; one film of as many frames as cameras is a picture for each."""
    from flycontrol.io.movies.open_films import open_films
    from flycontrol.model.film_part import FilmPart

    scenes = open_films([path], binary=False).films
    if len(scenes) == 1 and len(scenes[0]) == count:
        return [FilmPart(scenes[0], range(k, k + 1)) for k in range(count)]
    return scenes


def _sizes(films: Sequence[Film]) -> str:
    return ", ".join(f"{rows} x {columns}" for rows, columns in (film.shape for film in films))
