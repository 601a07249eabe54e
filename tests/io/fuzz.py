"""Readers under malformed files: every case ends in a valid result or in one sentence, in time and without much memory.

A case is a reader and a seed; the corpus keeps the files of cases that once went wrong, or made a library crash.
"""

import random
import signal
import tempfile
import traceback
import warnings
from collections.abc import Callable
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from malformed import damaged_bytes, damaged_table, damaged_toml
from strange_files import TIME, YAW, sound, strange

from flycontrol.errors import FlycontrolError
from flycontrol.io.binary.reader import BinaryReader
from flycontrol.io.description import suggest_mapping
from flycontrol.io.mapping import mapping_text, read_mapping
from flycontrol.io.parameters import read_parameters
from flycontrol.io.recordings import read_recording
from flycontrol.io.trials import read_file, read_trials

CORPUS = Path(__file__).parent / "corpus"
TIME_LIMIT = 120  #: for one case; the binary readers' own limit is shorter [s]
BINARY_LIMITS = {"seconds": 2.0, "memory": 3 * 2**30}

PULSE = '[perturbation]\nonset = { %s, unit = "ms" }\nduration = "5 ms"\n'
VARIABLES = """
name = "fuzz"
[file]
format = "%s"
[clock]
time = { variable = "%st", unit = "s" }
[yaw]
variable = "%syaw"
unit = "rad"
"""
COLUMNS = """
name = "fuzz"
[file]
format = "%s"
channels = "columns"
[clock]
time = { column = "t", unit = "s" }
[yaw]
column = "yaw"
unit = "rad"
[trial]
fly = { column = "fly" }
"""
EXPERIMENT = """
name = "fuzz"
description = "an experiment"
source = "freeflightplots"
[file]
format = "csv"
channels = "columns"
count = 9
[clock]
frame = { column = 0 }
rate = "1000 1/s"
start = "-5 ms"
[yaw]
column = "yaw"
unit = "deg"
sign = -1
offset = "90 deg"
unwrapped = false
[trial]
column = "trial"
name = { path = "(.*)" }
fly = { file_name = "(fly[0-9]+)" }
gaps = "cut"
[perturbation]
trace = { column = "coil", unit = "mA" }
torque_per_unit = "1e-13 N m"
inertia = "3e-13 kg m^2"
[paddling]
left = { column = "l", unit = "deg" }
right = { column = "r", unit = "deg" }
stroke = { column = "s", unit = "deg" }
convention = "attack angle"
[notes]
species = "any"
"""


@dataclass(frozen=True)
class Reader:
    """One reader of files: how its files are made and damaged, and how they are read."""

    name: str
    make: Callable[[random.Random], bytes]
    read: Callable[[Path, BinaryReader], object]
    binary: bool = False


@cache
def readers():
    """All readers by their names."""
    tables = [_table_reader("csv", ","), _table_reader("tsv", "\t"), _table_reader("whitespace", " ")]
    binary = [
        _binary_reader("mat5", VARIABLES % ("mat", "trial.", "trial.") + PULSE % 'variable = "trial.onset"'),
        _binary_reader("mat5 compressed", VARIABLES % ("mat", "trial.", "trial.") + PULSE % 'variable = "trial.onset"'),
        _binary_reader("mat73", VARIABLES % ("mat", "trial/", "trial/") + PULSE % 'variable = "trial.onset"'),
        _binary_reader(
            "hdf5", VARIABLES % ("hdf5", "", "") + '[trial]\ngroups = "tr*"\n' + PULSE % 'variable = "onset"'
        ),
        _binary_reader(
            "hdf5 latest", VARIABLES % ("hdf5", "trial/", "trial/") + '[trial]\nfly = { attribute = "fly" }\n'
        ),
        _binary_reader("netcdf3", VARIABLES % ("netcdf", "", "") + PULSE % 'variable = "onset"'),
        _binary_reader("netcdf4", VARIABLES % ("netcdf", "", "") + PULSE % 'variable = "onset"'),
        _binary_reader("parquet", COLUMNS % "parquet" + PULSE % 'column = "onset"'),
    ]
    tomls = [
        Reader("mapping", lambda rng: damaged_toml(rng.choice(_mappings()), rng), _read_mapping),
        Reader("parameters", lambda rng: damaged_toml(_parameters(), rng), _read_parameters),
    ]
    recording = Reader(
        "recording",
        lambda rng: damaged_table(_recording(), rng, " "),
        lambda path, _: read_recording(path, _turn_map()),
    )
    description = Reader(
        "description", lambda rng: damaged_table(_table(","), rng, ","), lambda path, _: suggest_mapping(path)
    )
    return {reader.name: reader for reader in (*tables, recording, description, *tomls, *binary)}


