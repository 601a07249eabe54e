import math
import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from flycontrol.errors import InvalidInputError
from flycontrol.io.fly_files import parameter_text, shipped_parameters
from flycontrol.io.morphology import read_morphology_table
from flycontrol.io.parameters import read_parameters
from flycontrol.model.references import references


@pytest.fixture
def fly(tmp_path):
    """Write a fly file and return its path."""

    def write(text):
        path = tmp_path / "my_fly.toml"
        path.write_text(text)
        return path

    return write


def refusal(path):
    with pytest.raises(InvalidInputError) as error:
        read_parameters(path)
    sentence = str(error.value)
    assert "\n" not in sentence
    assert sentence.endswith(".")
    return sentence


def test_the_default_is_the_published_fly():
    fly = read_parameters()
    assert fly.inertia.value == 3.06e-13
    assert fly.damping.value == 21e-12
    assert fly.delay_in_wingbeats == pytest.approx(3, rel=1e-5)  # 13.6364 ms is rounded at the sixth digit
    assert fly.pulse_peak.value == pytest.approx(math.radians(20), rel=1e-15)
    assert (fly.damping_low.value, fly.damping_high.value) == (69, 176)


def test_the_published_range_of_damping_is_the_ratio_of_its_sources():
    fly = read_parameters()
    assert fly.damping_low.value == pytest.approx(21e-12 / fly.inertia.value, rel=0.01)  # printed without decimals
    assert fly.damping_high.value == pytest.approx(54e-12 / fly.inertia.value, rel=0.01)


@pytest.mark.parametrize("name", shipped_parameters())
def test_every_shipped_number_has_a_source_and_a_certainty(name):
    for field, number in read_parameters(name).sourced().items():
        assert number.source, field
        assert number.certainty in {"S", "S2", "C"}, field


@pytest.mark.parametrize("name", shipped_parameters())
def test_a_shipped_file_is_complete(name):
    assert read_parameters(name).defaulted == ()


def test_the_printed_default_reads_back_as_the_default(fly):
    read = read_parameters(fly(parameter_text()))
    default = read_parameters()
    assert read.sourced() == default.sourced()
    assert read.sha256 == default.sha256


def test_missing_keys_come_from_the_default_file_and_are_recorded(fly):
    read = read_parameters(fly('[controller]\ndelay = "12 ms"\n'))
    default = read_parameters()
    assert read.delay.value == 12e-3
    assert (read.delay.certainty, read.delay.source) == ("user", "")
    assert "controller.delay" not in read.defaulted
    assert set(read.defaulted) >= {"fly.name", "fly.inertia", "controller.proportional_gain", "pulse.peak"}
    assert read.inertia == default.inertia
    assert read.sha256 != default.sha256


def test_a_value_may_carry_its_source(fly):
    read = read_parameters(
        fly('[fly]\ndamping = { value = "54e-12 N m s", source = "hesselberg2007", certainty = "S" }')
    )
    assert (read.damping.value, read.damping.source, read.damping.certainty) == (54e-12, "hesselberg2007", "S")


def test_gains_given_as_torques_are_divided_by_the_inertia(fly):
    torques = '[fly]\ninertia = "2e-13 kg m^2"\n[controller]\n'
    torques += 'proportional_gain = "8e-10 N m/rad"\nderivative_gain = "1.2e-11 N m s/rad"'
    read = read_parameters(fly(torques))
    assert read.proportional_gain.value == pytest.approx(4000, rel=1e-15)
    assert read.derivative_gain.value == pytest.approx(60, rel=1e-15)
    assert (read.proportional_gain.unit, read.derivative_gain.unit) == ("1/s^2", "1/s")


def test_one_gain_as_a_torque_and_one_as_a_ratio_is_refused(fly):
    mixed = '[controller]\nproportional_gain = "8e-10 N m/rad"\nderivative_gain = "60 1/s"'
    assert "my_fly.toml, line 3: one gain is a torque" in refusal(fly(mixed))


