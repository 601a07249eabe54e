from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from flycontrol.errors import InvalidInputError
from flycontrol.io.mapping import known_mapping, mapping_text, read_mapping
from flycontrol.io.recordings import read_recording
from flycontrol.io.trials import read_trials
from flycontrol.model.paddling import paddling
from flycontrol.model.trial import Pulse, TorqueTrace
from flycontrol.model.wingbeats import segment_wingbeats

RATE = 5000.0
TIME = np.arange(400) / RATE
YAW = 20 * np.sin(50 * TIME)  # [deg]

HEAD = "name = 'test'\n[file]\nformat = 'csv'\nchannels = 'columns'\n"
CLOCK = "[clock]\ntime = { column = 't', unit = 's' }\n"
HEADING = "[yaw]\ncolumn = 'yaw'\nunit = 'deg'\n"
PULSE = "[perturbation]\nonset = '20 ms'\nduration = '5 ms'\n"


@pytest.fixture
def mapping(tmp_path):
    def write(*sections):
        path = tmp_path / "map.toml"
        path.write_text("".join([HEAD, *(sections or (CLOCK, HEADING, PULSE))]))
        return path

    return write


@pytest.fixture
def table(tmp_path):
    """Write a table of named columns, numbers or texts, and return its path."""

    def write(name="a.csv", separator=",", **columns):
        columns = columns or {"t": TIME, "yaw": YAW}
        path = tmp_path / name
        path.parent.mkdir(exist_ok=True, parents=True)
        rows = zip(*columns.values(), strict=True)
        lines = [separator.join(columns)] + [separator.join(map(str, row)) for row in rows]
        path.write_text("\n".join(lines) + "\n")
        return path

    return write


def refusal(paths, mapping):
    with pytest.raises(InvalidInputError) as error:
        read_trials(paths if isinstance(paths, list) else [paths], mapping)
    sentence = str(error.value)
    assert "\n" not in sentence
    assert sentence.endswith((".", "?"))
    return sentence


def test_a_trial_is_read_in_si_units_with_its_pulse(table, mapping):
    (trial,) = read_trials([table()], mapping())
    np.testing.assert_allclose(trial.time, TIME, rtol=1e-15)
    np.testing.assert_allclose(trial.yaw, np.radians(YAW), rtol=1e-15)
    assert (trial.name, trial.fly) == ("a", "a")
    assert trial.rate == pytest.approx(RATE, rel=1e-12)
    assert trial.perturbation == Pulse(onset=0.020, duration=0.005)
    assert trial.notes["mapping"] == "test"


def test_hundreds_of_files_are_named_by_a_pattern_and_told_of(table, mapping):
    for k in range(300):
        table(f"flies/{k:03}.csv", t=TIME[:50], yaw=YAW[:50] + k / 10)
    told = []
    folder = table().parent
    trials = read_trials(
        [f"{folder}/flies/*.csv"],
        mapping(CLOCK, HEADING),
        progress=lambda done, total, what: told.append((done, total)),
    )
    assert [trial.name for trial in trials] == [f"{k:03}" for k in range(300)]
    assert told == [(k + 1, 300) for k in range(300)]


def test_rates_and_lengths_may_differ(table, mapping):
    files = [table(f"{n}.csv", t=np.arange(n) / (40.0 * n), yaw=YAW[:n]) for n in (100, 200)]
    trials = read_trials(files, mapping(CLOCK, HEADING))
    assert [len(trial.time) for trial in trials] == [100, 200]
    np.testing.assert_allclose([trial.rate for trial in trials], [4000, 8000], rtol=1e-12)


@pytest.mark.parametrize("missing", ["", "nan", "NaN", " "])
def test_missing_samples_are_nan(table, mapping, missing):
    yaw = [missing if 10 <= k < 20 else value for k, value in enumerate(YAW)]
    (trial,) = read_trials([table(t=TIME, yaw=yaw)], mapping())
    assert np.flatnonzero(np.isnan(trial.yaw)).tolist() == list(range(10, 20))
    np.testing.assert_allclose(np.degrees(trial.yaw[20:]), YAW[20:], rtol=1e-13)


