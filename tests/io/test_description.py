import math
import tomllib

import numpy as np
import pytest
from binary_files import write_hdf5, write_matlab5, write_matlab73, write_parquet

from flycontrol.errors import InvalidInputError
from flycontrol.io.description import describe_columns, fitting_mappings, suggest_mapping
from flycontrol.io.recordings import read_recording


def test_rows_of_a_wide_table_are_its_channels(flight, written):
    summary = describe_columns(written(flight))
    assert (summary.format, summary.orientation, len(summary.channels)) == ("whitespace", "rows", 21)
    stroke = summary.channels[15]
    assert (stroke.count, float(stroke.first)) == (300, flight[15, 0])
    assert (stroke.smallest, stroke.largest) == (flight[15].min(), flight[15].max())
    assert [channel.index for channel in summary.channels if channel.counts_up] == [0]


@pytest.mark.parametrize(("form", "separator"), [("csv", ","), ("tsv", "\t"), ("whitespace", "  ")])
def test_the_format_of_a_long_table_is_recognised(flight, written, form, separator):
    summary = describe_columns(written(flight.T, separator=separator))
    assert (summary.format, summary.orientation, len(summary.channels)) == (form, "columns", 21)


def test_names_and_what_is_no_number_are_found(written):
    lines = ["t,psi,note", *(f"{k / 5000},{k if k % 2 else 'nan'},trial" for k in range(10))]
    summary = describe_columns(written(lines, "trial.csv"))
    assert [channel.name for channel in summary.channels] == ["t", "psi", "note"]
    assert [channel.not_numbers for channel in summary.channels] == [0, 5, 10]
    assert [channel.increases_evenly for channel in summary.channels] == [True, False, False]
    assert math.isnan(summary.channels[2].smallest)


def test_a_file_that_a_shipped_mapping_fits_is_recognised(flight, written):
    assert fitting_mappings(written(flight)) == ("muijres_freeflight",)
    assert fitting_mappings(written(flight[:20])) == ()
    flight[8:12] *= 2
    assert fitting_mappings(written(flight)) == ()


def test_the_suggested_mapping_works_once_it_is_filled_in(flight, written, tmp_path):
    path = written(flight)
    text = suggest_mapping(path)
    assert "row 15: 300 samples" in text
    filled = text.replace("??? 1/s", "7500 1/s").replace("# [yaw] ", "[yaw] ").replace("# row = ???", "row = 17", 1)
    filled = filled.replace('# unit = "deg"', 'unit = "deg"', 1)
    (tmp_path / "map.toml").write_text(filled)
    recording = read_recording(path, tmp_path / "map.toml")
    np.testing.assert_allclose(recording.yaw, np.radians(flight[17]), rtol=1e-14, atol=1e-16)


def test_a_suggested_mapping_that_nobody_edited_is_refused(flight, written, tmp_path):
    path = written(flight)
    (tmp_path / "map.toml").write_text(suggest_mapping(path))
    with pytest.raises(InvalidInputError, match=r"map\.toml, line \d+: clock\.rate is '\?\?\? 1/s'"):
        read_recording(path, tmp_path / "map.toml")


def test_strange_names_leave_the_suggestion_valid_toml(written):
    header = 'a"b,\x1b[31m,\u2028,' + "x" * 300
    path = written([header, *("1,2,3,4" for _ in range(9))], 'we"ird\x1b.csv')
    assert tomllib.loads(suggest_mapping(path))["file"]["count"] == 4


@pytest.mark.parametrize("text", ["", "a b c\n", "1 2\n3\n"])
def test_what_is_no_table_is_refused(written, text):
    with pytest.raises(InvalidInputError, match=r"flight\.txt"):
        describe_columns(written([text]))


@pytest.mark.parametrize(("form", "write"), [("mat", write_matlab73), ("mat", write_matlab5), ("hdf5", write_hdf5)])
def test_a_binary_file_is_described_by_its_variables(tmp_path, form, write):
    time = np.arange(50) / 1000
    variables = {"trial": {"t": time, "psi": 20 * np.sin(90 * time), "note": "windy"}, "table": np.ones((50, 3))}
    path = write(tmp_path / "run", variables)
    summary = describe_columns(path)
    assert (summary.format, summary.orientation) == (form, "variables")
    between = "." if form == "mat" else "/"
    times = next(channel for channel in summary.channels if channel.name == f"trial{between}t")
    assert (times.count, times.increases_evenly) == (50, True)
    text = suggest_mapping(path)
    assert f"#   variable 'trial{between}note' is the text 'windy'; numbers are needed" in text
    assert "#   variable 'table': 150 samples, 50 x 3, first 1, from 1 to 1" in text
    filled = text.replace('unit = "???"', 'unit = "s"').replace("# [yaw] ", "[yaw] ")
    filled = filled.replace("# variable = ???", f'variable = "trial{between}psi"', 1).replace(
        '# unit = "deg"', 'unit = "deg"', 1
    )
    (tmp_path / "map.toml").write_text(filled)
    recording = read_recording(path, tmp_path / "map.toml")
    np.testing.assert_allclose(np.degrees(recording.yaw), variables["trial"]["psi"], rtol=1e-14)


def test_a_parquet_file_is_described_by_its_columns(tmp_path):
    path = write_parquet(tmp_path / "run", {"t": np.arange(50) / 1000, "fly": ["a"] * 50})
    summary = describe_columns(path)
    assert (summary.format, summary.orientation) == ("parquet", "columns")
    text = suggest_mapping(path)
    assert tomllib.loads(text)["clock"]["time"]["column"] == 0
    assert "column 1 'fly': 0 samples" in text
