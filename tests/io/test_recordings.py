from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from flycontrol.errors import InvalidInputError
from flycontrol.io.mapping import known_mapping, mapping_text, read_mapping
from flycontrol.io.recordings import read_recording

MUIJRES = "muijres_freeflight"
FLIGHTS = ("20121009_S0003", "20121120_S0001", "20121128_S0003")
TAKE_OFFS = ("exp035c", "exp098c", "exp099c", "exp100c")


def refusal(path, mapping=MUIJRES):
    with pytest.raises(InvalidInputError) as error:
        read_recording(path, mapping)
    sentence = str(error.value)
    assert "\n" not in sentence
    assert sentence.endswith((".", "?"))
    return sentence


@pytest.fixture
def edited_mapping(tmp_path):
    """The shipped mapping of 21 rows with some text replaced."""

    def edit(*replacements):
        text = mapping_text(MUIJRES)
        for old, new in replacements:
            assert old in text
            text = text.replace(old, new, 1)
        path = tmp_path / "map.toml"
        path.write_text(text)
        return path

    return edit


def test_numbers_become_si_units_in_the_package_s_conventions(flight, written):
    recording = read_recording(written(flight), MUIJRES)
    exactly = {"rtol": 1e-15, "atol": 1e-15}
    np.testing.assert_allclose(recording.time, flight[0] / 7500, **exactly)
    np.testing.assert_allclose(recording.position_W, flight[2:5].T * 1e-3, **exactly)
    np.testing.assert_allclose(recording.velocity_S, flight[5:8].T * 1e-3, **exactly)
    np.testing.assert_allclose(recording.angular_velocity_S, flight[12:15].T, **exactly)
    np.testing.assert_allclose(recording.left.stroke, -np.radians(flight[15]), **exactly)
    np.testing.assert_allclose(recording.right.deviation, np.radians(flight[18]), **exactly)
    np.testing.assert_allclose(recording.right.pitch, np.pi / 2 - np.radians(flight[20]), **exactly)
    assert recording.stroke_plane_angle == pytest.approx(np.radians(55), rel=1e-15)
    assert recording.yaw is None


def test_the_quaternion_is_body_to_world_scalar_first(flight, written):
    recording = read_recording(written(flight), MUIJRES)
    same = np.abs(np.sum(recording.q_WB * flight[[11, 8, 9, 10]].T, axis=1))  # |cos of half the angle between them|
    np.testing.assert_allclose(same, 1, atol=1e-14)


def test_arrays_of_a_recording_are_read_only(flight, written):
    recording = read_recording(written(flight), MUIJRES)
    with pytest.raises(ValueError, match="read-only"):
        recording.time[0] = 0


def test_the_hash_is_that_of_the_file_s_bytes(flight, written):
    import hashlib

    path = written(flight)
    assert read_recording(path, MUIJRES).source_sha256 == hashlib.sha256(path.read_bytes()).hexdigest()


def as_columns(path):
    text = (
        mapping_text(MUIJRES).replace('"rows"', '"columns"').replace("rows =", "columns =").replace("row =", "column =")
    )
    path.write_text(text.replace("count = 21", ""))
    return path


@pytest.mark.parametrize(("form", "separator"), [("whitespace", "  "), ("csv", ","), ("tsv", "\t")])
def test_rows_and_columns_of_every_format_hold_the_same_recording(flight, written, tmp_path, form, separator):
    mapping = as_columns(tmp_path / "map.toml")
    mapping.write_text(mapping.read_text().replace('format = "whitespace"', f'format = "{form}"'))
    by_columns = read_recording(written(flight.T, "columns.txt", separator), mapping)
    by_rows = read_recording(written(flight), MUIJRES)
    for name in ("time", "position_W", "velocity_S", "angular_velocity_S", "q_WB"):
        np.testing.assert_array_equal(getattr(by_columns, name), getattr(by_rows, name))


def test_named_columns_are_found_by_their_names(flight, written, tmp_path):
    mapping = as_columns(tmp_path / "map.toml")
    named = mapping.read_text().replace("column = 15", 'column = "stroke left"').replace('"whitespace"', '"csv"')
    mapping.write_text(named)
    header = ",".join("stroke left" if i == 15 else f"channel {i}" for i in range(21))
    lines = [header, *(",".join(map(repr, map(float, sample))) for sample in flight.T)]
    recording = read_recording(written(lines, "named.csv"), mapping)
    np.testing.assert_allclose(recording.left.stroke, -np.radians(flight[15]), rtol=1e-15)