def test_dropped_frames_leave_a_gap_in_time(table, mapping):
    kept = np.delete(np.arange(400), [7, 8, 9, 100])
    clock = "[clock]\nframe = { column = 'frame' }\nrate = '5000 1/s'\nstart = '-20 ms'\n"
    (trial,) = read_trials([table(frame=kept, yaw=YAW[kept])], mapping(clock, HEADING))
    np.testing.assert_allclose(trial.time, kept / RATE - 0.020, rtol=1e-12, atol=1e-17)
    by_times = read_trials([table(t=TIME[kept], yaw=YAW[kept])], mapping())[0]
    np.testing.assert_allclose(by_times.time, TIME[kept], rtol=1e-15)
    assert by_times.rate == pytest.approx(RATE, rel=1e-12)


# Heading


def wrapped(angle):
    return (angle + 180) % 360 - 180


def test_yaw_is_unwrapped_across_missing_samples(table, mapping):
    turning = 170 + 600 * TIME + YAW
    yaw = ["" if 3 < k < 100 and k % 7 else value for k, value in enumerate(wrapped(turning))]
    (trial,) = read_trials([table(t=TIME, yaw=yaw)], mapping())
    known = np.isfinite(trial.yaw)
    np.testing.assert_allclose(np.degrees(trial.yaw[known]), turning[known], rtol=1e-13)


def gappy(gap):
    """A recording that turns by 100 deg while nobody looks for a time [s]."""
    time = np.concatenate([TIME[:200], TIME[:200] + TIME[199] + gap])
    return time, np.concatenate([YAW[:200], YAW[:200] + 100])


def test_a_gap_in_which_yaw_is_ambiguous_is_refused(table, mapping):
    time, yaw = gappy(0.060)  # the longer way, 260 deg, is 76 rad/s
    said = refusal(table(t=time, yaw=yaw), mapping())
    turned = (yaw[200] - yaw[199]) % 360
    assert "a.csv, line 202, field 2: yaw may have turned by" in said
    assert f"by {turned:.3g} or by {turned - 360:.3g} deg in the gap of 60 ms" in said


def test_a_short_gap_is_not_ambiguous(table, mapping):
    time, yaw = gappy(0.030)  # the longer way would be over 150 rad/s
    (trial,) = read_trials([table(t=time, yaw=yaw)], mapping())
    np.testing.assert_allclose(np.degrees(trial.yaw), yaw, rtol=1e-13)


def test_a_trial_may_be_cut_at_an_ambiguous_gap_and_keeps_the_side_of_the_pulse(table, mapping):
    time, yaw = gappy(0.060)
    cut = "[trial]\ngaps = 'cut'\n"
    (before,) = read_trials([table(t=time, yaw=yaw)], mapping(CLOCK, HEADING, cut, PULSE))
    np.testing.assert_allclose(before.time, time[:200], rtol=1e-15)
    later = PULSE.replace("20 ms", "120 ms")
    (after,) = read_trials([table(t=time, yaw=yaw)], mapping(CLOCK, HEADING, cut, later))
    np.testing.assert_allclose(after.time, time[200:], rtol=1e-15)
    assert after.notes["cut at gaps"].startswith("99.8 to 139.6 ms of 0 to")
    (longest,) = read_trials([table(t=time[150:], yaw=yaw[150:])], mapping(CLOCK, HEADING, cut))
    np.testing.assert_allclose(longest.time, time[200:], rtol=1e-15)


def test_an_unwrapped_yaw_is_taken_as_it_is(table, mapping):
    time, yaw = gappy(0.060)
    unwrapped = HEADING + "unwrapped = true\n"
    (trial,) = read_trials([table(t=time, yaw=yaw)], mapping(CLOCK, unwrapped))
    np.testing.assert_allclose(np.degrees(trial.yaw), yaw, rtol=1e-13)
    said = refusal(table(t=TIME, yaw=wrapped(YAW + 175)), mapping(CLOCK, unwrapped))
    assert "but the mapping says yaw.unwrapped = true; leave that out" in said


