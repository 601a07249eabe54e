"""Simulated recordings of one perturbed fly, of known truth and noise."""

import numpy as np
import scipy.signal

from flycontrol.identify.gains.response import yaw_response
from flycontrol.model.trial import Pulse, Trial
from flycontrol.units import deg

TRUTH = {"kp": 3050.0, "kd": 45.0, "delay": 0.0136, "damping": 69.0, "impulse": 35.0}
PULSE = Pulse(onset=0.01, duration=0.0045)
TIMES = np.arange(801) / 8000
AT_REST = {"initial_yaw": 0.0, "initial_rate": 0.0}


def recording(seed, *, noise=0.3, correlation=0.0, truth=TRUTH, name="fly", perturbation=PULSE):
    rng = np.random.default_rng(seed)
    innovations = rng.standard_normal(len(TIMES) + 1000)
    coloured = scipy.signal.lfilter([np.sqrt(1 - correlation**2)], [1, -correlation], innovations)[1000:]
    clean = yaw_response(truth, TIMES, perturbation).yaw
    return Trial(
        name=name, time=TIMES, yaw=clean + noise * deg * coloured, rate=8000.0, perturbation=perturbation
    )  # fmt: skip
