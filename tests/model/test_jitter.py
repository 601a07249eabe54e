"""Tracking noise from what wing angles do between wingbeats."""

from dataclasses import replace

import numpy as np
import pytest

from flycontrol.errors import InvalidInputError
from flycontrol.model.jitter import jittered, wingbeat_jitter
from flycontrol.model.recording import Recording, WingAngles
from flycontrol.model.wingbeats import Wingbeats

RATE, FREQUENCY, COUNT = 8000.0, 200.0, 400
TIME = np.arange(COUNT * 40 + 20) / RATE
BEATS = Wingbeats(reversals=np.arange(COUNT + 1) / FREQUENCY)
NOISE = 0.05


def flight(change) -> Recording:
    """Both wings beat alike; `change` (N,) is added to every angle."""
    swing = -1.2 * np.cos(2 * np.pi * FREQUENCY * TIME)
    wings = [
        WingAngles(stroke=swing + change(), deviation=0.1 * swing + change(), pitch=1.5 + 0.5 * swing + change())
        for _ in range(2)
    ]
    return Recording(name="made", rate=RATE, time=TIME, source_sha256="", left=wings[0], right=wings[1])


def test_white_noise_is_found_with_its_spread():
    """16,000 samples a channel, of which a third is independent: 1 % each way."""
    rng = np.random.default_rng(4)
    found = wingbeat_jitter(flight(lambda: NOISE * rng.standard_normal(len(TIME))), BEATS)
    np.testing.assert_allclose(found.spread, NOISE, rtol=0.02)


def test_a_steady_change_is_no_jitter():
    found = wingbeat_jitter(flight(lambda: 3.0 * TIME), BEATS)
    np.testing.assert_allclose(found.spread, 0.0, atol=1e-9)


def test_jitter_put_on_a_clean_flight_is_found_again_with_its_spread():
    rng = np.random.default_rng(5)
    drawn = wingbeat_jitter(flight(lambda: NOISE * rng.standard_normal(len(TIME))), BEATS)
    clean = flight(lambda: np.zeros_like(TIME))
    again = wingbeat_jitter(jittered(clean, BEATS, drawn, rng, scale=0.5), BEATS)
    np.testing.assert_allclose(again.spread, 0.5 * drawn.spread, rtol=0.03)
    np.testing.assert_array_equal(jittered(clean, BEATS, drawn, rng, scale=0.0).left.pitch, clean.left.pitch)


def test_wings_that_were_not_measured_have_no_jitter():
    with pytest.raises(InvalidInputError, match="both wings"):
        wingbeat_jitter(replace(flight(lambda: 0.0 * TIME), left=None), BEATS)