def test_the_heading_of_an_attitude_is_where_the_nose_points(table, mapping):
    heading = np.radians(170 + 10 * YAW)  # to the right, beyond 180
    upright = Rotation.from_euler("x", np.pi)  # body z down, world z up
    body = Rotation.from_euler("ZYX", np.column_stack([heading, 0 * TIME + 0.7, 0.3 * np.sin(TIME)]))
    x, y, z, w = (upright * body).as_quat().T
    attitude = (
        "[frames]\nworld_z = 'up'\n[quaternion]\ncolumns = ['w', 'x', 'y', 'z']\n"
        "order = 'scalar first'\nrotation = 'body to world'\n"
    )
    (trial,) = read_trials([table(t=TIME, w=w, x=x, y=y, z=z)], mapping(CLOCK, attitude))
    np.testing.assert_allclose(trial.yaw, heading, rtol=1e-12)
    gone = np.where(np.arange(400) == 30, np.nan, w)
    (gappy_trial,) = read_trials([table(t=TIME, w=gone, x=x, y=y, z=z)], mapping(CLOCK, attitude))
    assert np.flatnonzero(np.isnan(gappy_trial.yaw)).tolist() == [30]


def test_a_mapped_yaw_needs_no_attitude(table):
    take_off = known_mapping("fontaine_takeoff")
    path = table(frame=np.arange(400), bodyEul3_deg=YAW)
    (trial,) = read_trials([path], take_off)
    np.testing.assert_allclose(np.degrees(trial.yaw), YAW, rtol=1e-13)
    with pytest.raises(InvalidInputError, match="has no column named 'x"):
        read_recording(path, take_off)


# The perturbation


def test_a_trace_is_kept_in_its_si_unit(table, mapping):
    coil = np.where((TIME > 0.02) & (TIME < 0.025), 40.0, 0.0)
    path = table(t=TIME, yaw=YAW, coil=coil)
    trace = "[perturbation]\ntrace = { column = 'coil', unit = 'mA' }\n"
    (trial,) = read_trials([path], mapping(CLOCK, HEADING, trace))
    assert isinstance(trial.perturbation, TorqueTrace)
    assert trial.perturbation.unit == "A"
    np.testing.assert_allclose(trial.perturbation.drive, coil * 1e-3, rtol=1e-15)
    assert trial.perturbation.angular_acceleration_per_unit is None
    calibrated = trace + "angular_acceleration_per_unit = '500 rad/s^2'\n"  # of each mA
    (trial,) = read_trials([path], mapping(CLOCK, HEADING, calibrated))
    assert trial.perturbation.angular_acceleration_per_unit == pytest.approx(500e3, rel=1e-14)
    torque = "[perturbation]\ntrace = { column = 'coil', unit = 'pN m' }\ninertia = '4e-13 kg m^2'\n"
    (trial,) = read_trials([path], mapping(CLOCK, HEADING, torque))
    assert (trial.perturbation.unit, trial.perturbation.drive.max()) == ("N m", pytest.approx(40e-12, rel=1e-14))
    assert trial.perturbation.angular_acceleration_per_unit == pytest.approx(1 / 4e-13, rel=1e-14)


def test_an_unknown_perturbation_is_none(table, mapping):
    for section in ("", "[perturbation]\nkind = 'unknown'\n"):
        assert read_trials([table()], mapping(CLOCK, HEADING, section))[0].perturbation is None


def test_onset_and_duration_may_stand_in_columns(table, mapping):
    section = "[perturbation]\nonset = { column = 'on', unit = 'ms' }\nduration = { column = 'for', unit = 'ms' }\n"
    columns = {"t": TIME, "yaw": YAW, "on": [12.5] * 400, "for": [5.0, *[""] * 399]}
    (trial,) = read_trials([table(**columns)], mapping(CLOCK, HEADING, section))
    assert (trial.perturbation.onset, trial.perturbation.duration) == pytest.approx((12.5e-3, 5e-3), rel=1e-15)
    columns["on"] = [12.5] * 399 + [13.0]
    said = refusal(table(**columns), mapping(CLOCK, HEADING, section))
    assert "perturbation.onset is 12.5 and, at" in said
    assert "line 401, field 3, 13; one number is needed for a trial" in said


