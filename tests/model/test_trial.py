import dataclasses
import pickle

import numpy as np
import pytest

from flycontrol.errors import InvalidInputError, InvalidParameterError
from flycontrol.model.trial import Pulse, TorqueTrace, Trial

TIME = np.arange(5) / 100


def trial(**changes):
    given = {"name": "a", "time": TIME, "yaw": np.linspace(0, 0.1, 5), "rate": 100.0, "perturbation": None}
    return Trial(**given | changes)


def test_a_trial_belongs_to_a_fly_of_its_own_name_unless_one_is_given():
    assert trial().fly == "a"
    assert trial(fly="b").fly == "b"


def test_a_trial_s_arrays_are_its_own_and_read_only():
    yaw = np.linspace(0, 0.1, 5)
    kept = trial(yaw=yaw, paddling=yaw)
    yaw[0] = 7.0
    assert kept.yaw[0] == kept.paddling[0] == 0
    for array in (kept.time, kept.yaw, kept.paddling):
        assert not array.flags.writeable


def test_a_trial_travels_to_another_process_and_back():
    there = trial(perturbation=TorqueTrace(time=TIME, drive=TIME, unit="A"), notes={"k": "v"})
    back = pickle.loads(pickle.dumps(there))
    assert back.notes["k"] == "v"
    np.testing.assert_array_equal(back.perturbation.drive, TIME)
    assert dataclasses.replace(back, fly="b").fly == "b"


def test_missing_samples_and_gaps_are_allowed():
    gappy = trial(time=[0, 0.01, 0.02, 0.5, 0.51], yaw=[0, np.nan, 0.1, np.nan, 0.2])
    assert np.count_nonzero(np.isfinite(gappy.yaw)) == 3


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"name": ""}, "needs a name"),
        ({"rate": 0.0}, "sampling rate must be > 0"),
        ({"rate": np.nan}, "sampling rate must be > 0"),
        ({"yaw": np.zeros(4)}, r"yaw has the shape \(4,\) where time has \(5,\)"),
        ({"yaw": np.zeros((5, 1))}, r"yaw has the shape \(5, 1\)"),
        ({"yaw": [0, np.inf, 0, 0, 0]}, "yaw is infinite"),
        ({"yaw": [0, *[np.nan] * 4]}, "fewer than two samples"),
        ({"paddling": [0, -np.inf, 0, 0, 0]}, "paddling is infinite"),
        ({"time": [0, 0.01, 0.01, 0.02, 0.03]}, "time must increase, got 0.01 s after 0.01 s"),
        ({"time": [0, np.nan, 1, 2, 3]}, "finite numbers"),
        ({"time": 0.0}, "one dimension"),
    ],
)
def test_what_no_trial_can_be_is_refused(changes, said):
    with pytest.raises(InvalidInputError, match=said):
        trial(**changes)


@pytest.mark.parametrize(
    "wrong", [{"duration": 0.0}, {"duration": np.nan}, {"onset": np.inf}, {"angular_impulse": np.nan}]
)
def test_what_no_pulse_can_be_is_refused(wrong):
    with pytest.raises(InvalidParameterError, match=next(iter(wrong))):
        Pulse(**{"onset": 0.0, "duration": 5e-3} | wrong)


def test_what_no_torque_trace_can_be_is_refused():
    with pytest.raises(InvalidInputError, match="increase"):
        TorqueTrace(time=TIME[::-1], drive=TIME, unit="A")
    with pytest.raises(InvalidParameterError, match="finite"):
        TorqueTrace(time=TIME, drive=TIME * np.nan, unit="A")
    with pytest.raises(InvalidInputError, match="shape"):
        TorqueTrace(time=TIME, drive=TIME[1:], unit="A")
