"""Onset and strength of a pulse that nobody recorded."""

import numpy as np
import pytest

from flycontrol.errors import InvalidParameterError
from flycontrol.identify.gains.fit import fit_gains
from flycontrol.identify.gains.model import gain_model
from flycontrol.identify.gains.onset import with_located_pulses
from flycontrol.identify.gains.response import yaw_response
from flycontrol.model.trial import Pulse, Trial
from flycontrol.units import deg

TRUTH = {"kp": 3050.0, "kd": 45.0, "delay": 0.0136, "damping": 69.0}
TIMES = np.arange(1201) / 8000


@pytest.mark.parametrize(("onset", "impulse"), [(0.021, 35.0), (0.0503, -12.0), (0.0712, 20.0)])
def test_an_unknown_pulse_is_found_with_its_strength(onset, impulse):
    pulse = Pulse(onset=onset, duration=0.0045)
    clean = yaw_response(TRUTH | {"impulse": impulse}, TIMES, pulse).yaw
    noise = 0.3 * deg * np.random.default_rng(1).standard_normal(1201)
    trial = Trial(name="fly", time=TIMES, yaw=clean + noise, rate=8000.0, perturbation=None)
    located = with_located_pulses([trial], 0.0045)
    assert abs(located[0].perturbation.onset - onset) < 2e-3
    found = fit_gains(located, gain_model(fixed={"initial_yaw": 0, "initial_rate": 0}, estimate=["onset_shift"]))
    shift = found["onset_shift[fly]"]
    assert abs(located[0].perturbation.onset + shift.value - onset) < 4 * shift.standard_error < 2e-3
    assert abs(found["impulse[fly]"].value - impulse) < 4 * found["impulse[fly]"].standard_error
    assert abs(found["delay"].value - 0.0136) < 4 * found["delay"].standard_error


def test_known_perturbations_stay_as_they_are_and_a_senseless_duration_is_refused():
    known = Trial(
        name="fly", time=TIMES, yaw=np.sin(30 * TIMES), rate=8000.0, perturbation=Pulse(onset=0.02, duration=0.004)
    )  # fmt: skip
    assert with_located_pulses([known])[0] is known
    with pytest.raises(InvalidParameterError, match="duration of a pulse must be > 0 s"):
        with_located_pulses([known], 0.0)