@pytest.mark.parametrize(
    ("section", "said"),
    [
        (PULSE.replace("20 ms", "20 s"), "the pulse from 20000 to 20005 ms lies outside the recording from 0 to 79.8"),
        (PULSE.replace("5 ms", "5 s"), "the pulse lasts 5000 ms, longer than the recording"),
        (PULSE.replace("'5 ms'", "{ column = 'zero', unit = 'ms' }"), "perturbation.duration is 0 s; a pulse lasts"),
        ("[perturbation]\ntrace = { column = 'zero', unit = 'A' }\n", "perturbation.trace never changes"),
    ],
)
def test_a_perturbation_that_cannot_be_is_refused(table, mapping, section, said):
    path = table(t=TIME, yaw=YAW, zero=0 * TIME)
    assert said in refusal(path, mapping(CLOCK, HEADING, section))


TRACE = "[perturbation]\ntrace = { column = 'yaw2', unit = 'A' }\n"


@pytest.mark.parametrize(
    ("section", "said"),
    [
        (PULSE + "trace = { column = 'yaw2', unit = 'A' }\n", "perturbation.trace contradicts a perturbation of"),
        (PULSE + "kind = 'unknown'\n", "perturbation.onset contradicts a perturbation of the kind 'unknown'"),
        (PULSE + "kind = 'trace'\n", "perturbation.onset contradicts a perturbation of the kind 'trace'"),
        ("[perturbation]\nonset = '20 ms'\n", "perturbation has no duration"),
        ("[perturbation]\nkind = 'pulse'\n", "perturbation has no onset"),
        ("[perturbation]\nkind = 'trace'\n", "perturbation has no trace"),
        ("[perturbation]\nonset = 20\nduration = '5 ms'\n", "perturbation.onset is 20, without a unit"),
        ("[perturbation]\nonset = '20 ms'\nduration = '0 ms'\n", "a pulse lasts longer than 0 s"),
        ("[perturbation]\nonset = { column = 'x' }\nduration = '5 ms'\n", "perturbation.onset.unit is missing"),
        ("[perturbation]\nonset = { kolumn = 'x', unit = 's' }\n", "perturbation.onset.kolumn is not a key known here"),
        (TRACE.replace("'A'", "'mm'"), "trace.unit is 'mm', a length; a current such as '50 mA' or"),
        (TRACE + "torque_per_unit = '1e-12 N m'\n", "needs torque_per_unit and inertia together"),
        (TRACE + "inertia = '-1 kg m^2'\n", "perturbation.inertia is '-1 kg m^2'; more than 0 is needed"),
        (
            TRACE + "angular_acceleration_per_unit = '1 rad/s^2'\ninertia = '1e-13 kg m^2'\n",
            "angular_acceleration_per_unit contradicts torque_per_unit and inertia",
        ),
        (
            TRACE.replace("'A'", "'N m'") + "torque_per_unit = '1e-12 N m'\n",
            "contradicts a trace that is a torque already",
        ),
        (TRACE + "time = { column = 't2', unit = 's' }\n", "in a table the trace has the trial's clock"),
        (TRACE.replace("yaw2", "yaw"), "column 'yaw' is mapped both to yaw and to perturbation.trace"),
        ("[trial]\ngroups = 'a*'\n", "trial.groups needs a file with groups: mat, hdf5 or netcdf"),
        ("[trial]\ngroups = 'a'\ncolumn = 'b'\n", "trial.groups contradicts trial's column"),
        ("[trial]\nfly = 3\n", "trial.fly is 3; a text or a table such as"),
        ("[trial]\nfly = { attribute = 'a' }\n", "trial.fly names an attribute, but files of this format have none"),
        ("[trial]\nfly = { file_name = '(' }\n", "trial.fly.file_name is '(', not a regular expression"),
        ("[trial]\nfly = { file_name = 'a' }\n", "what is meant must be in brackets"),
        ("[trial]\nfly = { file_name = '(a)', path = '(b)' }\n", "trial.fly names several places"),
        ("[trial]\ngaps = 'split'\n", "trial.gaps is 'split'; input should be 'refuse' or 'cut'"),
        ("[paddling]\ncolumn = 'a'\nconvention = 'd_alpha'\n", "paddling needs one channel and its unit"),
        ("[paddling]\nconvention = 'attack angle'\n", "paddling needs left, right, stroke alone"),
        ("[paddling]\nconvention = 'twice'\n", "paddling.convention is 'twice'; input should be 'd_alpha'"),
        ("start = '1 ms'\n", "yaw.start is not a key known here"),
    ],
)  # fmt: skip
def test_a_mapping_that_contradicts_itself_is_refused(mapping, section, said):
    with pytest.raises(InvalidInputError) as error:
        read_mapping(mapping(CLOCK, HEADING, section))
    assert said in str(error.value)
    assert "map.toml" in str(error.value)