def test_named_rows_are_found_by_their_names(flight, written, edited_mapping):
    lines = [f"row{i} " + " ".join(map(repr, map(float, channel))) for i, channel in enumerate(flight)]
    recording = read_recording(written(lines), edited_mapping(("row = 15", 'row = "row15"')))
    np.testing.assert_allclose(recording.left.stroke, -np.radians(flight[15]), rtol=1e-15)


def test_comments_and_empty_lines_are_skipped(flight, written):
    lines = ["# a comment", "", *(" ".join(map(repr, map(float, channel))) for channel in flight)]
    np.testing.assert_allclose(read_recording(written(lines), MUIJRES).time, flight[0] / 7500, rtol=1e-15)


def test_an_attitude_given_as_world_to_body_is_inverted(flight, written, edited_mapping):
    upright = read_recording(written(flight), MUIJRES)
    flight[8:11] *= -1
    inverted = read_recording(written(flight), edited_mapping(('"body to world"', '"world to body"')))
    np.testing.assert_allclose(inverted.q_WB, upright.q_WB, atol=1e-15)


def test_a_velocity_in_the_body_or_world_frame_gives_the_same_recording(flight, written, edited_mapping):
    recording = read_recording(written(flight), MUIJRES)
    body_from_stroke_plane = Rotation.from_euler("y", -55, degrees=True)
    flight[5:8] = body_from_stroke_plane.apply(flight[5:8].T).T
    velocity_in = 'unit = "mm/s"\nframe = "stroke plane"'
    in_body = read_recording(written(flight), edited_mapping((velocity_in, 'unit = "mm/s"\nframe = "body"')))
    np.testing.assert_allclose(in_body.velocity_S, recording.velocity_S, atol=1e-15)
    flight[5:8] = Rotation.from_quat(flight[8:12].T).apply(flight[5:8].T).T
    in_world = read_recording(written(flight), edited_mapping((velocity_in, 'unit = "mm/s"\nframe = "world"')))
    np.testing.assert_allclose(in_world.velocity_S, recording.velocity_S, atol=1e-15)


def test_body_axes_that_point_left_and_up_are_turned(flight, written, edited_mapping):
    recording = read_recording(written(flight), MUIJRES)
    half_turn = Rotation.from_euler("x", np.pi)
    flight[5:8] = half_turn.apply(flight[5:8].T).T
    flight[8:12] = (Rotation.from_quat(flight[8:12].T) * half_turn).as_quat().T
    flight[12:15] = half_turn.apply(flight[12:15].T).T
    turned = read_recording(written(flight), edited_mapping(("forward right down", "forward left up")))
    for name in ("velocity_S", "angular_velocity_S"):
        np.testing.assert_allclose(getattr(turned, name), getattr(recording, name), atol=1e-14)
    np.testing.assert_allclose(np.abs(np.sum(turned.q_WB * recording.q_WB, axis=1)), 1, atol=1e-14)


def test_a_world_whose_z_points_down_is_turned(flight, written, edited_mapping):
    recording = read_recording(written(flight), MUIJRES)
    half_turn = Rotation.from_euler("x", np.pi)
    flight[2:5] = half_turn.apply(flight[2:5].T).T
    flight[8:12] = (half_turn * Rotation.from_quat(flight[8:12].T)).as_quat().T
    turned = read_recording(written(flight), edited_mapping(('world_z = "up"', 'world_z = "down"')))
    np.testing.assert_allclose(turned.position_W, recording.position_W, atol=1e-15)
    np.testing.assert_allclose(np.abs(np.sum(turned.q_WB * recording.q_WB, axis=1)), 1, atol=1e-14)


def test_a_heading_that_jumps_by_a_turn_is_made_continuous(written, tmp_path):
    heading = np.linspace(170, 260, 300)  # deg
    mapping = tmp_path / "map.toml"
    mapping.write_text(YAW_BY_TIME)
    wrapped = (heading + 180) % 360 - 180
    recording = read_recording(written(np.column_stack([np.arange(300) / 5000, wrapped])), mapping)
    np.testing.assert_allclose(np.degrees(recording.yaw), heading, rtol=1e-14)
    assert recording.rate == pytest.approx(5000, rel=1e-12)


