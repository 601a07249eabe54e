"""Trajectories to files, piece by piece as they are flown: netCDF-4, HDF5 or CSV. Memory holds one piece."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Generator, Sequence
from pathlib import Path
from typing import Any, Literal, Protocol, get_args

import numpy as np
from numpy.typing import NDArray

from flycontrol.errors import OutputError
from flycontrol.io.binary.netcdf4_file import netcdf4_file
from flycontrol.io.trajectory_columns import VARIABLES, Variable, table_of
from flycontrol.model.trajectory import Trajectory

FloatArray = NDArray[np.float64]
TrajectoryFormat = Literal["netcdf", "hdf5", "csv"]
FORMATS: tuple[TrajectoryFormat, ...] = get_args(TrajectoryFormat)
FILE_NAMES: dict[TrajectoryFormat, str] = {
    "netcdf": "trajectory.nc",
    "hdf5": "trajectory.h5",
    "csv": "trajectory.csv",
}

_DIGITS = "%.15g"


class RowTable(Protocol):
    """A file that takes rows."""

    def append(self, rows: dict[str, FloatArray]) -> None:
        """Add rows, (n,) or (n, components) of each variable."""
        ...


class TrajectoryWriter:
    """Takes a flight in pieces, each beginning where the one before it ended."""

    def __init__(self, table: RowTable, stroke_plane_angle: float) -> None:
        self._table, self._angle = table, stroke_plane_angle
        self._yaw: float | None = None
        self.samples = 0

    def add(self, piece: Trajectory) -> None:
        """Write a piece; OutputError if it cannot be written."""
        rows = table_of(piece, self._angle)
        if self._yaw is not None:
            rows["yaw"] = np.unwrap([self._yaw, *rows["yaw"]])[1:]
            rows = {name: values[1:] for name, values in rows.items()}
        if not len(rows["time"]):
            return
        self._yaw = float(rows["yaw"][-1])
        self._table.append(rows)
        self.samples += len(rows["time"])


@contextlib.contextmanager
def trajectory_writer(
    path: Path, form: TrajectoryFormat, *, stroke_plane_angle: float, about: dict[str, str | float], name: str
) -> Generator[TrajectoryWriter]:
    """Open a new file for the pieces of one flight; it is on the disk, whole, when the block ends.

    Parameters
    ----------
    path
        The file, which must not exist yet.
    form
        netcdf and hdf5 are the same bytes: a netCDF-4 file is an HDF5 file.
    stroke_plane_angle
        v_S = Ry(angle) v_B [rad].
    about
        What the file says of itself: its attributes; left out of CSV.
    name
        What a refusal calls the file.

    Raises
    ------
    OutputError
        If the disk takes no more.
    """
    with table_file(path, form, VARIABLES, about=about, name=name) as table:
        yield TrajectoryWriter(table, stroke_plane_angle)


@contextlib.contextmanager
def table_file(
    path: Path, form: TrajectoryFormat, variables: Sequence[Variable], *, about: dict[str, str | float], name: str
) -> Generator[RowTable]:
    """Open a new file for rows of any variables, time among them; parameters and errors as of `trajectory_writer`."""
    opened = _csv(path, name, variables) if form == "csv" else netcdf4_file(path, about, name, variables)
    with opened as table:
        yield table


@contextlib.contextmanager
def _csv(path: Path, name: str, variables: Sequence[Variable]) -> Generator[RowTable]:
    try:
        with path.open("x", encoding="ascii", newline="\n") as file:
            yield _CsvTable(file, variables)
            file.flush()
            os.fsync(file.fileno())
    except OSError as error:
        if isinstance(error, OutputError):
            raise
        raise OutputError(f"{name} could not be written: {error.strerror or error}.") from error


class _CsvTable:
    def __init__(self, file: Any, variables: Sequence[Variable]) -> None:
        self._file, self._variables = file, variables
        file.write(",".join(column for variable in variables for column in variable.columns) + "\n")

    def append(self, rows: dict[str, FloatArray]) -> None:
        columns = [rows[variable.name].reshape(len(rows["time"]), -1) for variable in self._variables]
        np.savetxt(self._file, np.hstack(columns), fmt=_DIGITS, delimiter=",")