@pytest.mark.parametrize(
    ("file", "said"),
    [
        ("format = 'csv'", "file.channels is missing; say whether they are 'rows' or 'columns'"),
        ("format = 'mat'\nchannels = 'columns'", "the channels of a mat file are variables"),
        ("format = 'hdf5'\ncount = 4", "the channels of a hdf5 file are variables"),
        ("format = 'parquet'\nchannels = 'rows'", "a Parquet file's channels are columns"),
        ("format = 'mat'", "clock.time must name its variable"),
    ],
)
def test_a_layout_that_contradicts_the_format_is_refused(tmp_path, file, said):
    path = tmp_path / "map.toml"
    path.write_text(f"name = 'x'\n[file]\n{file}\n{CLOCK}{HEADING}")
    with pytest.raises(InvalidInputError) as error:
        read_mapping(path)
    assert said in str(error.value)


# The wings


@pytest.mark.parametrize(
    ("convention", "share"), [("d_alpha", 1.0), ("right minus left, forward stroke", 0.5)], ids=["d_alpha", "Fig. 7d"]
)
def test_a_channel_of_paddling_minds_the_factor_of_two(table, mapping, convention, share):
    section = f"[paddling]\ncolumn = 'p'\nunit = 'deg'\nconvention = '{convention}'\n"
    plotted = 12 * np.cos(40 * TIME)
    (trial,) = read_trials([table(t=TIME, yaw=YAW, p=plotted)], mapping(CLOCK, HEADING, section))
    np.testing.assert_allclose(np.degrees(trial.paddling), share * plotted, rtol=1e-14)


def test_attack_angles_of_both_wings_give_d_alpha_on_both_half_strokes(table, mapping):
    """The definition: right wing alpha0 + d_alpha and left wing alpha0 - d_alpha forward, the reverse backward."""
    phase = 2 * np.pi * 200 * TIME + 0.1
    stroke, d_alpha = 70 * np.sin(phase), 5 * np.cos(30 * TIME)  # [deg]
    sign = np.where(np.cos(phase) > 0, 1, -1)
    left, right = 45 - sign * d_alpha, 45 + sign * d_alpha
    columns = {"t": TIME, "yaw": YAW, "left": left, "right": right, "stroke": stroke}
    wings = "left = { column = 'left', unit = 'deg' }\nright = { column = 'right', unit = 'deg' }\n"
    beat = "stroke = { column = 'stroke', unit = 'deg' }\nconvention = 'attack angle'\n"
    (trial,) = read_trials([table(**columns)], mapping(CLOCK, HEADING, f"[paddling]\n{wings}{beat}"))
    reversal = np.abs(np.cos(phase)) < 0.2  # a difference over two samples does not tell the half-stroke there
    np.testing.assert_allclose(np.degrees(trial.paddling[~reversal]), d_alpha[~reversal], rtol=1e-12)
    forward = f"[paddling]\n{wings}convention = 'attack angle, forward stroke'\n"
    (trial,) = read_trials([table(**columns)], mapping(CLOCK, HEADING, forward))
    np.testing.assert_allclose(np.degrees(trial.paddling), sign * d_alpha, rtol=1e-12)
    pitch = {**columns, "left": np.where(sign > 0, left, 180 - left), "right": np.where(sign > 0, right, 180 - right)}
    section = f"[paddling]\n{wings}convention = 'wing pitch'\n"
    (trial,) = read_trials([table(**pitch)], mapping(CLOCK, HEADING, section))
    np.testing.assert_allclose(np.degrees(trial.paddling), d_alpha, rtol=1e-11)


