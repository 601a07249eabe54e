"""A netCDF-4 file that grows piece by piece: HDF5 with named dimensions, of which time has no end."""

from __future__ import annotations

import contextlib
from collections.abc import Generator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flycontrol.io.binary.held_file import HeldFile
from flycontrol.io.trajectory_columns import VARIABLES, Variable

FloatArray = NDArray[np.float64]

_ROWS = 1024  #: of an HDF5 chunk
_NO_VARIABLE = "This is a netCDF dimension but not a netCDF variable.{:10d}"  # netCDF-4's own words


@contextlib.contextmanager
def netcdf4_file(
    path: Path, about: dict[str, str | float], name: str, variables: Sequence[Variable] = VARIABLES
) -> Generator[Netcdf4Table]:
    """Open a new file for rows of variables; it is on the disk, whole, when the block ends.

    Parameters
    ----------
    path
        The file, which must not exist yet.
    about
        Its attributes.
    name
        What a refusal calls it.
    variables
        What it holds, time among them; by default those of a trajectory.

    Raises
    ------
    OutputError
        If the disk takes no more.
    """
    import h5py

    held = HeldFile(path, name)
    try:
        with h5py.File(held, "w", track_order=True) as file:
            yield Netcdf4Table(file, held, about, variables)
        held.finish()
    finally:
        held.close()


class Netcdf4Table:
    """The variables over time."""

    def __init__(self, file: Any, held: HeldFile, about: dict[str, str | float], variables: Sequence[Variable]) -> None:
        self._held = held
        file.attrs.update(about)
        self._datasets = {variable.name: _dataset(file, variable) for variable in variables}
        _name_dimensions(file, self._datasets, variables)
        held.require_room()

    def append(self, rows: dict[str, FloatArray]) -> None:
        """Add rows, (n,) or (n, components) of each variable; OutputError if the disk takes no more."""
        for name, dataset in self._datasets.items():
            before, more = len(dataset), len(rows[name])
            dataset.resize(before + more, axis=0)
            dataset[before:] = rows[name]
        self._held.require_room()


def _dataset(file: Any, variable: Variable) -> Any:
    width = (len(variable.components),) if variable.components else ()
    dataset = file.create_dataset(
        variable.name, shape=(0, *width), maxshape=(None, *width), chunks=(_ROWS, *width), dtype="<f8"
    )
    dataset.attrs["units"] = variable.unit
    dataset.attrs["long_name"] = variable.meaning
    if variable.components:
        dataset.attrs["components"] = " ".join(variable.components)
    return dataset


def _name_dimensions(file: Any, datasets: dict[str, Any], variables: Sequence[Variable]) -> None:
    """Make time the unlimited dimension, and name those of the components."""
    datasets["time"].make_scale("time")
    for variable in variables:
        if variable.name != "time":
            datasets[variable.name].dims[0].attach_scale(datasets["time"])
        if variable.components:
            axis = "_".join(variable.components)
            if axis not in file:
                size = len(variable.components)
                file.create_dataset(axis, shape=(size,), dtype=">f4").make_scale(_NO_VARIABLE.format(size))
            datasets[variable.name].dims[1].attach_scale(file[axis])
