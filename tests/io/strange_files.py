"""Sound files with strange contents: what a program may well write and no recording of a fly is."""

import io
import tempfile
from pathlib import Path

import h5py
import numpy as np
import pyarrow as pa
import pyarrow.parquet
from binary_files import write_hdf5, write_matlab5, write_matlab73, write_netcdf3, write_parquet
from scipy.sparse import csc_array

TIME = np.arange(24) / 1000.0
YAW = 0.3 * np.sin(90 * TIME)


def sound(name):
    """Bytes of a sound file that a mapping of the campaign reads."""
    structure = {"t": TIME, "yaw": YAW, "note": "x", "onset": 5.0}
    variables = {"trial": structure, "table": np.column_stack([TIME, YAW]), "sparse": csc_array(np.eye(4))}
    writers = {
        "mat5": lambda path: write_matlab5(path, variables),
        "mat5 compressed": lambda path: write_matlab5(path, variables, compressed=True),
        "mat73": lambda path: write_matlab73(path, variables),
        "hdf5": lambda path: write_hdf5(path, {"trial": structure}, {"fly": "a"}),
        "hdf5 latest": lambda path: write_hdf5(path, {"trial": structure}, {"fly": "a"}, libver="latest"),
        "netcdf3": lambda path: write_netcdf3(path, {"t": TIME, "yaw": YAW, "onset": [5.0]}, {"yaw": "rad"}, fly="a"),
        "netcdf4": lambda path: write_hdf5(path, {"t": TIME, "yaw": YAW, "onset": 5.0}),
        "parquet": lambda path: write_parquet(path, {"t": TIME, "yaw": YAW, "onset": [5.0] * 24, "fly": ["a"] * 24}),
    }
    return _bytes_of(writers[name])


def strange(name, rng):
    """Bytes of a sound file one of whose variables is strange, or None if the format cannot hold it."""
    values = {"t": TIME, "yaw": YAW, "note": "x", "onset": 5.0, "fly": "a"}
    values[rng.choice(("t", "yaw", "yaw", "onset", "note"))] = _strange_value(rng)
    writers = {
        "mat5": lambda path: write_matlab5(path, {"trial": values}),
        "mat5 compressed": lambda path: write_matlab5(path, {"trial": values}, compressed=True),
        "mat73": lambda path: write_matlab73(path, {"trial": values}),
        "hdf5": lambda path: _write_strange_hdf5(path, values, rng),
        "hdf5 latest": lambda path: write_hdf5(path, {"trial": values}, libver="latest"),
        "netcdf3": lambda path: write_netcdf3(path, {key: values[key] for key in ("t", "yaw", "onset")}),
        "netcdf4": lambda path: write_hdf5(path, values),
        "parquet": lambda path: _write_strange_parquet(path, values, rng),
    }
    try:
        return _bytes_of(writers[name])
    except Exception:  # the format cannot hold it
        return None


def _bytes_of(write):
    with tempfile.TemporaryDirectory() as folder:
        return write(Path(folder) / "file").read_bytes()


def _strange_value(rng):
    choices = (
        lambda: np.zeros((0,)),
        lambda: np.zeros((0, 5)),
        lambda: np.zeros((2, 3, 4)),
        lambda: YAW[: rng.randrange(24)],
        lambda: YAW * 1j,
        lambda: np.where(rng.random() / 40 < TIME, rng.choice((np.nan, np.inf, -np.inf, 1e300, -9999.0)), YAW),
        lambda: np.full(24, rng.choice((0.0, 1.0, np.nan, np.inf, 1e-320))),
        lambda: (YAW * 1000).astype(rng.choice((np.int8, np.uint64, np.int64, np.float16, np.float32, np.bool_))),
        lambda: np.array([2**63 - 1] * 24),
        lambda: rng.choice(("", "hello", "ü" * 50, "\x00", "a" * 2000)),
        lambda: np.array(["a", "bc"] * 12),
        lambda: {"deeper": {"still": {"empty": {}}}},
        dict,
        lambda: _cells(rng),
        lambda: csc_array(YAW[:, None]),
        lambda: csc_array((0, 0)),
        lambda: rng.choice((0.0, -1.0, np.nan, np.inf, 1e308, 5.0)),
        lambda: YAW[::-1] * rng.choice((1e-9, 1.0, 57.3, 1e6)),
        lambda: np.array(rng.sample(list(YAW), 24)),
        lambda: np.broadcast_to(YAW, (3, 24)),
    )
    return rng.choice(choices)()


def _cells(rng):
    cells = np.empty(3, dtype=object)
    cells[:] = [YAW, "word", np.zeros(0)]
    return tuple(cells) if rng.random() < 0.5 else cells


def _write_strange_hdf5(path, values, rng):
    """Write what only HDF5 can: huge declared shapes, links that lead nowhere, loops, references, external files."""
    write_hdf5(path, {"trial": {"note": "x", "onset": 5.0}})
    external = rng.choice(("absent.h5", "/dev/zero", "/etc/passwd", path.name))
    ways = (
        lambda group: group.create_dataset("yaw", shape=(2 ** rng.choice((33, 40, 60)),), chunks=(64,), dtype=float),
        lambda group: group.update(yaw=h5py.SoftLink(rng.choice(("/nowhere", "/trial", "/trial/yaw", "/")))),
        lambda group: group.update(loop=group.file["/"], yaw=YAW),
        lambda group: group.update(yaw=h5py.ExternalLink(external, "/trial/t")),
        lambda group: group.create_dataset("yaw", data=[group.ref] * 24, dtype=h5py.ref_dtype),
        lambda group: group.update(yaw=h5py.Empty(rng.choice((float, "S3")))),
        lambda group: group.create_dataset("yaw", data=[YAW[:3]] * 24, dtype=h5py.vlen_dtype(float)),
        lambda group: group.update(yaw=np.zeros(24, dtype=[("a", float), ("b", "S4")])),
        lambda group: group.update(yaw=YAW.astype(h5py.enum_dtype({"low": 0, "high": 1}, basetype="i4"))),
        lambda group: group.create_dataset("yaw", (24,), float, external=[("/dev/zero", 0, h5py.h5f.UNLIMITED)]),
        lambda group: group.update({key: value for key, value in values.items() if key not in group}),
    )
    with h5py.File(path, "r+") as file:
        file["trial/t"] = TIME
        rng.choice(ways)(file["trial"])
    return path


def _write_strange_parquet(path, values, rng):
    columns = {
        "t": TIME,
        "yaw": rng.choice(
            (
                [None] * 24,
                [[0.1, 0.2]] * 24,
                [{"a": 1.0}] * 24,
                ["x"] * 24,
                pa.array(YAW).dictionary_encode(),
                pa.array([1] * 24, pa.timestamp("ns")),
                pa.array([True] * 24),
                pa.array([b"\xff"] * 24),
                pa.array([None] * 24, pa.null()),
                pa.array(YAW.astype(np.float16)),
                pa.array([1] * 24, pa.decimal128(20, 3)),
                np.where(TIME > 0.01, np.inf, YAW),
                values["yaw"],
            )
        ),
        "onset": [5.0] * 24,
        "fly": rng.choice((["a"] * 24, [None] * 24, ["a"] * 23 + ["b"], list(range(24)))),
    }
    stream = io.BytesIO()
    names = list(columns) if rng.random() < 0.8 else ["t", "yaw", "yaw", "fly"]
    pyarrow.parquet.write_table(pa.table(list(map(pa.array, columns.values())), names=names), stream)
    path.write_bytes(stream.getvalue())
    return path
