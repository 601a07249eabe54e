import numpy as np
import pytest

from flycontrol.cli.fit_options import FitRequest, requested_model, requested_sharing
from flycontrol.errors import FlycontrolError
from flycontrol.identify.gains.model import Prior


def model(paddling=False, **asked):
    return requested_model(FitRequest(**asked), paddling=paddling)


def test_without_options_it_is_the_standard_pd_model():
    found = model()
    assert found.controller == "PD"
    assert found.known == {}
    assert found.unknown["delay"].low == 1e-3


def test_quantities_become_si_units_and_zero_needs_none():
    found = model(fix=["damping=69/s", "delay=13.6 ms", "initial_rate=0", "heading=-30 deg", "impulse=2000 deg/s"])
    assert found.known == pytest.approx(
        {"damping": 69, "delay": 0.0136, "initial_rate": 0, "heading": -np.pi / 6, "impulse": np.radians(2000)}
    )


@pytest.mark.parametrize(
    ("text", "low", "high"),
    [("5 ms .. 30 ms", 5e-3, 30e-3), ("5..30 ms", 5e-3, 30e-3), ("..30 ms", 1e-3, 30e-3), ("5ms..", 5e-3, 60e-3)],
)
def test_bounds_may_be_open_and_share_a_unit(text, low, high):
    found = model(bound=[f"delay={text}"]).unknown["delay"]
    assert (found.low, found.high) == pytest.approx((low, high))


@pytest.mark.parametrize("sign", ["+-", "±", "+/-"])
def test_a_prior_is_a_mean_and_a_deviation(sign):
    assert model(prior=[f"delay=14 {sign} 2 ms"]).unknown["delay"].prior == Prior(mean=0.014, deviation=0.002)


def test_gains_are_shared_and_impulses_never():
    found = model(controller="pid").unknown
    assert {found[name].shared for name in ("kp", "kd", "ki", "delay", "damping")} == {"all"}
    assert found["impulse"].shared == "trial"


def test_the_paddling_gain_is_estimated_where_paddling_was_measured():
    assert "paddling_gain" in model(paddling=True).unknown
    assert model(paddling=True, fix=["paddling_gain=4e4 1/s^2/rad"]).known["paddling_gain"] == 4e4


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        ({"controller": "LQR"}, "--controller must be one of P, PD, PI, PID, got 'LQR'."),
        ({"fix": ["damping"]}, '--fix needs NAME=VALUE such as damping="69 1/s", got "damping".'),
        ({"fix": ["gain=3 1/s"]}, "--fix names an unknown parameter, 'gain'"),
        ({"fix": ["damping=69"]}, "--fix: damping is '69', without a unit"),
        ({"fix": ["damping=69"]}, 'for example damping = "69 1/s"'),
        ({"fix": ["delay=13.6 m"]}, "--fix: delay is '13.6 m', a length"),
        ({"fix": ["kd=1/s", "kd=2/s"]}, "--fix is given twice for kd"),
        ({"fix": ["kd=40/s"], "estimate": ["kd"]}, "kd is both fixed and to be estimated"),
        ({"fix": ["delay=13 ms"], "bound": ["delay=5..30 ms"]}, "--bound is given for delay, but it is fixed"),
        ({"prior": ["limit=5 +- 1 1/s^2"]}, "--prior is given for limit, but it is not estimated"),
        ({"prior": ["damping=69"]}, 'such as "69 +- 5 1/s", got "69"'),
        ({"prior": ["damping=69 +- 0 1/s"]}, "--prior damping needs a deviation > 0"),
        ({"bound": ["delay=30 ms"]}, 'such as "5 ms .. 30 ms", got "30 ms"'),
        ({"bound": ["delay=30 ms .. 5 ms"]}, '--bound delay is "30 ms .. 5 ms", but the lower end must lie below'),
        ({"bound": ["delay=..0.5 ms"]}, '--bound delay is "..0.5 ms", but the lower end must lie below'),
        ({"controller": "P", "fix": ["ki=6e4 1/s^3"]}, "A P controller has no ki"),
        ({"shared": "none"}, "--shared must be auto, all, fly or trial, got 'none'."),
    ],
)
def test_what_makes_no_model_is_refused_in_a_sentence(asked, said):
    with pytest.raises(FlycontrolError) as error:
        requested_sharing(asked["shared"]) if "shared" in asked else model(**asked)
    assert said in str(error.value)