def test_paddling_may_be_that_of_the_mapped_wings(real_data, tmp_path):
    text = mapping_text("muijres_freeflight").replace("[notes]", "[paddling]\nconvention = 'wing pitch'\n\n[notes]")
    (tmp_path / "map.toml").write_text(text)
    path = real_data / "muijres_freeflight" / "20121009_S0003.txt"
    (trial,) = read_trials([path], tmp_path / "map.toml")
    recording = read_recording(path, "muijres_freeflight")
    beats = segment_wingbeats(recording)
    np.testing.assert_allclose(trial.paddling, paddling(recording, beats).series, rtol=1e-12, atol=1e-15)


def test_degrees_of_paddling_called_radians_are_refused(table, mapping):
    section = "[paddling]\ncolumn = 'p'\nunit = 'rad'\nconvention = 'd_alpha'\n"
    path = table(t=TIME, yaw=YAW, p=12 * np.cos(TIME))
    assert "paddling is 12 rad; are the numbers degrees?" in refusal(path, mapping(CLOCK, HEADING, section))


# Names


def tidy(table, **changes):
    columns = {
        "trial": ["one"] * 150 + ["two"] * 150 + ["one"] * 100,
        "fly": ["f1"] * 150 + ["f2"] * 150 + ["f1"] * 100,
        "t": np.r_[TIME[:150], TIME[:150], TIME[150:250]],
        "yaw": np.r_[YAW[:150], 1 + YAW[:150], YAW[150:250]],
    }
    return table(**(columns | changes))


TIDY = "[trial]\ncolumn = 'trial'\nfly = { column = 'fly' }\n"


def test_a_tidy_table_holds_several_trials(table, mapping):
    one, two = read_trials([tidy(table)], mapping(CLOCK, HEADING, TIDY))
    assert (one.name, one.fly, two.name, two.fly) == ("a:one", "f1", "a:two", "f2")
    np.testing.assert_allclose(np.degrees(one.yaw), YAW[:250], rtol=1e-13)
    np.testing.assert_allclose(np.degrees(two.yaw), 1 + YAW[:150], rtol=1e-13)


def test_a_refusal_in_a_tidy_table_names_the_line_of_the_file(table, mapping):
    yaw = [*YAW[:300], "oops", *YAW[301:]]
    assert "a.csv, line 302, field 4: yaw is not a usable number" in refusal(
        tidy(table, yaw=yaw), mapping(CLOCK, HEADING, TIDY)
    )


def test_a_row_without_a_trial_and_a_trial_of_two_flies_are_refused(table, mapping):
    trials = ["one"] * 399 + [""]
    assert "the column that names the trials is wanting at sample 400" in refusal(
        tidy(table, trial=trials, t=TIME), mapping(CLOCK, HEADING, TIDY)
    )
    said = refusal(tidy(table, fly=["f1"] * 350 + ["f2"] * 50), mapping(CLOCK, HEADING, TIDY))
    assert "trial.fly differs within the trial ('f1', 'f2'); one word is needed" in said


