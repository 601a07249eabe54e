"""The [morphology] section of a fly file, in SI units."""

from __future__ import annotations

from pathlib import Path

from flycontrol.errors import InvalidInputError
from flycontrol.io.fly_files import read_fly_file
from flycontrol.io.quantities import ANGLE, LENGTH, MASS, NUMBER, Kind, read_quantity

_KINDS = {"mass": MASS, "wing_length": LENGTH, "right_hinge": LENGTH, "stroke_plane_angle": ANGLE}
_THREE = ("right_hinge", "stroke_plane_inertia_over_mgr_per_f2")


def read_morphology_table(path: Path | str | None = None) -> dict[str, float | tuple[float, ...]]:
    """Read the [morphology] section of a fly file, in SI units; that of the default fly where the file has none.

    Parameters
    ----------
    path
        As for `read_parameters`.

    Returns
    -------
    dict
        mass [kg], wing_length [m], wing_length_over_mean_chord and, where given, second_moment_radius, right_hinge
        (3 values, body axes [m]), stroke_plane_angle [rad], stroke_plane_inertia_over_mgr_per_f2 (3 values: inertia
        about x, y, z of the stroke-plane frame is these times m g R / f^2).

    Raises
    ------
    InvalidInputError
        If a value cannot be meant.
    """
    fly = read_fly_file(path)
    section = fly.tables.morphology
    given = {name: getattr(section, name) for name in type(section).model_fields}
    return {
        name: _si_values(name, entry.value, fly.where(f"morphology.{name}"))
        for name, entry in given.items()
        if entry is not None
    }


def _si_values(name: str, written: object, where: str) -> float | tuple[float, ...]:
    kind = _KINDS.get(name, NUMBER)
    if name not in _THREE:
        return _si_value(name, written, kind, where)
    if not isinstance(written, list) or len(written) != 3:
        raise InvalidInputError(f"{where}: morphology.{name} is {written!r}; a list of three values is needed.")
    return tuple(_si_value(name, value, kind, where) for value in written)


def _si_value(name: str, written: object, kind: Kind, where: str) -> float:
    if kind is not NUMBER:
        return read_quantity(written, kind, key=f"morphology.{name}", where=where).value
    if isinstance(written, bool) or not isinstance(written, int | float):
        raise InvalidInputError(
            f"{where}: morphology.{name} is {written!r}; a number without unit such as {kind.example} is needed."
        )
    return float(written)
