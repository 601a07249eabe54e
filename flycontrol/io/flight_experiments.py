"""Flight experiments for the simulator, from TOML files laid over the one that the package ships."""

from __future__ import annotations

from dataclasses import replace
from importlib.resources import files
from pathlib import Path
from typing import Any

from flycontrol.errors import FlycontrolError, InvalidInputError
from flycontrol.io.flight_experiment_file import (
    EnsembleTable,
    ExperimentFile,
    SpreadTable,
)
from flycontrol.io.flight_experiment_parts import FlightReader
from flycontrol.io.morphology_files import morphology_in
from flycontrol.io.quantities import ANGLE, NUMBER, TIME
from flycontrol.io.stroke_files import modulations_in, stroke_in
from flycontrol.io.text_files import text_file
from flycontrol.io.toml_files import TomlFile, parse_toml, read_toml_file, structured
from flycontrol.model.flight_experiment import (
    FEWEST_STEPS,
    Ensemble,
    FlightExperiment,
    Spread,
    TorquePulse,
    placed_before_trim,
    refuse_pulses_outside,
)
from flycontrol.model.stroke_kinematics import StrokeKinematics
from flycontrol.model.wing_stroke import BermanWangStroke

_DEFAULT = files("flycontrol.io").joinpath("experiments", "yaw_pulse.toml")
_LAID_OVER = ("trim", "body", "air", "march")  #: what they leave out is as in the default


def experiment_text() -> str:
    """Text of the default experiment."""
    return _default().file.text


def read_flight_experiment(path: Path | str | None = None) -> FlightExperiment:
    """Read a flight experiment.

    Parameters
    ----------
    path
        A TOML file, which may hold any part of the default one; None is the default.

    Returns
    -------
    FlightExperiment
        In SI units.

    Raises
    ------
    InvalidInputError
        For anything that cannot be meant: an unknown key, a number without a unit, a pulse outside the flight.
    """
    toml = _default() if path is None else read_toml_file(Path(path))
    whole = _laid_over_the_default(toml)
    file = structured(ExperimentFile, whole.data, whole)
    try:
        return _experiment(file, whole)
    except InvalidInputError:
        raise
    except FlycontrolError as error:
        raise InvalidInputError(f"{toml.file.name}: {error}") from error


def _experiment(file: ExperimentFile, toml: TomlFile) -> FlightExperiment:
    fly = morphology_in(toml, "morphology")
    read = FlightReader(toml=toml, stroke_plane_angle=fly.morphology.stroke_plane_angle)
    unsteered = {key: value for key, value in file.stroke.items() if key != "modulation"}
    stroke = stroke_in(replace(toml, data=toml.data | {"stroke": unsteered}), "stroke")
    trim = _trim(file, toml)
    _refuse_impossible(file, trim, read)
    _refuse_untrimmable(trim, stroke, toml)
    return FlightExperiment(
        name=file.name,
        morphology=fly.morphology,
        sources=fly.provenance,
        stroke=stroke,
        steering=modulations_in(toml, "stroke"),
        trim=trim,
        body_pitch=read.quantity(file.trim.body_pitch, ANGLE, "trim.body_pitch"),
        wingbeats=file.march.wingbeats,
        free=read.freedoms(file.body),
        left=read.joints(file.hinges, file.hinges.left, "left"),
        right=read.joints(file.hinges, file.hinges.right, "right"),
        pulses=_pulses(file, stroke.frequency, trim, read),
        air=read.air(file.air),
        steps=file.march.steps,
        samples=file.march.samples,
        tolerance=read.quantity(file.march.tolerance, ANGLE, "march.tolerance"),
        ensemble=None if file.ensemble is None else _ensemble(file.ensemble, read),
        file=Path(toml.file.name).name,
        sha256=toml.file.sha256,
    )


def _refuse_impossible(file: ExperimentFile, trim: tuple[str, ...], read: FlightReader) -> None:
    """What the march and the trim would refuse later, with file and line."""
    steps, samples = file.march.steps, file.march.samples
    if steps < FEWEST_STEPS or steps % 2:
        raise read.refusal("march.steps", f"is {steps}; an even number of at least {FEWEST_STEPS} is needed")
    if steps % samples:
        raise read.refusal("march.samples", f"is {samples}; it must divide the {steps} steps a wingbeat")
    if trim and not file.air.terms:
        raise read.refusal("air.terms", "is []: without air no stroke hovers; say moves = [] under [trim]")


def _pulses(
    file: ExperimentFile, frequency: float, trim: tuple[str, ...], read: FlightReader
) -> tuple[TorquePulse, ...]:
    pulses = tuple(read.pulse(table, k) for k, table in enumerate(file.pulse))
    for k, pulse in enumerate(pulses):
        if not placed_before_trim(pulse, trim):
            continue
        try:
            refuse_pulses_outside((pulse,), file.march.wingbeats, frequency)
        except InvalidInputError as error:
            raise InvalidInputError(f"{read.toml.where('pulse', str(k), 'onset')}: {error}") from error
    return pulses


def _trim(file: ExperimentFile, toml: TomlFile) -> tuple[str, ...]:
    names = file.trim.moves
    if names and not len(names) == len(set(names)) == 3:
        raise InvalidInputError(
            f"{toml.where('trim', 'moves')}: trim.moves is {names!r}; three different names are needed, or [] for a "
            "stroke that is flown as it is."
        )
    return tuple(names)


def _refuse_untrimmable(names: tuple[str, ...], stroke: StrokeKinematics, toml: TomlFile) -> None:
    if names and not (isinstance(stroke.left, BermanWangStroke) and stroke.left == stroke.right):
        raise InvalidInputError(
            f"{toml.where('stroke')}: only a Berman and Wang stroke of both wings is trimmed; fly this one as it is, "
            "by moves = [] in [trim]."
        )


def _ensemble(table: EnsembleTable, read: FlightReader) -> Ensemble:
    kinds = {"stroke_offset": ANGLE, "deviation_offset": ANGLE, "pitch_offset": ANGLE, "onset": TIME}
    spread = {
        name: read.deviation(getattr(table.spread, name), kinds.get(name, NUMBER), f"ensemble.spread.{name}")
        for name in SpreadTable.model_fields
        if getattr(table.spread, name) is not None
    }
    return Ensemble(flights=table.flights, seed=table.seed, spread=Spread(**spread))


def _laid_over_the_default(toml: TomlFile) -> TomlFile:
    """Complete a file's tables; a fly and the stroke of a wing are taken whole, since half of one fits no other."""
    default = _default().data
    merged: dict[str, Any] = {"name": Path(toml.file.name).stem} | toml.data
    for section in ("morphology", "stroke", *_LAID_OVER):
        given = toml.data.get(section, {})
        if not isinstance(given, dict):
            way = "; say moves = [] under [trim]" if section == "trim" else f"; a table [{section}] is needed"
            raise InvalidInputError(f"{toml.where(section)}: {section} is {given!r}{way}.")
        merged[section] = default[section] | given if section in _LAID_OVER else given or default[section]
    stroke: dict[str, Any] = {"frequency": default["stroke"]["frequency"]} | merged["stroke"]
    if not {"both", "left", "right"} & set(stroke):
        stroke["both"] = default["stroke"]["both"]
    return replace(toml, data=merged | {"stroke": stroke})


def _default() -> TomlFile:
    return parse_toml(text_file("the default experiment", _DEFAULT.read_bytes()))