@pytest.mark.parametrize(
    ("line", "said"),
    [
        (
            "delay = 13.6",
            "line 2: controller.delay is 13.6, without a unit; write a string with a unit, for example delay",
        ),
        ('delay = "13.6"', "controller.delay is '13.6', without a unit"),
        ('delay = "13.6 mm"', "controller.delay is '13.6 mm', a length; a time such as '13.6 ms' is needed"),
        ('delay = "13 s"', "controller.delay is '13 s', outside the plausible 0.1 ms to 1000 ms; check the number"),
        ('delay = "13 us"', "outside the plausible 0.1 ms to 1000 ms"),
        ('delay = "-13 ms"', "outside the plausible"),
        ('delay = "nan ms"', "not a finite number"),
        ('delay = ""', "not a finite number"),
        ("delay = { value = 13.6 }", "controller.delay is 13.6, without a unit"),
        ('delay = { source = "review" }', "controller.delay.value is missing"),
        ('delay = { value = "13 ms", certainty = "sure" }', "controller.delay.certainty is 'sure'; input should be"),
        ('delay = { value = "13 ms", source = "ristrop2010" }', "the nearest is 'ristroph2010'"),
        ('delay = { value = "13 ms", nota = "" }', "controller.delay.nota is not a key known here"),
        (
            'dealy = "13.6 ms"',
            "line 2: controller.dealy is not a key known here; the nearest known key is controller.delay",
        ),
        (
            'inertia = "3e-13 kg m^2"',
            "controller.inertia is not a key known here; the nearest known key is fly.inertia",
        ),
        ('proportional_gain = "3050 1/s"', "a frequency; a squared rate such as '3050 1/s^2' or a torque per angle"),
        ('derivative_gain = "45 N m"', "a torque; a frequency"),
        ('proportional_gain = "9 N m/rad"', "outside the plausible"),
    ],
)
def test_a_fault_in_the_controller_is_refused_with_its_place(fly, line, said):
    sentence = refusal(fly(f"[controller]\n{line}\n"))
    assert said in sentence
    assert "my_fly.toml, line 2" in sentence


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ('[fly]\nwingbeat_frequency = "2 Hz"', "outside the plausible 20 Hz to 2000 Hz"),
        ('[fly]\ninertia = "3.06e-13 kg mm^2"', "outside the plausible 1e-15 kg m^2"),
        ('[fly]\ninertia = "-3.06e-13 kg m^2"', "outside the plausible"),
        ('[fly]\ndamping = "21 N m s"', "outside the plausible"),
        ('[fly]\ndamping = "21e-9 N m s"', "damping over inertia is 6.86e+04 1/s, outside the plausible"),
        ('[fly]\nname = ""', "fly.name is ''"),
        ("[fly]\nname = 3", "fly.name is 3; input should be a valid string"),
        ('[pulse]\npeak = "20 rad"', "pulse.peak is '20 rad', outside the plausible 0.01 deg to 180 deg"),
        ('[pulse]\npeak = "1 deg"', "pulse.tolerance (2 deg) must be smaller than pulse.peak (1 deg)"),
        ('[damping_range]\nlow = "200 1/s"', "damping_range.low (200 1/s) must be smaller than damping_range.high"),
        ("fly = 3", "fly is 3; a table [fly] is needed"),
        ("[flyy]", "flyy is not a key known here; the nearest known key is fly"),
        ("[[fly]]", "a table [fly] is needed"),
        ('[fly]\nname = "a"\nname = "b"', "not valid TOML"),
        ("delay: 13.6 ms", "not valid TOML"),
        ("a = " + "[" * 5000, "not valid TOML"),
    ],
)
def test_a_fault_anywhere_is_refused_in_one_sentence(fly, text, said):
    assert said in refusal(fly(text))


def test_a_missing_file_is_refused(tmp_path):
    assert "there is no such file" in refusal(tmp_path / "absent.toml")


def test_a_folder_is_refused(tmp_path):
    assert "is a folder" in refusal(tmp_path)


def test_an_empty_file_is_refused(fly):
    assert "is empty" in refusal(fly(" \n"))


@pytest.mark.parametrize("data", [b"[fly]\nname = '\xff'", b"\x00\x01\x02", "[fly]".encode("utf-16")])
def test_a_binary_file_is_refused(tmp_path, data):
    path = tmp_path / "binary.toml"
    path.write_bytes(data)
    sentence = refusal(path)
    assert "UTF-8" in sentence


def test_a_file_below_a_file_is_refused(fly):
    assert "cannot be read" in refusal(fly("[fly]") / "fly.toml")


