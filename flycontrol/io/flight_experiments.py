"""Flight experiments for the simulator, from TOML files laid over the one that the package ships."""

from __future__ import annotations

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
from flycontrol.io.morphology import read_morphology_table
from flycontrol.io.quantities import ANGLE, FREQUENCY, NUMBER, TIME
from flycontrol.io.text_files import text_file
from flycontrol.io.toml_files import TomlFile, parse_toml, read_toml_file, structured
from flycontrol.model.flight_experiment import Air, Ensemble, FlightExperiment, Spread
from flycontrol.model.morphology import Morphology, drosophila_hydei, morphology_from_table
from flycontrol.model.stroke_kinematics import StrokeKinematics

_DEFAULT = files("flycontrol.io").joinpath("experiments", "yaw_pulse.toml")
_LAID_OVER = ("fly", "stroke", "body", "air", "march")  #: what they leave out is as in the default
_PUBLISHED = ("drosophila_melanogaster", "drosophila_hydei")
_SLOWEST, _FASTEST = 20.0, 2000.0  #: plausible wingbeats a second [1/s]


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
    file = structured(ExperimentFile, _laid_over_the_default(toml), toml)
    try:
        return _experiment(file, toml)
    except InvalidInputError:
        raise
    except FlycontrolError as error:
        raise InvalidInputError(f"{toml.file.name}: {error}") from error


def _experiment(file: ExperimentFile, toml: TomlFile) -> FlightExperiment:
    frequency = _frequency(file, toml)
    _refuse_half_a_trim(file, toml)
    morphology = _morphology(file, toml, frequency)
    read = FlightReader(toml=toml, stroke_plane_angle=morphology.stroke_plane_angle)
    return FlightExperiment(
        name=file.name,
        morphology=morphology,
        stroke=StrokeKinematics.symmetric(read.stroke(file.stroke), frequency),
        trim=tuple(file.stroke.trim),
        wingbeats=file.march.wingbeats,
        free=read.freedoms(file.body),
        left=read.joints(file.hinges, file.hinges.left, "left"),
        right=read.joints(file.hinges, file.hinges.right, "right"),
        pulses=tuple(read.pulse(table, k) for k, table in enumerate(file.pulse)),
        steering=tuple(read.steering(table, k) for k, table in enumerate(file.modulation)),
        air=Air(
            terms=tuple(file.air.terms),
            coefficients=file.air.coefficients,
            density=read.density(file.air),
            nodes=file.air.nodes,
        ),
        steps=file.march.steps,
        samples=file.march.samples,
        tolerance=read.quantity(file.march.tolerance, ANGLE, "march.tolerance"),
        ensemble=None if file.ensemble is None else _ensemble(file.ensemble, read),
        file=Path(toml.file.name).name,
        sha256=toml.file.sha256,
    )


def _refuse_half_a_trim(file: ExperimentFile, toml: TomlFile) -> None:
    names = file.stroke.trim
    if names and not len(names) == len(set(names)) == 3:
        raise InvalidInputError(
            f"{toml.where('stroke', 'trim')}: stroke.trim is {names!r}; three different names are needed, or [] for a "
            "stroke that is flown as it is."
        )


def _frequency(file: ExperimentFile, toml: TomlFile) -> float:
    read = FlightReader(toml=toml, stroke_plane_angle=0.0)
    frequency = read.quantity(file.stroke.frequency, FREQUENCY, "stroke.frequency")
    if not _SLOWEST <= frequency <= _FASTEST:
        raise read.refusal(
            "stroke.frequency", f"is {frequency:g} Hz; no fly beats its wings so ({_SLOWEST:g} to {_FASTEST:g} Hz)"
        )
    return frequency


def _morphology(file: ExperimentFile, toml: TomlFile, frequency: float) -> Morphology:
    name = file.fly.morphology
    if name not in _PUBLISHED:
        raise InvalidInputError(
            f"{toml.where('fly', 'morphology')}: fly.morphology is '{name}'; published are {', '.join(_PUBLISHED)}."
        )
    if name == "drosophila_hydei":
        return drosophila_hydei(frequency)
    return morphology_from_table(read_morphology_table(), "Drosophila melanogaster", frequency)


def _ensemble(table: EnsembleTable, read: FlightReader) -> Ensemble:
    kinds = {"stroke_offset": ANGLE, "deviation_offset": ANGLE, "pitch_offset": ANGLE, "onset": TIME}
    spread = {
        name: read.deviation(getattr(table.spread, name), kinds.get(name, NUMBER), f"ensemble.spread.{name}")
        for name in SpreadTable.model_fields
        if getattr(table.spread, name) is not None
    }
    return Ensemble(flights=table.flights, seed=table.seed, spread=Spread(**spread))


def _laid_over_the_default(toml: TomlFile) -> dict[str, Any]:
    default = _default().data
    merged = {"name": Path(toml.file.name).stem} | toml.data
    for section in _LAID_OVER:
        given = toml.data.get(section, {})
        if not isinstance(given, dict):
            raise InvalidInputError(f"{toml.where(section)}: {section} is {given!r}; a table [{section}] is needed.")
        merged[section] = default[section] | given
    return merged


def _default() -> TomlFile:
    return parse_toml(text_file("the default experiment", _DEFAULT.read_bytes()))
