"""Wingbeats laid over one another: the mean, its spread, and a stroke that repeats it."""

from dataclasses import replace

import numpy as np
import pytest

from flycontrol.errors import InvalidInputError
from flycontrol.model.collapsed_wingbeats import collapsed_wingbeats, wingbeats_between
from flycontrol.model.recording import Recording, WingAngles
from flycontrol.model.wing_stroke import BermanWangStroke, fourier_stroke
from flycontrol.model.wingbeats import segment_wingbeats
from flycontrol.units import deg

FREQUENCY, RATE = 190.0, 7500.0
SMOOTH = fourier_stroke(
    np.arange(200) / 200,
    BermanWangStroke(
        stroke_amplitude=70 * deg, stroke_shape=0.7, pitch_shape=2.0, pitch_lead=5 * deg, deviation_amplitude=8 * deg
    )(np.arange(200) / 200).angles,
    5,
)


def filmed(wingbeats: int = 30, paddling: float = 4 * deg, noise: float = 0.0, drift: float = 0.0) -> Recording:
    """Both wings, right pitch above left by twice the paddling angle; all angles rise by `drift` a wingbeat."""
    time = np.arange(round(wingbeats * RATE / FREQUENCY)) / RATE
    rng = np.random.default_rng(11)

    def wing(side: float) -> WingAngles:
        angles = SMOOTH(time * FREQUENCY).angles + noise * rng.normal(size=(len(time), 3))
        angles += (drift * FREQUENCY * (time - time.mean()))[:, None]
        return WingAngles(stroke=angles[:, 0], deviation=angles[:, 1], pitch=angles[:, 2] + side * paddling)

    return Recording(name="film", rate=RATE, time=time, source_sha256="", left=wing(-1.0), right=wing(1.0))


def test_wingbeats_that_are_alike_have_no_spread_and_their_mean_is_each_of_them():
    """A reversal that is off by 1 % of a sample moves the pitch, at its fastest 16 deg a sample, by 0.16 deg."""
    film = filmed()
    collapsed = collapsed_wingbeats(film, segment_wingbeats(film))
    expected = SMOOTH(collapsed.phase).angles
    for side, sign in (("left", -1), ("right", 1)):
        assert np.max(collapsed.spread(side)) < 0.16 * deg
        off = collapsed.mean(side) - expected - [0, 0, sign * 4 * deg]
        assert np.max(np.abs(off)) < 0.16 * deg


def test_the_asymmetry_of_pitch_is_the_paddling_angle():
    film = filmed(paddling=3 * deg)
    asymmetry = collapsed_wingbeats(film, segment_wingbeats(film)).asymmetry
    assert np.allclose(asymmetry, [0, 0, 3 * deg], rtol=0, atol=1e-9)


def test_white_noise_comes_back_as_spread():
    """A cubic spline between samples passes 0.6 to 1 of their variance; chi-squared of 29 wingbeats at 100 phases."""
    film = filmed(noise=2 * deg)
    collapsed = collapsed_wingbeats(film, segment_wingbeats(film))
    spread = np.sqrt(np.mean(collapsed.spread("left")[:, 1:] ** 2)) / deg
    assert 2 * np.sqrt(0.6) < spread < 2.1


def test_the_mean_stroke_is_the_stroke_that_was_filmed():
    film = filmed()
    stroke = collapsed_wingbeats(film, segment_wingbeats(film)).mean_stroke()
    phase = np.linspace(0, 1, 50)
    assert abs(stroke.frequency / FREQUENCY - 1) < 1e-4
    assert np.max(np.abs(stroke.right(phase).angles - SMOOTH(phase).angles - [0, 0, 4 * deg])) < 0.05 * deg
    assert np.max(np.abs(stroke.left(phase).first - SMOOTH(phase).first)) < 1e-3 * np.max(np.abs(SMOOTH(phase).first))


def test_drift_over_a_wingbeat_does_not_ripple_through_the_mean_stroke():
    """A drift of the deviation alone, which leaves reversals alone: a saw tooth of 2 deg would ring by 1 deg."""
    film, steady = filmed(drift=0.0), filmed()
    rising = 2 * deg * FREQUENCY * (film.time - film.time.mean())
    moved = replace(film, right=replace(film.right, deviation=film.right.deviation + rising))
    beats = segment_wingbeats(steady)
    collapsed = collapsed_wingbeats(moved, beats)
    phase = np.arange(100) / 100
    off = collapsed.mean_stroke().right(phase).angles[:, 1] - SMOOTH(phase).angles[:, 1]
    assert np.allclose(collapsed.right_drift[:, 1], 2 * deg, rtol=1e-3)
    assert np.ptp(off) < 0.05 * deg


def test_wingbeats_of_a_turn_are_counted_from_the_first_to_the_last():
    film = filmed()
    beats = segment_wingbeats(film)
    some = collapsed_wingbeats(film, wingbeats_between(beats, 3, 7))
    every = collapsed_wingbeats(film, beats)
    assert some.count == 5
    assert np.array_equal(some.left, every.drawn(np.arange(3, 8)).left)


def test_wingbeats_that_are_not_there_are_refused():
    beats = segment_wingbeats(filmed())
    with pytest.raises(InvalidInputError, match="not among 0 to"):
        wingbeats_between(beats, 3, 99)
