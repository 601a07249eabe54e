from dataclasses import replace

import pytest

from flycontrol.errors import InvalidParameterError
from flycontrol.model.parameters import CERTAINTIES, Parameters, Sourced


def sourced(value, unit="1"):
    return Sourced(value=value, unit=unit)


@pytest.fixture
def fly():
    return Parameters(
        name="a fly",
        inertia=sourced(3e-13),
        damping=sourced(21e-12),
        wingbeat_frequency=sourced(200.0),
        proportional_gain=sourced(-5.0),
        derivative_gain=sourced(0.0),
        delay=sourced(0.015),
        pulse_duration=sourced(0.005),
        pulse_peak=sourced(0.3),
        tolerance=sourced(0.03),
        deadline=sourced(0.06),
        damping_low=sourced(69.0),
        damping_high=sourced(176.0),
    )


def test_ratios_follow_from_the_numbers(fly):
    assert fly.damping_rate == pytest.approx(70, rel=1e-15)
    assert fly.delay_in_wingbeats == pytest.approx(3, rel=1e-15)


@pytest.mark.parametrize(
    ("name", "value"),
    [("inertia", 0.0), ("inertia", float("nan")), ("damping", -1.0), ("delay", -1e-3), ("delay", float("inf")),
     ("proportional_gain", float("nan")), ("derivative_gain", float("-inf")), ("tolerance", 0.0)],
)  # fmt: skip
def test_what_no_fly_can_have_is_refused(fly, name, value):
    with pytest.raises(InvalidParameterError, match=rf"Parameters\.{name} must be finite and"):
        replace(fly, **{name: sourced(value)})


def test_every_letter_of_certainty_is_explained():
    assert set(CERTAINTIES) == {"S", "S2", "C", "user", "fit", "fixed"}
