import sys

import h5py
import numpy as np
import pytest
import scipy.io
from binary_files import write_hdf5, write_matlab5, write_matlab73, write_netcdf3, write_parquet
from scipy.sparse import csc_array

from flycontrol.errors import InvalidInputError
from flycontrol.io.binary.reader import shared_reader
from flycontrol.io.trials import read_trials

RATE = 2000.0
TIME = np.arange(120) / RATE
YAW = 170 + 30 * np.sin(40 * TIME)  # [deg], beyond 180


def wrapped(angle):
    return (angle + 180) % 360 - 180


def mapping_text(form, time="variable = 't'", yaw="variable = 'yaw'", extra="", channels=""):
    return (
        f"name = 'test'\n[file]\nformat = '{form}'\n{channels}\n"
        f"[clock]\ntime = {{ {time}, unit = 's' }}\n[yaw]\n{yaw}\nunit = 'deg'\n{extra}"
    )


@pytest.fixture
def mapping(tmp_path):
    def write(*arguments, **named):
        path = tmp_path / "map.toml"
        path.write_text(mapping_text(*arguments, **named))
        return path

    return write


def refusal(paths, mapping):
    with pytest.raises(InvalidInputError) as error:
        read_trials(paths if isinstance(paths, list) else [paths], mapping)
    sentence = str(error.value)
    assert "\n" not in sentence
    assert sentence.endswith((".", "?"))
    return sentence


def assert_read(trial):
    np.testing.assert_allclose(np.degrees(trial.yaw), YAW, rtol=1e-13)
    np.testing.assert_allclose(trial.time, TIME, rtol=1e-15)
    assert trial.rate == pytest.approx(RATE, rel=1e-12)


VARIABLES = {"t": TIME, "yaw": wrapped(YAW)}


@pytest.mark.parametrize(
    ("form", "write", "options"),
    [
        ("mat", write_matlab5, {}),
        ("mat", write_matlab5, {"compressed": True}),
        ("mat", write_matlab73, {}),
        ("hdf5", write_hdf5, {}),
        ("hdf5", write_hdf5, {"libver": "latest"}),
        ("netcdf", write_hdf5, {}),  # netCDF-4 is HDF5
        ("netcdf", write_netcdf3, {}),
    ],
)
def test_every_format_of_variables_holds_the_same_trial(tmp_path, mapping, form, write, options):
    assert_read(read_trials([write(tmp_path / "a", VARIABLES, **options)], mapping(form))[0])


def test_parquet_is_a_table_with_named_or_numbered_columns(tmp_path, mapping):
    path = write_parquet(tmp_path / "a.parquet", VARIABLES)
    for time, yaw in (("column = 't'", "column = 'yaw'"), ("column = 0", "column = 1")):
        assert_read(read_trials([path], mapping("parquet", time, yaw))[0])


@pytest.mark.parametrize("write", [write_matlab5, write_matlab73])
@pytest.mark.parametrize("path", ["trial.body.yaw", "trial/body/yaw"])
def test_nested_structures_are_reached_by_path(tmp_path, mapping, write, path):
    file = write(tmp_path / "a.mat", {"t": TIME, "trial": {"body": {"yaw": wrapped(YAW)}, "note": "x"}})
    assert_read(read_trials([file], mapping("mat", yaw=f"variable = '{path}'"))[0])


@pytest.mark.parametrize("write", [write_matlab5, write_matlab73, write_hdf5, write_netcdf3])
def test_rows_and_columns_are_those_of_the_program_that_wrote_them(tmp_path, mapping, write):
    form = {write_hdf5: "hdf5", write_netcdf3: "netcdf"}.get(write, "mat")
    file = write(tmp_path / "a", {"data": np.column_stack([TIME, 0 * TIME, wrapped(YAW)])})
    place = "variable = 'data', column = {}"
    assert_read(read_trials([file], mapping(form, place.format(0), place.format(2).replace(", ", "\n")))[0])
    turned = write(tmp_path / "b", {"data": np.stack([TIME, 0 * TIME, wrapped(YAW)])})
    place = "variable = 'data', row = {}"
    assert_read(read_trials([turned], mapping(form, place.format(0), place.format(2).replace(", ", "\n")))[0])


@pytest.mark.parametrize("write", [write_matlab5, write_matlab73])
def test_sparse_matrices_are_written_out(tmp_path, mapping, write):
    yaw = np.where(np.arange(120) % 3, wrapped(YAW), 0.0)
    file = write(tmp_path / "a.mat", {"t": TIME, "yaw": csc_array(yaw[:, None] * 0.1)})
    trial = read_trials([file], mapping("mat"))[0]
    np.testing.assert_allclose(np.degrees(trial.yaw) - yaw * 0.1, 0, atol=1e-12)