YAW_BY_TIME = """
name = "heading"
[file]
format = "whitespace"
channels = "columns"
[clock]
time = { column = 0, unit = "s" }
[yaw]
column = 1
unit = "deg"
"""


# What is refused


def test_a_missing_file_a_folder_and_an_empty_file_are_refused(tmp_path):
    (tmp_path / "empty.txt").write_text("\n \n")
    (tmp_path / "comments.txt").write_text("# nothing\n")
    assert "there is no such file" in refusal(tmp_path / "absent.txt")
    assert "is a folder" in refusal(tmp_path)
    assert "is empty" in refusal(tmp_path / "empty.txt")
    assert "holds only comments" in refusal(tmp_path / "comments.txt")


def test_a_device_is_refused():
    assert "/dev/zero is not a regular file" in refusal(Path("/dev/zero"))


def test_a_binary_file_is_refused(tmp_path):
    (tmp_path / "a.mat").write_bytes(b"MATLAB 5.0 MAT-file\x00\x01\x02")
    assert "a.mat is a MATLAB file by its first bytes, no text; say format = 'mat'" in refusal(tmp_path / "a.mat")
    (tmp_path / "c.txt").write_bytes(b"1 2 3\x00\x01\x02")
    assert "is not a text file: byte 5 is zero" in refusal(tmp_path / "c.txt")
    (tmp_path / "b.txt").write_bytes(b"1 2\n3 \xb5\n")
    assert "b.txt, line 2: byte 0xb5 is not UTF-8" in refusal(tmp_path / "b.txt")


def test_ragged_rows_are_refused_with_the_line(flight, written):
    lines = [" ".join(map(str, channel)) for channel in flight]
    lines[7] += " 1.0"
    assert "flight.txt, line 8: 301 fields where line 1 has 300" in refusal(written(lines))


@pytest.mark.parametrize("text", ["nan", "inf", "-Infinity", "1e300", "n/a", "1,5", "--"])
def test_what_is_no_number_is_refused_with_line_field_and_text(flight, written, text):
    lines = [" ".join(map(str, channel)) for channel in flight]
    fields = lines[14].split()
    fields[213] = text
    lines[14] = " ".join(fields)
    said = refusal(written(lines))
    assert f'flight.txt, line 15, field 214: angular_velocity.z is not a usable number ("{text}")' in said


def test_an_empty_field_of_a_csv_is_refused(written, tmp_path):
    mapping = tmp_path / "map.toml"
    mapping.write_text(YAW_BY_TIME.replace("whitespace", "csv"))
    lines = ["t,yaw", *(f"{k / 5000},{k}" for k in range(300))]
    lines[5] = f"{4 / 5000},"
    assert 'line 6, field 2: yaw is not a usable number ("")' in refusal(written(lines), mapping)


def test_text_in_a_column_that_is_not_mapped_does_no_harm(written, tmp_path):
    mapping = tmp_path / "map.toml"
    mapping.write_text(YAW_BY_TIME.replace("whitespace", "csv"))
    lines = ["t,yaw,comment", *(f"{k / 5000},{k / 10},trial {k}" for k in range(300))]
    assert len(read_recording(written(lines), mapping).yaw) == 300


def test_another_number_of_rows_than_the_mapping_expects_is_refused(flight, written):
    assert "has 20 rows where the mapping muijres_freeflight expects 21" in refusal(written(flight[:20]))


def test_a_row_that_does_not_exist_is_refused(flight, written, edited_mapping):
    mapping = edited_mapping(("count = 21", ""), ("row = 15", "row = 25"))
    said = refusal(written(flight), mapping)
    assert "flight.txt has 21 rows (0 to 20), but" in said
    assert "map.toml, line 48 maps left.stroke to row 25" in said


@pytest.mark.parametrize(
    ("header", "said"),
    [
        ("t,jaw", "has no column named 'yaw'; the nearest is 'jaw'"),
        ("yaw,yaw", "has 2 columns named 'yaw'; give the column's number instead"),
        ("0,1", "names no columns; give the column's number, counted from 0, instead of 'yaw'"),
        ("time,x", "has no column named 'yaw'; there are time, x"),
    ],
)
def test_a_name_that_is_not_there_is_refused(written, tmp_path, header, said):
    mapping = tmp_path / "map.toml"
    mapping.write_text(YAW_BY_TIME.replace("whitespace", "csv").replace("column = 1", 'column = "yaw"'))
    lines = [header, *(f"{k / 5000},{k / 10}" for k in range(1, 300))]
    assert said in refusal(written(lines), mapping)


