"""What a tracked flight's page was made from and with: no clock, no machine, no user."""

from __future__ import annotations

import platform
from dataclasses import dataclass
from importlib.metadata import version

from flycontrol.report.track.result import TrackOrigin

_MADE_WITH = ("flycontrol", "numpy", "scipy", "statsmodels", "numba", "matplotlib", "h5py", "pillow")


@dataclass(frozen=True, slots=True, kw_only=True)
class TrackProvenance:
    """Command, inputs by hash, versions."""

    command: str
    inputs: dict[str, str]  #: what it was made from, and the hash of that
    notes: tuple[str, ...]  #: what was decided in reading the films
    versions: dict[str, str]  #: by package, Python first


def track_provenance(origin: TrackOrigin) -> TrackProvenance:
    """Gather it."""
    versions = {"Python": platform.python_version()} | {name: version(name) for name in _MADE_WITH}
    inputs = {f"pixels of frames spread over {', '.join(origin.films) or 'the films'}": origin.images_sha256}
    if origin.cameras is not None and origin.cameras_sha256 is not None:
        inputs[f"cameras: {origin.cameras}"] = origin.cameras_sha256
    inputs[f"fly: {origin.fly}"] = origin.fly_sha256
    return TrackProvenance(command=origin.command, inputs=inputs, notes=origin.notes, versions=versions)
