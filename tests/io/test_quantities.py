import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from flycontrol.errors import InvalidInputError
from flycontrol.io.quantities import (
    ANGLE,
    ANGULAR_VELOCITY,
    DAMPING,
    FREQUENCY,
    INERTIA,
    KINDS,
    LENGTH,
    RATE_SQUARED,
    STIFFNESS,
    TIME,
    TORQUE,
    read_quantity,
    unit_factor,
)


@pytest.mark.parametrize(
    ("text", "kind", "value"),
    [
        ("13.6 ms", TIME, 13.6e-3),
        ("220 Hz", FREQUENCY, 220.0),
        ("3050 1/s^2", RATE_SQUARED, 3050.0),
        ("3050/s²", RATE_SQUARED, 3050.0),
        ("21 pN m s", DAMPING, 21e-12),
        ("21e-12 N*m*s", DAMPING, 21e-12),
        ("3.06e-13 kg·m²", INERTIA, 3.06e-13),
        ("20 deg", ANGLE, math.radians(20)),
        ("20°", ANGLE, math.radians(20)),
        ("60 rpm", ANGULAR_VELOCITY, 2 * math.pi),
        ("3 µm", LENGTH, 3e-6),
        ("3 μm", LENGTH, 3e-6),
    ],
)
def test_a_number_with_a_unit_is_converted_to_si(text, kind, value):
    # one multiplication by the unit's size: two roundings
    assert read_quantity(text, kind, key="x").value == pytest.approx(value, rel=4e-16)


@pytest.mark.parametrize("kind", KINDS)
def test_the_example_of_every_kind_is_of_that_kind(kind):
    example = kind.example if " " in kind.example else f"{kind.example} %"
    assert read_quantity(example, kind, key="x").kind is kind


@pytest.mark.parametrize("bare", [13.6, 13, "13.6"])
def test_a_bare_number_is_refused_with_the_key_and_an_example(bare):
    with pytest.raises(InvalidInputError, match=r'fly\.toml, line 3: controller\.delay is .*delay = "13(\.6)? ms"'):
        read_quantity(bare, TIME, key="controller.delay", where="fly.toml, line 3")


def test_a_wrong_dimension_is_named():
    with pytest.raises(InvalidInputError) as refusal:
        read_quantity("13.6 mm", TIME, key="delay")
    assert str(refusal.value) == "delay is '13.6 mm', a length; a time such as '13.6 ms' is needed."


def test_revolutions_a_minute_are_no_frequency():
    with pytest.raises(InvalidInputError, match="an angular velocity; a frequency such as '220 Hz' is needed"):
        read_quantity("13200 rpm", FREQUENCY, key="wingbeat_frequency")


def test_a_torque_is_no_torque_per_angle():
    with pytest.raises(InvalidInputError, match="a torque; a torque per angle"):
        read_quantity("9e-10 N m", STIFFNESS, key="gain")
    assert read_quantity("9e-10 N m", STIFFNESS, TORQUE, key="gain").kind is TORQUE


@pytest.mark.parametrize(
    "text",
    ["", "ms", "13,6 ms", "nan ms", "inf ms", "1e999 ms", "5 foo", "5 ((", "5 m**", "5 s**99999", "5 __import__"],
)
def test_what_is_no_quantity_is_refused_in_a_sentence(text):
    with pytest.raises(InvalidInputError, match=r"a time such as .* is needed"):
        read_quantity(text, TIME, key="delay")


@pytest.mark.parametrize("entry", [None, True, [], {}, ["13.6 ms"]])
def test_what_is_no_string_is_refused(entry):
    with pytest.raises(InvalidInputError, match="delay"):
        read_quantity(entry, TIME, key="delay")


def value_or_refusal(read):
    try:
        return math.isfinite(read())
    except InvalidInputError as refusal:
        return " is " in str(refusal)


@given(st.text(max_size=30))
def test_no_text_crashes_the_reader(text):
    assert value_or_refusal(lambda: read_quantity(text, TIME, key="delay").value)


@given(st.text(alphabet="smkgNradHz*/^()°²0123456789. -", max_size=12))
def test_no_text_made_of_units_crashes_the_reader(unit):
    assert value_or_refusal(lambda: unit_factor(unit, *KINDS, key="unit"))