@pytest.mark.parametrize("write", [write_matlab5, write_matlab73])
def test_an_array_of_structures_is_several_trials(tmp_path, mapping, write):
    elements = [{"t": TIME[: 60 + 20 * k], "yaw": YAW[: 60 + 20 * k] - 100, "fly": f"fly {k // 2}"} for k in range(4)]
    if write is write_matlab5:
        dtype = [(name, object) for name in elements[0]]
        trials = np.array([[tuple(element.values()) for element in elements]], dtype=dtype)
    else:
        trials = elements
    file = write(tmp_path / "a.mat", {"trials": trials})
    extra = "[trial]\ngroups = 'trials'\nfly = { variable = 'fly' }\n"
    read = read_trials([file], mapping("mat", extra=extra))
    assert [trial.name for trial in read] == [f"a:trials({k})" for k in (1, 2, 3, 4)]
    assert [trial.fly for trial in read] == ["fly 0", "fly 0", "fly 1", "fly 1"]
    assert [len(trial.yaw) for trial in read] == [60, 80, 100, 120]
    single = read_trials([file], mapping("mat", "variable = 'trials(3).t'", "variable = 'trials(3).yaw'"))
    np.testing.assert_array_equal(single[0].yaw, read[2].yaw)
    assert "array of 4 structures; choose one" in refusal(file, mapping("mat", "variable = 'trials.t'"))


@pytest.mark.parametrize("write", [write_matlab5, write_matlab73])
def test_an_element_of_a_cell_is_chosen_as_in_matlab(tmp_path, mapping, write):
    cell = (np.empty(2, dtype=object), (TIME, wrapped(YAW)))
    cell[0][:] = [TIME, wrapped(YAW)]
    file = write(tmp_path / "a.mat", {"c": cell[0] if write is write_matlab5 else cell[1]})
    assert_read(read_trials([file], mapping("mat", "variable = 'c{1}'", "variable = 'c{2}'"))[0])
    assert "has no element 3" in refusal(file, mapping("mat", "variable = 'c{1}'", "variable = 'c{3}'"))
    assert "choose an element, as in c{1}" in refusal(file, mapping("mat", "variable = 'c'", "variable = 'c{2}'"))


def test_groups_of_an_hdf5_file_are_trials_and_a_slash_leads_to_the_root(tmp_path, mapping):
    groups = {f"trial_{k}": {"yaw": YAW - 10 * k, "onset": 20.0 + k} for k in range(3)}
    file = write_hdf5(tmp_path / "a.h5", groups | {"t": TIME}, {"fly": "fly 7"})
    extra = """
[trial]
groups = "trial_*"
fly = { attribute = "fly" }
[perturbation]
onset = { variable = "onset", unit = "ms" }
duration = "5 ms"
"""
    read = read_trials([file], mapping("hdf5", "variable = '/t'", extra=extra))
    assert [trial.name for trial in read] == ["a:trial_0", "a:trial_1", "a:trial_2"]
    assert {trial.fly for trial in read} == {"fly 7"}
    np.testing.assert_allclose([trial.perturbation.onset for trial in read], [0.020, 0.021, 0.022], rtol=1e-15)
    assert "has no group or structure 'trail_*'" in refusal(
        file, mapping("hdf5", extra="[trial]\ngroups = 'trail_*'\n")
    )


def test_packed_numbers_of_netcdf_are_unpacked(tmp_path, mapping):
    with h5py.File(tmp_path / "a.nc", "w") as file:
        file["t"] = TIME
        packed = file.create_dataset("yaw", data=np.rint((YAW - 170) / 0.01).astype(np.int16))
        packed.attrs.update({"scale_factor": 0.01, "add_offset": 170.0, "_FillValue": np.int16(-32768)})
        packed[7] = -32768
    trial = read_trials([tmp_path / "a.nc"], mapping("netcdf"))[0]
    assert np.flatnonzero(np.isnan(trial.yaw)).tolist() == [7]
    np.testing.assert_allclose(np.delete(np.degrees(trial.yaw), 7), np.delete(YAW, 7), atol=0.00501)  # half a step