@pytest.mark.parametrize(
    ("frames", "said"),
    [
        ({7: 1006}, "field 8: clock.frame holds frame 1006 twice; frames must count up by one"),
        ({7: 1008}, "field 8: clock.frame jumps from 1006 to 1008"),
        ({7: 1003}, "field 8: clock.frame jumps from 1006 to 1003"),
        ({7: 1006.5}, "field 8: clock.frame jumps from 1006 to 1006.5"),
    ],
)
def test_frames_that_do_not_count_up_are_refused(flight, written, frames, said):
    for sample, frame in frames.items():
        flight[0, sample] = frame
    assert said in refusal(written(flight))


@pytest.mark.parametrize(
    ("times", "said"),
    [
        ({4: 3 / 5000}, "line 5, field 1: clock.time repeats (0.0006 to 0.0006); times must increase"),
        ({4: 2 / 5000}, "line 5, field 1: clock.time goes back (0.0006 to 0.0004)"),
        ({4: 4.1 / 5000}, "line 5, field 1: clock.time is uneven: a step of 0.00022 s where 0.0002 s is usual"),
    ],
)
def test_times_that_do_not_increase_evenly_are_refused(written, tmp_path, times, said):
    mapping = tmp_path / "map.toml"
    mapping.write_text(YAW_BY_TIME)
    table = np.column_stack([np.arange(300) / 5000, np.linspace(0, 20, 300)])
    for sample, time in times.items():
        table[sample, 0] = time
    assert said in refusal(written(table), mapping)


def test_a_rate_that_no_camera_has_is_refused(flight, written, edited_mapping, tmp_path):
    assert "75 samples a second" in refusal(written(flight), edited_mapping(("7500 1/s", "75 1/s")))
    mapping = tmp_path / "map.toml"
    mapping.write_text(YAW_BY_TIME)  # times in ms, called s
    table = np.column_stack([np.arange(300) / 5, np.linspace(0, 20, 300)])
    assert "5 samples a second, outside the plausible 100 to 1e+06" in refusal(written(table), mapping)


def test_degrees_a_second_called_radians_are_refused(flight, written):
    flight[14] = np.degrees(40)
    said = refusal(written(flight))
    assert "flight.txt, line 15, field 1: angular_velocity.z reaches 2292 rad/s" in said
    assert "no fly turns so fast; are the numbers deg/s?" in said


def test_slow_degrees_a_second_called_radians_are_refused_by_the_attitude(flight, written):
    still = flight[12:15] * 0.4
    flight[8:12] = (
        (
            Rotation.from_quat(flight[8:12, 0])
            * Rotation.from_rotvec(
                np.outer(np.arange(300) / 7500, Rotation.from_euler("y", -55, degrees=True).apply(still[:, 0]))
            )
        )
        .as_quat()
        .T
    )
    flight[12:15] = still
    read_recording(written(flight), MUIJRES)
    flight[12:15] = np.degrees(still)
    assert "the angular velocity is 201 rad/s (root mean square) where the attitude changes at 3.51" in refusal(
        written(flight)
    )


def test_a_wrong_unit_of_velocity_is_refused(flight, written, edited_mapping):
    assert "no fly is so fast; are the numbers mm/s?" in refusal(
        written(flight), edited_mapping(('unit = "mm/s"', 'unit = "m/s"'))
    )
    assert "the velocity is 0.000208 m/s (root mean square) where the position changes at 0.208" in refusal(
        written(flight), edited_mapping(('unit = "mm/s"', 'unit = "um/s"'))
    )


def test_a_wrong_unit_of_position_is_refused(flight, written, edited_mapping):
    assert "position.x changes by 200 m/s; are the numbers mm?" in refusal(
        written(flight), edited_mapping(('unit = "mm"', 'unit = "m"'))
    )


def test_wing_angles_in_degrees_called_radians_are_refused(flight, written, edited_mapping):
    mapping = edited_mapping(('row = 15, unit = "deg"', 'row = 15, unit = "rad"'))
    assert "left.stroke reaches" in refusal(written(flight), mapping)


def test_a_stroke_in_radians_called_degrees_is_refused(flight, written):
    flight[16] = np.radians(flight[16])
    assert "right.stroke moves by 2.42 deg in all, less than any wingbeat" in refusal(written(flight))


