"""What a report was made from and with, so that it can be made again: no clock, no machine, no user."""

from __future__ import annotations

import platform
from dataclasses import dataclass
from importlib.metadata import version

from flycontrol.identify.conventions import SEED
from flycontrol.identify.flight import FlightAnalysis
from flycontrol.model.parameters import Parameters

_FLIGHT_SEED = f"{SEED} for the block bootstrap of the convention tests; nothing else is drawn at random"
_MADE_WITH = ("flycontrol", "numpy", "scipy", "casadi", "control", "numba", "matplotlib")


@dataclass(frozen=True, slots=True, kw_only=True)
class Provenance:
    """Command, inputs by hash, versions."""

    command: str
    parameter_file: str
    parameter_sha256: str
    defaulted: tuple[str, ...]  #: keys taken from the default parameter file
    recording: str | None  #: name of the recording
    recording_sha256: str | None
    versions: dict[str, str]  #: by package, Python first
    seed: str  #: of anything drawn at random


def provenance(parameters: Parameters, command: str, analysis: FlightAnalysis | None) -> Provenance:
    """Gather it."""
    recording = None if analysis is None else analysis.recording
    return Provenance(
        command=command,
        parameter_file=parameters.file,
        parameter_sha256=parameters.sha256,
        defaulted=parameters.defaulted,
        recording=None if recording is None else recording.name,
        recording_sha256=None if recording is None else recording.source_sha256,
        versions={"Python": platform.python_version()} | {name: version(name) for name in _MADE_WITH},
        seed="none: nothing in this report is drawn at random" if recording is None else _FLIGHT_SEED,
    )