@pytest.mark.parametrize(("write", "form"), [(write_hdf5, "hdf5"), (write_netcdf3, "netcdf")])
def test_a_rate_and_an_onset_may_be_attributes(tmp_path, mapping, write, form):
    attributes = {"fs": RATE, "onset_ms": 20.0}
    if write is write_hdf5:
        file = write(tmp_path / "a", {"yaw": YAW - 170}, attributes)
    else:
        file = write(tmp_path / "a", {"yaw": YAW - 170}, **attributes)
    extra = "[perturbation]\nonset = { attribute = 'onset_ms', unit = 'ms' }\nduration = '5 ms'\n"
    text = mapping_text(form, extra=extra).replace(
        "time = { variable = 't', unit = 's' }", "rate = { attribute = 'fs', unit = 'Hz' }\nstart = '-10 ms'"
    )
    (tmp_path / "rate.toml").write_text(text)
    trial = read_trials([file], tmp_path / "rate.toml")[0]
    np.testing.assert_allclose(trial.time, TIME - 0.010, rtol=1e-12, atol=1e-17)
    assert trial.perturbation.onset == pytest.approx(0.020, rel=1e-15)


def test_a_trace_may_have_a_clock_of_its_own(tmp_path, mapping):
    coil = {"t": np.linspace(0, 0.06, 37), "I": np.r_[np.zeros(10), 40 * np.ones(7), np.zeros(20)]}
    file = write_matlab5(tmp_path / "a.mat", VARIABLES | {"coil": coil})
    extra = """
[perturbation]
trace = { variable = "coil.I", unit = "mA" }
time = { variable = "coil.t", unit = "s" }
torque_per_unit = "2e-13 N m"
inertia = "4e-13 kg m^2"
"""
    trace = read_trials([file], mapping("mat", extra=extra))[0].perturbation
    assert trace.unit == "A"
    np.testing.assert_allclose(trace.drive.max(), 0.040, rtol=1e-15)
    np.testing.assert_allclose(trace.time, coil["t"], rtol=1e-15)
    # 40 mA make 40 * 2e-13 N m, divided by I
    assert trace.angular_acceleration_per_unit * trace.drive.max() == pytest.approx(40 * 2e-13 / 4e-13, rel=1e-14)


def test_the_columns_of_parquet_may_name_trials_and_flies(tmp_path, mapping):
    table = {
        "t": np.tile(TIME, 2),
        "yaw": np.r_[YAW, YAW - 20],
        "trial": ["b"] * 120 + ["a"] * 120,
        "fly": [3] * 240,
        "onset": [20.0] * 120 + [30.0] * 120,
    }
    extra = """
[trial]
column = "trial"
fly = { column = "fly" }
[perturbation]
onset = { column = "onset", unit = "ms" }
duration = "5 ms"
"""
    read = read_trials(
        [write_parquet(tmp_path / "a.parquet", table)], mapping("parquet", "column = 't'", "column = 'yaw'", extra)
    )
    assert [trial.name for trial in read] == ["a:b", "a:a"]
    assert [trial.fly for trial in read] == ["3", "3"]
    np.testing.assert_allclose([trial.perturbation.onset for trial in read], [0.020, 0.030], rtol=1e-15)
    np.testing.assert_allclose(np.degrees(read[1].yaw), YAW - 20, rtol=1e-13)


def test_nulls_of_parquet_are_missing(tmp_path, mapping):
    yaw = [None if k == 5 else float(value) for k, value in enumerate(YAW)]
    file = write_parquet(tmp_path / "a.parquet", {"t": TIME, "yaw": yaw})
    trial = read_trials([file], mapping("parquet", "column = 't'", "column = 'yaw'"))[0]
    assert np.flatnonzero(np.isnan(trial.yaw)).tolist() == [5]


# What is refused


@pytest.mark.parametrize(
    ("write", "form", "said"),
    [
        (write_hdf5, "csv", "is an HDF5 file by its first bytes, no text; say format = 'hdf5'"),
        (write_hdf5, "mat", "is an HDF5 file by its first bytes, but the mapping says format = 'mat'"),
        (write_matlab5, "hdf5", "is a MATLAB file by its first bytes, but the mapping says format = 'hdf5'"),
        (write_matlab73, "netcdf", "is a MATLAB 7.3 file by its first bytes"),
        (write_netcdf3, "hdf5", "is a netCDF file by its first bytes"),
        (write_parquet, "netcdf", "is a Parquet file by its first bytes"),
    ],
)
def test_a_format_that_the_file_contradicts_is_refused(tmp_path, mapping, write, form, said):
    layout = {"channels": "channels = 'columns'"} if form == "csv" else {}
    place = ("column = 't'", "column = 'yaw'") if form == "csv" else ()
    assert said in refusal(write(tmp_path / "a", VARIABLES), mapping(form, *place, **layout))


def test_what_no_reader_knows_is_refused_with_its_first_bytes(tmp_path, mapping):
    for name, data, said in (
        ("a.mat", b"hello, hello", "is not a MATLAB file: it begins with b'hello, h'"),
        ("b.mat", b"", "b.mat is empty"),
        ("c.mat", b"PK\x03\x04....", "is a zip archive or a spreadsheet"),
        ("d.mat", b"\x1f\x8b....", "is compressed by gzip"),
    ):
        (tmp_path / name).write_bytes(data)
        assert said in refusal(tmp_path / name, mapping("mat"))
    assert "there is no such file" in refusal(tmp_path / "absent.mat", mapping("mat"))
    assert "is a folder" in refusal(tmp_path, mapping("mat"))


