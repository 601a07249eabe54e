"""Real recordings without a known perturbation: read by their mappings alone, fitted, and not over-interpreted."""

import numpy as np
import pytest

from flycontrol.identify.gains.fit import fit_gains
from flycontrol.identify.gains.model import gain_model
from flycontrol.identify.gains.onset import with_located_pulses
from flycontrol.identify.gains.profile import profile
from flycontrol.identify.gains.ridge import blind_pair, ridge
from flycontrol.io.trials import read_trials

TAKE_OFFS = ("exp035c", "exp095c", "exp098c", "exp099c", "exp100c")


@pytest.mark.parametrize("name", TAKE_OFFS)
def test_a_take_off_is_too_short_to_say_anything_of_the_reflex(real_data, name):
    trials = read_trials([real_data / "fontaine_takeoff" / f"{name}.csv"], "fontaine_takeoff")
    found = fit_gains(trials)
    assert found.status.startswith("not identifiable: no perturbation is known")
    assert "too short for a reflex" in found.status
    assert np.isinf(found["kp"].low)
    assert np.isinf(found["delay"].high)
    located = fit_gains(with_located_pulses(trials), gain_model(estimate=["onset_shift"]))
    assert "too short for a reflex" in located.status


@pytest.mark.slow
@pytest.mark.parametrize("name", ["20121009_S0003", "20121120_S0001", "20121128_S0003"])
def test_spontaneous_yaw_does_not_tell_a_loop_from_its_disturbance(real_data, name):
    found = fit_gains(read_trials([real_data / "muijres_freeflight" / f"{name}.txt"], "muijres_freeflight"))
    assert found.status.startswith("not identifiable: no perturbation is known")
    assert all(np.isinf(found[kind].low) for kind in ("kp", "kd", "delay", "damping"))


@pytest.mark.slow
def test_in_spontaneous_yaw_delayed_and_undelayed_damping_make_up_for_each_other(real_data):
    trials = read_trials([real_data / "muijres_freeflight" / "20121128_S0003.txt"], "muijres_freeflight")
    found = fit_gains(trials)
    assert blind_pair(found.weighted, found.minimum) == ("kd", "damping")
    kd, damping = (profile(found.weighted, found.minimum, found.uncertainty, name) for name in ("kd", "damping"))
    valley = ridge(found.weighted, found.minimum, (kd, damping), side=9).valley
    assert np.ptp(valley[:, 0]) > 100  # [1/s], twice a fly's derivative gain
    assert np.corrcoef(valley.T)[0, 1] > 0.8
