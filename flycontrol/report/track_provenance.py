"""What a tracked flight's page was made with: no clock, no machine, no user."""

from __future__ import annotations

import platform
from dataclasses import dataclass
from importlib.metadata import version

_MADE_WITH = ("flycontrol", "numpy", "scipy", "statsmodels", "numba", "matplotlib", "h5py", "pillow")


@dataclass(frozen=True, slots=True, kw_only=True)
class TrackProvenance:
    """Command and versions."""

    command: str
    versions: dict[str, str]  #: by package, Python first


def track_provenance(command: str) -> TrackProvenance:
    """Gather it."""
    versions = {"Python": platform.python_version()} | {name: version(name) for name in _MADE_WITH}
    return TrackProvenance(command=command, versions=versions)