@pytest.mark.parametrize("write", [write_matlab5, write_matlab73, write_hdf5])
@pytest.mark.parametrize(
    ("yaw", "said"),
    [
        ("variable = 'jaw'", "the variable 'jaw' of yaw is not there; the nearest is 'yaw' ("),
        ("variable = 'cube'", "has the shape 2 x 3 x 4; choose one of its rows or columns"),
        ("variable = 'cube'\nrow = 0", "has the shape 2 x 3 x 4, without rows and columns"),
        ("variable = 'table'\ncolumn = 2", "has the shape 120 x 2, so column 2 (from 0) is beyond it"),
        ("variable = 'word'", "is the text 'hello'; numbers are needed"),
        ("variable = 'complex'", "is complex; real numbers are needed"),
        ("variable = 'short'", "yaw has 119 samples where clock.time has 120; channels of one trial need as many"),
        ("variable = 'still'", "yaw is 3 deg throughout; a fly in flight is never still"),
        ("variable = 'endless'", 'is not a usable number ("inf"); mark what is missing'),
        ("variable = 'nothing'", "yaw has fewer than two samples that are numbers"),
    ],
)
def test_a_variable_that_does_not_fit_is_refused(tmp_path, mapping, write, yaw, said):
    variables = VARIABLES | {
        "cube": np.zeros((2, 3, 4)),
        "table": np.zeros((120, 2)),
        "word": "hello",
        "short": YAW[1:],
        "still": 0 * YAW + 3,
        "endless": np.where(TIME > 0.02, np.inf, YAW),
        "nothing": YAW * np.nan,
    }
    if write is write_matlab73:
        pair = np.zeros((1, 120), dtype=[("real", float), ("imag", float)])
        file = write(tmp_path / "a", variables)
        with h5py.File(file, "r+") as opened:
            opened["complex"] = pair
    else:
        file = write(tmp_path / "a", variables | {"complex": YAW * 1j})
    sentence = refusal(file, mapping("hdf5" if write is write_hdf5 else "mat", yaw=yaw))
    assert said in sentence
    assert "a" in sentence


def test_a_unit_that_the_file_contradicts_is_refused(tmp_path, mapping):
    file = write_netcdf3(tmp_path / "a.nc", VARIABLES, units={"yaw": "radians", "t": "seconds"})
    assert "a.nc says that yaw is in 'radians', but the mapping says 'deg'" in refusal(file, mapping("netcdf"))
    agreeing = write_netcdf3(tmp_path / "b.nc", VARIABLES, units={"yaw": "degrees", "t": "s"})
    assert_read(read_trials([agreeing], mapping("netcdf"))[0])


def test_bad_indices_of_a_sparse_matrix_are_refused(tmp_path, mapping):
    file = write_matlab73(tmp_path / "a.mat", {"t": TIME, "yaw": csc_array(YAW[:, None])})
    with h5py.File(file, "r+") as opened:
        opened["yaw/ir"][3] = 1_000_000
    assert "cannot be read as mat" in refusal(file, mapping("mat"))


def test_a_declared_size_beyond_all_recordings_is_refused_before_it_is_read(tmp_path, mapping):
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file["t"] = TIME
        file.create_dataset("yaw", shape=(10**12,), chunks=(1000,), dtype=float)
    assert "has 1e+12 numbers by its shape" in refusal(tmp_path / "a.h5", mapping("hdf5"))


def test_a_matlab_object_is_refused(tmp_path, mapping):
    scipy.io.savemat(tmp_path / "a.mat", {"t": TIME, "yaw": np.array([1, "a", YAW], dtype=object)})
    assert "is a cell array; choose an element" in refusal(tmp_path / "a.mat", mapping("mat"))


def test_without_pyarrow_the_sentence_says_how_to_get_it(tmp_path, mapping, monkeypatch):
    file = write_parquet(tmp_path / "a.parquet", VARIABLES)
    (tmp_path / "hidden").mkdir()
    (tmp_path / "hidden" / "pyarrow.py").write_text("raise ImportError")
    monkeypatch.setattr(sys, "path", [str(tmp_path / "hidden"), *sys.path])
    shared_reader().close()  # so that it starts anew, with this path
    sentence = refusal(file, mapping("parquet", "column = 't'", "column = 'yaw'"))
    shared_reader().close()
    assert "needs pyarrow, which is not installed; install it by: pip install 'flycontrol[parquet]'" in sentence