def test_the_name_of_the_file_or_its_path_tells_the_fly(table, mapping):
    files = [table(f"fly{k}/run_{k}{n}.csv", t=TIME, yaw=YAW + 10 * k + n) for k in (1, 2) for n in (1, 2)]
    for section in ("fly = { file_name = 'run_([0-9])' }", "fly = { path = '(fly[0-9])/' }"):
        trials = read_trials(files, mapping(CLOCK, HEADING, f"[trial]\n{section}\n"))
        assert [trial.fly[-1] for trial in trials] == ["1", "1", "2", "2"]
    constant = read_trials(files[:2], mapping(CLOCK, HEADING, "[trial]\nfly = 'Anna'\n"))
    assert {trial.fly for trial in constant} == {"Anna"}
    said = refusal(files, mapping(CLOCK, HEADING, "[trial]\nfly = { file_name = 'walk_([0-9])' }\n"))
    assert "trial.fly finds nothing by 'walk_([0-9])' in 'run_11.csv'" in said


def test_two_recordings_with_one_name_are_refused_unless_their_path_tells_them_apart(table, mapping):
    files = [table(f"fly{k}/run.csv", t=TIME, yaw=YAW + k) for k in (1, 2)]
    said = refusal(files, mapping())
    assert "two recordings with one name, 'run', in " in said
    assert "fly1/run.csv" in said
    assert "fly2/run.csv" in said
    named = mapping(CLOCK, HEADING, "[trial]\nname = { path = '(fly[0-9]/.*)[.]csv' }\n")
    assert [trial.name for trial in read_trials(files, named)] == ["fly1/run", "fly2/run"]


def test_the_same_bytes_and_the_same_file_twice_are_refused(table, mapping):
    first = table()
    copy = first.with_name("copy.csv")
    copy.write_bytes(first.read_bytes())
    assert "copy.csv holds the same bytes as" in refusal([first, copy], mapping())
    assert "is named twice" in refusal([first, first.parent / ".." / first.parent.name / "a.csv"], mapping())


def test_a_pattern_without_a_match_and_no_file_at_all_are_refused(tmp_path, mapping):
    assert "No file matches" in refusal(str(tmp_path / "*.csv"), mapping())
    assert "No recording is named" in refusal([], mapping())
    assert "there is no such file" in refusal(tmp_path / "absent.csv", mapping())


def test_a_file_whose_name_looks_like_a_pattern_is_read(table, mapping):
    assert read_trials([table("a[1].csv")], mapping())[0].name == "a[1]"


def test_a_spreadsheet_s_semicolons_and_decimal_commas_are_read_as_the_mapping_says(table, tmp_path):
    columns = {name: [str(value).replace(".", ",") for value in values] for name, values in (("t", TIME), ("yaw", YAW))}
    path = table(separator=";", **columns)
    layout = HEAD + "separator = ';'\ndecimal = ','\n"
    (tmp_path / "map.toml").write_text(layout + CLOCK + HEADING)
    np.testing.assert_allclose(np.degrees(read_trials([path], tmp_path / "map.toml")[0].yaw), YAW, rtol=1e-14)
    columns["yaw"][3] = "1.234,5"
    said = refusal(table(separator=";", **columns), tmp_path / "map.toml")
    assert 'yaw is not a usable number ("1.234,5")' in said
    for wrong, sentence in (
        (HEAD + "decimal = ','\n", "commas cannot both separate the fields and mark the decimals"),
        (HEAD.replace("csv", "tsv") + "separator = ';'\n", "file.separator is for csv, not tsv"),
        (
            HEAD.replace("csv", "parquet") + "decimal = ','\n",
            "a parquet file has neither separators nor decimal commas",
        ),
    ):
        (tmp_path / "map.toml").write_text(wrong + CLOCK + HEADING)
        assert sentence in refusal(path, tmp_path / "map.toml")


# What is implausible


