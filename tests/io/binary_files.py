"""Writes the same variables as MATLAB, HDF5, netCDF and Parquet files, version 7.3 in MATLAB's own dialect."""

import h5py
import numpy as np
import pyarrow as pa
import pyarrow.parquet
import scipy.io
from scipy.sparse import csc_array, issparse


def write_matlab5(path, variables, *, compressed=False):
    scipy.io.savemat(path, variables, do_compression=compressed, oned_as="column")
    with path.open("r+b") as file:  # SciPy's header says when it was written: the same variables are the same bytes
        file.write(b"MATLAB 5.0 MAT-file Platform: posix, Created on: Thu Jan  1 00:00:00 1970".ljust(116))
    return path


def write_matlab73(path, variables):
    with h5py.File(path, "w", userblock_size=512) as file:
        for name, value in variables.items():
            _write_73(file, file, name, value)
    head = b"MATLAB 7.3 MAT-file, Platform: GLNXA64, HDF5 schema 1.00 .".ljust(124) + b"\x00\x02IM"
    with path.open("r+b") as file:
        file.write(head.ljust(512, b"\0"))
    return path


def _write_73(file, parent, name, value):
    if isinstance(value, dict):
        group = parent.create_group(name)
        group.attrs["MATLAB_class"] = np.bytes_("struct")
        for field, inner in value.items():
            _write_73(file, group, field, inner)
    elif isinstance(value, list):  # an array of structures: for each field references to the elements' values
        group = parent.create_group(name)
        group.attrs["MATLAB_class"] = np.bytes_("struct")
        for field in value[0]:
            group.create_dataset(field, data=_references(file, [element[field] for element in value]))
    elif isinstance(value, tuple):
        cell = parent.create_dataset(name, data=_references(file, value))
        cell.attrs["MATLAB_class"] = np.bytes_("cell")
    elif issparse(value):
        _write_sparse(parent.create_group(name), csc_array(value))
    elif isinstance(value, str):
        codes = np.frombuffer(value.encode("utf-16-le"), dtype="<u2")[:, None]
        parent.create_dataset(name, data=codes).attrs["MATLAB_class"] = np.bytes_("char")
    else:
        array = np.asarray(value)
        array = array.reshape(-1, 1) if array.ndim < 2 else array
        parent.create_dataset(name, data=array.T).attrs["MATLAB_class"] = np.bytes_("double")


def _write_sparse(group, matrix):
    group.attrs["MATLAB_class"] = np.bytes_("double")
    group.attrs["MATLAB_sparse"] = np.uint64(matrix.shape[0])
    group["data"] = matrix.data
    group["ir"], group["jc"] = matrix.indices.astype(np.uint64), matrix.indptr.astype(np.uint64)


def _references(file, values):
    hidden = file.require_group("#refs#")
    references = np.empty((1, len(values)), dtype=h5py.ref_dtype)
    for k, value in enumerate(values):
        name = f"r{len(hidden)}"
        _write_73(file, hidden, name, value)
        references[0, k] = hidden[name].ref
    return references


def write_hdf5(path, variables, attributes=(), **options):
    with h5py.File(path, "w", **options) as file:
        _write_groups(file, variables)
        file.attrs.update(dict(attributes))
    return path


def _write_groups(group, variables):
    for name, value in variables.items():
        if isinstance(value, dict):
            _write_groups(group.create_group(name), value)
        elif np.ndim(value):
            group.create_dataset(name, data=value, chunks=True, compression="gzip", shuffle=True)
        else:
            group[name] = value


def write_netcdf3(path, variables, units=(), **attributes):
    with scipy.io.netcdf_file(path, "w") as file:
        for name, value in variables.items():
            array = np.asarray(value).astype(np.float64, casting="same_kind")
            for axis, length in enumerate(array.shape):
                file.createDimension(f"{name}_{axis}", length)
            variable = file.createVariable(name, "d", tuple(f"{name}_{axis}" for axis in range(array.ndim)))
            variable[...] = array
            for key, unit in dict(units).items():
                if key == name:
                    variable.units = unit
        for name, value in attributes.items():
            setattr(file, name, value)
    return path


def write_parquet(path, variables, metadata=()):
    table = pa.table({name: pa.array(value) for name, value in variables.items()})
    pyarrow.parquet.write_table(table.replace_schema_metadata(dict(metadata)), path)
    return path