def case(reader, seed):
    """Return the bytes of a case."""
    return reader.make(random.Random(f"{reader.name} {seed}"))


@dataclass(frozen=True)
class Outcome:
    """How reading a file ended: a "valid" result, "refused" in one sentence, or a "fault".

    "crashed" and "late" are refusals too: a library crashed or hung, and the process that opens binary files ended.
    """

    kind: str
    text: str = ""


def outcome(reader, path, binary_reader):
    """Read a file and say how that ended."""
    try:
        with warnings.catch_warnings(), time_limit():
            warnings.simplefilter("error")
            reader.read(path, binary_reader)
    except FlycontrolError as error:
        return _refusal(str(error))
    except KeyboardInterrupt:
        raise
    except BaseException as error:
        return Outcome("fault", "".join(traceback.format_exception(error)))
    return Outcome("valid")


def outcome_of_case(reader, seed, folder, binary_reader):
    """Write and read a case."""
    path = Path(folder) / f"{reader.name.replace(' ', '_')}.file"
    path.write_bytes(case(reader, seed))
    return outcome(reader, path, binary_reader)


@contextmanager
def time_limit():
    """Raise TimeoutError where a case hangs."""

    def late(*_):
        raise TimeoutError(f"no answer within {TIME_LIMIT} s")

    before = signal.signal(signal.SIGALRM, late)
    signal.alarm(TIME_LIMIT)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)


def _refusal(sentence):
    if "\n" in sentence or not sentence.endswith((".", "?")):
        return Outcome("fault", f"not one sentence: {sentence!r}")
    if not sentence.isprintable() or len(sentence) > 1000:
        return Outcome("fault", f"no printable sentence of ordinary length: {sentence[:300]!r}")
    if "made the library" in sentence:
        return Outcome("crashed", sentence)
    return Outcome("late" if "took longer than" in sentence else "refused", sentence)


def _table_reader(form, delimiter):
    mapping = COLUMNS % form + PULSE % 'column = "onset"'
    return Reader(
        form,
        lambda rng: damaged_table(_table(delimiter), rng, delimiter),
        lambda path, reader: list(read_file(path, _resolved(mapping), reader)),
    )


def _binary_reader(name, mapping):
    def make(rng):
        data = strange(name, rng) if rng.random() < 0.3 else None
        if data is None or rng.random() < 0.2:
            data = damaged_bytes(_sound(name) if data is None else data, rng)
        return data

    def read(path, reader):
        return list(read_file(path, _resolved(mapping), reader))

    return Reader(name, make, read, binary=True)


_sound = cache(sound)


@cache
def _resolved(text):
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "map.toml"
        path.write_text(text)
        return read_mapping(path)


@cache
def _turn_map():
    text = (COLUMNS % "whitespace").replace("[yaw]", 'wingbeat_frequency = "200 Hz"\n[yaw]')  # three fit in 24 ms
    return _resolved(text.replace('[trial]\nfly = { column = "fly" }\n', ""))


@cache
def _table(delimiter):
    header = delimiter.join(("t", "yaw", "fly", "onset"))
    rows = [delimiter.join((repr(float(t)), repr(float(y)), "a", "5")) for t, y in zip(TIME, YAW, strict=True)]
    return "\n".join([header, *rows]).encode()


@cache
def _recording():
    return (
        b"t yaw\n" + "\n".join(f"{t!r} {y!r}" for t, y in zip(map(float, TIME), map(float, YAW), strict=True)).encode()
    )


@cache
def _mappings():
    shipped = [mapping_text(name) for name in ("muijres_freeflight", "fontaine_takeoff")]
    variables = VARIABLES % ("hdf5", "/", "/") + '[trial]\ngroups = "tr*"\n' + PULSE % 'attribute = "onset"'
    return [text.encode() for text in (EXPERIMENT, EXPERIMENT, variables, *shipped)]


@cache
def _parameters():
    from flycontrol.io.fly_files import parameter_text

    return parameter_text("fly").encode()


def _read_mapping(path, _reader):
    mapping = read_mapping(path)
    if mapping.format == "csv":
        with tempfile.TemporaryDirectory() as folder:
            table = Path(folder) / "table.csv"
            table.write_bytes(_table(","))
            read_trials([table], mapping)


def _read_parameters(path, _reader):
    read_parameters(path)