@pytest.mark.parametrize(
    ("columns", "said"),
    [
        ({"t": TIME, "yaw": 0 * TIME}, "yaw is 0 deg throughout; a fly in flight is never still"),
        ({"t": TIME, "yaw": [""] * 400}, "yaw has fewer than two samples"),
        ({"t": TIME, "yaw": ["1"] + ["nan"] * 399}, "yaw has fewer than two samples"),
        ({"t": TIME, "yaw": ["-9999"] + ["1", "2", "3"] * 133}, "yaw reaches -174.5 rad; that is more than four turns"),
        ({"t": TIME, "yaw": [5, -999] + [5, 6] * 199}, "line 3, field 2: yaw jumps by -1004 deg, more than a turn"),
        ({"t": TIME, "yaw": ["1,5", *YAW[1:]]}, "line 2: 3 fields where line 1 has 2"),
        ({"t": TIME, "yaw": ["1,5", *YAW[1:]]}, "are format, separator and decimal in [file] of the mapping right?"),
        ({"t": TIME, "yaw": ['"1,5"', *YAW[1:]]}, 'yaw is not a usable number ("1,5")'),
        (
            {"t": TIME, "yaw": ["inf", *YAW[1:]]},
            'yaw is not a usable number ("inf"); mark what is missing with an empty',
        ),
        ({"t": ["", *TIME[1:]], "yaw": YAW}, 'clock.time is not a usable number ("")'),
        ({"t": TIME[::-1], "yaw": YAW}, "clock.time goes back"),
        ({"t": np.round(TIME, 3), "yaw": YAW}, "clock.time repeats (0.0 to 0.0); times must increase"),
        ({"t": TIME * 1e3, "yaw": YAW}, "5 samples a second, outside the plausible"),
        ({"t": TIME, "yaw": 180 * (np.arange(400) % 50 < 25)}, "yaw changes by"),
        ({"t": TIME, "jaw": YAW}, "has no column named 'yaw'; the nearest is 'jaw'"),
    ],
)
def test_what_is_no_fly_s_yaw_is_refused(table, mapping, columns, said):
    sentence = refusal(table(**columns), mapping())
    assert said in sentence
    assert "a.csv" in sentence


def test_a_mapping_without_yaw_or_attitude_is_refused(table, mapping):
    section = "[left]\nstroke = { column = 'a', unit = 'deg' }\ndeviation = { column = 'b', unit = 'deg' }\n"
    said = refusal(table(), mapping(CLOCK, section, "pitch = { column = 'c', unit = 'deg' }\n"))
    assert "maps neither yaw nor the quaternion" in said


# Real recordings, read by mapping alone


def test_the_real_flights_are_trials_whose_heading_is_that_of_their_attitude(real_data):
    trials = read_trials([f"{real_data}/muijres_freeflight/2*.txt"], "muijres_freeflight")
    assert [trial.name for trial in trials] == ["20121009_S0003", "20121120_S0001", "20121128_S0003"]
    for trial in trials:
        recording = read_recording(real_data / "muijres_freeflight" / f"{trial.name}.txt", "muijres_freeflight")
        nose_W = Rotation.from_quat(recording.q_WB, scalar_first=True).apply([1, 0, 0])
        np.testing.assert_allclose(np.tan(trial.yaw), -nose_W[:, 1] / nose_W[:, 0], rtol=1e-9)
        assert np.abs(np.diff(trial.yaw)).max() < 0.05  # 375 rad/s at 7500 frames a second
        assert trial.perturbation is None
        assert trial.paddling is None


def test_all_five_real_take_offs_are_trials(real_data):
    trials = read_trials([f"{real_data}/fontaine_takeoff/exp*.csv"], "fontaine_takeoff")
    assert [len(trial.time) for trial in trials] == [111, 231, 212, 231, 131]
    for trial in trials:
        path = real_data / "fontaine_takeoff" / f"{trial.name}.csv"
        azimuth = np.genfromtxt(path, delimiter=",", names=True)["bodyEul3_deg"]
        np.testing.assert_allclose(np.degrees(trial.yaw), azimuth, rtol=1e-12)


def test_a_mapping_may_be_given_as_an_object(table, mapping):
    known = read_mapping(mapping())
    assert read_trials([table()], replace(known, name="other"))[0].perturbation.duration == pytest.approx(0.005)
