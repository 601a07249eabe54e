"""What a validation was made with: no clock, no machine, no user."""

from __future__ import annotations

import platform
from dataclasses import dataclass
from importlib.metadata import version

_MADE_WITH = ("flycontrol", "numpy", "scipy", "casadi", "numba", "matplotlib")


@dataclass(frozen=True, slots=True, kw_only=True)
class ValidationProvenance:
    """Command and versions."""

    command: str
    versions: dict[str, str]  #: by package, Python first


def validation_provenance(command: str) -> ValidationProvenance:
    """Gather it."""
    versions = {"Python": platform.python_version()} | {name: version(name) for name in _MADE_WITH}
    return ValidationProvenance(command=command, versions=versions)