def reads_or_refuses(path):
    try:
        return bool(read_parameters(path).name)
    except InvalidInputError as error:
        return "any.toml" in str(error)


@given(st.binary(max_size=60))
def test_no_bytes_crash_the_reader(tmp_path_factory, data):
    path = tmp_path_factory.getbasetemp() / "any.toml"
    path.write_bytes(data)
    assert reads_or_refuses(path)


json_values = st.recursive(
    st.none() | st.booleans() | st.floats() | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=2),
    max_leaves=3,
)


@given(st.sampled_from(["fly", "controller", "pulse", "morphology", "other"]), st.text(max_size=8), json_values)
def test_no_toml_crashes_the_reader(tmp_path_factory, table, key, value):
    path = tmp_path_factory.getbasetemp() / "any.toml"
    quoted = key.encode("unicode_escape").decode().replace('"', "")
    path.write_text(f"[{table}]\n'{quoted}' = {value!r}\ninertia = 'x'", encoding="utf-8", errors="replace")
    with pytest.raises(InvalidInputError, match=r"any\.toml"):
        read_parameters(path)


def test_morphology_is_read_in_si_units():
    table = read_morphology_table()
    assert table["mass"] == pytest.approx(1.1e-6, rel=1e-15)
    assert table["wing_length"] == pytest.approx(2.4e-3, rel=1e-15)
    assert table["right_hinge"] == pytest.approx((0.22e-3, 0.465e-3, -0.375e-3), rel=1e-15)


def test_a_fly_without_morphology_takes_the_default_flys_whole_and_says_so(fly):
    path = fly('[fly]\nname = "mine"')
    assert read_morphology_table(path) == read_morphology_table()
    assert "morphology" in read_parameters(path).defaulted


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("mass = 1.1", "morphology.mass is 1.1, without a unit"),
        ('right_hinge = "0.2 mm"', "a list of three values is needed"),
        ('right_hinge = ["0.2 mm", "0.4 mm"]', "a list of three values is needed"),
        ('right_hinge = ["0.2 mm", "0.4 mm", "1 mg"]', "a mass; a length"),
        ('second_moment_radius = "0.58 mm"', "a number without unit such as 0.58 is needed"),
        ("wing_legnth = 3", "the nearest known key is morphology.wing_length"),
    ],
)
def test_a_fault_in_the_morphology_is_refused(fly, line, said):
    text = f"[morphology]\n{line}\n"
    for name, value in (("mass", '"1 mg"'), ("wing_length", '"2 mm"'), ("wing_length_over_mean_chord", "3.3")):
        text += "" if line.startswith(f"{name} ") else f"{name} = {value}\n"
    with pytest.raises(InvalidInputError) as error:
        read_morphology_table(fly(text))
    assert said in str(error.value)


def test_the_larger_fly_is_the_default_one_with_time_scaled_by_the_wingbeat():
    default, larger = read_parameters(), read_parameters("drosophila_hydei")
    slower = larger.wingbeat_frequency.value / default.wingbeat_frequency.value
    assert larger.damping_rate == pytest.approx(default.damping_rate * slower, rel=1e-3)  # printed with four digits
    assert larger.proportional_gain.value == pytest.approx(default.proportional_gain.value * slower**2, rel=1e-3)
    assert larger.derivative_gain.value == pytest.approx(default.derivative_gain.value * slower, rel=1e-3)
    assert larger.delay_in_wingbeats == pytest.approx(default.delay_in_wingbeats, rel=1e-4)
    assert larger.damping_low.value == pytest.approx(default.damping_low.value * slower, rel=1e-2)  # without decimals
    assert larger.damping_high.value == pytest.approx(default.damping_high.value * slower, rel=1e-2)


def test_the_yaw_inertia_of_the_larger_fly_follows_from_its_morphology():
    larger, body = read_parameters("drosophila_hydei"), read_morphology_table("drosophila_hydei")
    scale = body["mass"] * 9.81 * body["wing_length"] / larger.wingbeat_frequency.value**2
    assert larger.inertia.value == pytest.approx(body["stroke_plane_inertia_over_mgr_per_f2"][2] * scale, rel=1e-3)


@pytest.mark.parametrize("name", shipped_parameters())
def test_every_shipped_source_is_in_the_bibliography(name):

    assert set(re.findall(r'source = "(\w+)"', parameter_text(name))) <= set(references())