def test_a_heading_in_degrees_called_radians_is_refused(written, tmp_path):
    mapping = tmp_path / "map.toml"
    mapping.write_text(YAW_BY_TIME.replace('"deg"', '"rad"'))
    table = np.column_stack([np.arange(300) / 5000, np.linspace(0, 120, 300)])
    assert "that is more than four turns; are the numbers degrees?" in refusal(written(table), mapping)


def test_a_quaternion_that_is_not_unit_is_refused(flight, written):
    flight[8:12, 42] *= 1.01
    assert "field 43: quaternion.w is part of a quaternion of norm 1.01" in refusal(written(flight))


def test_quaternions_rounded_to_four_digits_are_read(flight, written):
    flight[8:12] = np.round(flight[8:12], 4)
    recording = read_recording(written(flight), MUIJRES)
    np.testing.assert_allclose(np.linalg.norm(recording.q_WB, axis=1), 1, rtol=1e-15)


def test_less_than_three_wingbeats_are_refused(flight, written):
    read_recording(written(flight[:, :120]), MUIJRES)  # 3.2 wingbeats
    said = refusal(written(flight[:, :100]))
    assert "flight lasts 13.3 ms, that is 2." in said
    assert "at least 3 are needed" in said


def test_without_wings_less_than_thirty_milliseconds_are_refused(written, tmp_path):
    mapping = tmp_path / "map.toml"
    mapping.write_text(YAW_BY_TIME)
    table = np.column_stack([np.arange(149) / 5000, np.linspace(0, 20, 149)])
    assert "lasts 29.8 ms, that is 3 wingbeats at 100 Hz (no wing is mapped" in refusal(written(table), mapping)


def test_a_csv_whose_quotes_hide_line_ends_is_refused(written, tmp_path):
    mapping = tmp_path / "map.toml"
    mapping.write_text(YAW_BY_TIME.replace("whitespace", "csv"))
    assert "a quoted field runs over several lines" in refusal(written(['0,"1', '1",2', "2,3"]), mapping)
    assert "is not a readable table" in refusal(written(["0," + "1" * 200_000]), mapping)


@pytest.mark.parametrize("samples", [0, 1])
def test_a_recording_without_motion_in_time_is_refused(written, tmp_path, samples):
    mapping = tmp_path / "map.toml"
    mapping.write_text(YAW_BY_TIME)
    said = refusal(written(["t yaw", *["0.1 0.2"] * samples]), mapping)
    assert "holds no numbers" in said if samples == 0 else "holds 1 sample of each channel" in said


@given(st.text(alphabet=st.characters(codec="utf-8"), max_size=80), st.sampled_from(["whitespace", "csv", "tsv"]))
def test_no_text_crashes_the_reader(tmp_path_factory, text, form):
    folder = tmp_path_factory.getbasetemp()
    (folder / "any.txt").write_text(text, encoding="utf-8")
    (folder / "any.toml").write_text(YAW_BY_TIME.replace("whitespace", form))
    with pytest.raises(InvalidInputError, match=r"any"):
        read_recording(folder / "any.txt", folder / "any.toml")


@given(st.lists(st.lists(st.sampled_from(["1", "2", "-1e308", "1e308", "nan", "x", ""]), min_size=2, max_size=2)))
def test_no_table_crashes_the_reader(tmp_path_factory, rows):
    folder = tmp_path_factory.getbasetemp()
    (folder / "any.txt").write_text("\n".join(",".join(row) for row in rows))
    (folder / "any.toml").write_text(YAW_BY_TIME.replace("whitespace", "csv"))
    with pytest.raises(InvalidInputError, match=r"any"):
        read_recording(folder / "any.txt", folder / "any.toml")


# What real recordings say of the shipped mappings


def turned_by(recording, vector_S):
    """Vectors of the stroke-plane frame in world axes."""
    to_body = Rotation.from_euler("y", -recording.stroke_plane_angle)
    return Rotation.from_quat(recording.q_WB, scalar_first=True).apply(to_body.apply(vector_S.copy()))


@pytest.mark.parametrize("name", FLIGHTS)
def test_velocities_of_the_real_flights_are_the_rates_of_their_positions(real_data, name):
    recording = read_recording(real_data / MUIJRES / f"{name}.txt", MUIJRES)
    moved = np.gradient(recording.position_W, recording.time, axis=0)
    rms = np.sqrt(np.mean((turned_by(recording, recording.velocity_S) - moved) ** 2))
    assert rms < 2e-5  # m/s, 1e-4 of the speed: what differences of smoothed positions leave


