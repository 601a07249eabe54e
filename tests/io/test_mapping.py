import pytest
from hypothesis import given
from hypothesis import strategies as st

from flycontrol.errors import InvalidInputError
from flycontrol.io.mapping import known_mapping, mapping_text, read_mapping, shipped_mappings


def refusal(path):
    with pytest.raises(InvalidInputError) as error:
        read_mapping(path)
    sentence = str(error.value)
    assert "\n" not in sentence
    assert sentence.endswith(".")
    return sentence


@pytest.fixture
def edited(tmp_path):
    def edit(*replacements):
        text = mapping_text("muijres_freeflight")
        for old, new in replacements:
            assert old in text
            text = text.replace(old, new, 1)
        path = tmp_path / "map.toml"
        path.write_text(text)
        return path

    return edit


def test_the_shipped_mappings_are_read_by_name():
    assert shipped_mappings() == ("fontaine_takeoff", "muijres_freeflight", "simulated_trials")
    for name in shipped_mappings():
        assert known_mapping(name).name == name


def test_an_unknown_name_is_refused_with_the_shipped_ones(tmp_path):
    with pytest.raises(InvalidInputError, match="there are fontaine_takeoff, muijres_freeflight, simulated_trials"):
        known_mapping("muijres")
    assert "there is no such file" in refusal(tmp_path / "absent.toml")


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('unit = "mm"', 'unit = "ms"', "position.unit is 'ms', a time; a length such as '2.4 mm' is needed"),
        ('unit = "mm"', 'unit = "foo"', "'foo' is not a unit known here"),
        ('rate = "7500 1/s"', "rate = 7500", 'clock.rate is 7500, without a unit; write a string with a unit'),
        ('rate = "7500 1/s"', 'rate = "7500 ms"', "clock.rate is '7500 ms', a time; a frequency"),
        ('rate = "7500 1/s"', "", "the clock needs a rate"),
        ('rate = "7500 1/s"', 'time = { row = 1, unit = "ms" }', "clock.time contradicts clock.rate and clock.frame"),
        ("frame = { row = 0 }", "frame = { column = 0 }", "clock.frame must name its row and nothing else"),
        ("row = 15,", "row = 15, column = 15,", "left.stroke must name its row and nothing else"),
        ("row = 15", "row = 16", "row 16 is mapped both to left.stroke and to right.stroke"),
        ("row = 15", "row = 21", "row 21 is beyond file.count = 21"),
        ("row = 15", "row = -1", "line 48: left.stroke.row is -1; a number counted from 0, or a name, is needed"),
        ("row = 15", "row = 1.5", "left.stroke.row is 1.5; a number counted"),
        ("row = 15", "row = true", "left.stroke.row is True; a number counted"),
        ("row = 15", 'row = ""', "left.stroke.row is ''; a number counted"),
        ("sign = -1", "sign = 2", "left.stroke.sign is 2; input should be 1 or -1"),
        ('offset = "90 deg"', "offset = 90", "left.pitch.offset is 90, without a unit"),
        ('offset = "90 deg"', 'offset = "90 mm"', "a length; an angle"),
        ("rows = [2, 3, 4]", "rows = [2, 3, -4]", "position.rows.2 is -4; a number counted"),
        ("rows = [2, 3, 4]", "rows = 2", "position.rows is 2; input should be a valid list"),
        ("[clock]", "[[clock]]", "a table is needed"),
        ("rows = [2, 3, 4]", "rows = [2, 3]", "position must list 3 rows and nothing else"),
        ("rows = [2, 3, 4]", "columns = [2, 3, 4]", "position must list 3 rows and nothing else"),
        ("rows = [2, 3, 4]", "rows = [2, 3, 4]\nsigns = [1, 1]", "position.signs has 2 values; three are needed"),
        ("rows = [8, 9, 10, 11]", "rows = [8, 9, 10]", "quaternion must list 4 rows"),
        ('order = "scalar last"', "", "quaternion.order is missing"),
        ('order = "scalar last"', 'order = "xyzw"', "quaternion.order is 'xyzw'; input should be 'scalar first' or"),
        ('world_z = "up"', "", "frames.world_z is missing"),
        ('stroke_plane_angle = "55 deg"', "stroke_plane_angle = 55", "frames.stroke_plane_angle is 55, without a unit"),
        ('frame = "stroke plane"', 'frame = "lab"', "velocity.frame is 'lab'; input should be"),
        ('format = "whitespace"', 'format = "xlsx"', "file.format is 'xlsx'; input should be 'whitespace', 'csv',"),
        ('source = "freeflightplots"', 'source = "nobody"', "'nobody' is no reference"),
        ("[velocity]", "[velocty]", "velocty is not a key known here; the nearest known key is velocity"),
        ("[file]", "[file]\nchannelz = 1", "file.channelz is not a key known here; the nearest known key is file.chan"),
        ('name = "muijres_freeflight"', "", "name is missing"),
        ('deviation = { row = 17, unit = "deg" }', "", "left.deviation is missing"),
        ("[clock]", "[clock", "not valid TOML"),
    ],
)  # fmt: skip
def test_a_fault_is_refused_with_its_place(edited, old, new, said):
    sentence = refusal(edited((old, new)))
    assert said in sentence
    assert "map.toml" in sentence


def test_the_line_of_a_fault_is_named(edited):
    path = edited(('row = 19, unit = "deg"', 'row = 19, unit = "mm"'))
    line = next(n for n, text in enumerate(path.read_text().splitlines(), start=1) if "row = 19" in text)
    assert f"map.toml, line {line}: left.pitch.unit is 'mm', a length" in refusal(path)


def test_a_vector_in_the_body_frame_needs_the_stroke_plane(edited):
    path = edited(('frame = "stroke plane"', 'frame = "body"'), ('stroke_plane_angle = "55 deg"', ""))
    assert "a vector in the body frame needs frames.stroke_plane_angle" in refusal(path)


def test_a_vector_in_the_world_frame_needs_the_attitude(edited):
    quaternion = '[quaternion]\nrows = [8, 9, 10, 11]\norder = "scalar last"\nrotation = "body to world"\n'
    path = edited(('frame = "stroke plane"', 'frame = "world"'), (quaternion, ""))
    assert "a vector in the world frame needs the quaternion" in refusal(path)


def test_a_mapping_of_a_clock_alone_is_refused(tmp_path):
    path = tmp_path / "map.toml"
    path.write_text('name = "x"\n[file]\nformat = "csv"\nchannels = "columns"\n[clock]\nrate = "5000 1/s"\n')
    assert "the mapping has a clock and nothing else" in refusal(path)


@given(st.text(max_size=60))
def test_no_text_crashes_the_reader(tmp_path_factory, text):
    path = tmp_path_factory.getbasetemp() / "any.toml"
    path.write_text(text, encoding="utf-8", errors="replace")
    with pytest.raises(InvalidInputError, match=r"any\.toml"):
        read_mapping(path)