@pytest.mark.parametrize("name", FLIGHTS)
def test_angular_velocities_of_the_real_flights_are_the_rates_of_their_attitudes(real_data, name):
    recording = read_recording(real_data / MUIJRES / f"{name}.txt", MUIJRES)
    attitude = Rotation.from_quat(recording.q_WB, scalar_first=True)
    turned = (attitude[2:] * attitude[:-2].inv()).as_rotvec() * recording.rate / 2
    given = turned_by(recording, recording.angular_velocity_S)[1:-1]
    # the files smooth attitude and rate apart: they agree to 0.6-0.9 rad/s; a wrong frame or order misses by the rates
    assert np.sqrt(np.mean((given - turned) ** 2)) < 1.0
    assert np.corrcoef(given.ravel(), turned.ravel())[0, 1] > 0.98


@pytest.mark.parametrize("name", FLIGHTS)
def test_the_pitch_of_the_real_wings_is_below_90_deg_on_the_forward_stroke(real_data, name):
    recording = read_recording(real_data / MUIJRES / f"{name}.txt", MUIJRES)
    for wing in (recording.left, recording.right):
        forward = np.gradient(wing.stroke) > 0
        assert np.mean(wing.pitch[forward] < np.pi / 2) > 0.85  # the flip takes a tenth of a wingbeat
        assert np.mean(wing.pitch[~forward] > np.pi / 2) > 0.85


def test_the_stroke_of_the_real_flights_is_that_of_the_laboratory_s_mean_wingbeat(real_data):
    # there positive is dorsal and phase 0 the dorsal reversal
    mean = np.genfromtxt(real_data / "muijres_mean_wingbeats/steady_free_flight.csv", delimiter=",", names=True)[:-1]
    recording = read_recording(real_data / MUIJRES / "20121128_S0003.txt", MUIJRES)
    from flycontrol.model.wingbeats import phase_average, segment_wingbeats

    beats = segment_wingbeats(recording)
    stroke = 0.5 * (recording.left.stroke + recording.right.stroke)
    ours = phase_average(stroke, recording.time, beats, samples=len(mean)).mean
    assert np.corrcoef(-ours, mean["stroke_mean_deg"])[0, 1] > 0.99


@pytest.mark.parametrize("name", TAKE_OFFS)
def test_attitude_and_heading_of_the_real_take_offs_agree(real_data, name):
    path = real_data / "fontaine_takeoff" / f"{name}.csv"
    recording = read_recording(path, "fontaine_takeoff")
    nose_W = Rotation.from_quat(recording.q_WB, scalar_first=True).apply([1, 0, 0])
    to_the_right = -np.arctan2(nose_W[:, 1], nose_W[:, 0])
    apart = np.angle(np.exp(1j * (to_the_right - recording.yaw)))
    assert np.abs(apart).max() < np.radians(9)  # the file's angles are smoothed, its quaternions are not
    climb = np.degrees(np.arcsin(nose_W[:, 2]))
    pitch = np.genfromtxt(path, delimiter=",", names=True)["bodyEul2_deg"]
    assert np.abs(climb - pitch).max() < 9


def test_a_take_off_without_attitude_is_refused_by_the_shipped_mapping(real_data):
    assert "has no column named" in refusal(real_data / "fontaine_takeoff" / "exp095c.csv", "fontaine_takeoff")


def test_a_mapping_is_read_by_name_by_path_or_taken_as_it_is(flight, written, tmp_path):
    path = tmp_path / "same.toml"
    path.write_text(mapping_text(MUIJRES))
    recordings = [
        read_recording(written(flight), m) for m in (MUIJRES, path, read_mapping(path), known_mapping(MUIJRES))
    ]
    for recording in recordings:
        np.testing.assert_array_equal(recording.left.pitch, recordings[0].left.pitch)
        assert recording.notes["mapping_sha256"] == recordings[0].notes["mapping_sha256"]


def test_a_wrong_mapping_on_a_table_without_names_is_refused_in_a_short_sentence(real_data):
    said = refusal(real_data / "muijres_freeflight" / "20121128_S0003.txt", "fontaine_takeoff")
    assert "is the format in the mapping right?" in said
    assert len(said) < 500
