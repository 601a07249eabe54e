from dataclasses import replace

import numpy as np
import pytest

from flycontrol.errors import InvalidInputError, InvalidParameterError
from flycontrol.model.stroke_kinematics import StrokeKinematics, hover_stroke
from flycontrol.model.wing_stroke import (
    BermanWangStroke,
    FourierStroke,
    ModulatedStroke,
    Modulation,
    SampledStroke,
    fourier_stroke,
    paddling,
)
from flycontrol.units import deg

SHAPED = BermanWangStroke(
    stroke_amplitude=70 * deg,
    stroke_shape=0.8,
    stroke_offset=0.1,
    pitch_shape=2.5,
    pitch_lead=0.2,
    pitch_offset=0.05,
    deviation_amplitude=0.1,
    deviation_phase=0.6,
    deviation_offset=-0.02,
)
PHASE = np.linspace(0.0, 1.0, 201)
SAMPLED = SampledStroke(phase=PHASE, samples=SHAPED(PHASE).angles)
HARMONIC = fourier_stroke(PHASE[:-1], SHAPED(PHASE[:-1]).angles, 20)
RAMPED = ModulatedStroke(
    stroke=SHAPED,
    before=Modulation(pitch_offset=0.02),
    after=Modulation(stroke_gain=0.1, stroke_offset=-0.1, deviation_offset=0.03, pitch_offset=-0.05),
    ramp=(0.3, 1.4),
)


@pytest.mark.parametrize("stroke", [SHAPED, HARMONIC, SAMPLED, RAMPED], ids=["shaped", "fourier", "sampled", "ramped"])
def test_first_and_second_derivatives_are_those_of_the_angles(stroke):
    """Sixth-order central differences."""
    p, h = np.linspace(0.05, 1.95, 97), 1e-3
    weights = {1: 45, 2: -9, 3: 1}

    def slope(name):
        ahead, behind = ({k: getattr(stroke(p + way * k * h), name) for k in weights} for way in (1, -1))
        return sum(weight * (ahead[k] - behind[k]) for k, weight in weights.items())

    at = stroke(p)
    np.testing.assert_allclose(slope("angles") / (60 * h), at.first, atol=1e-6 * np.max(np.abs(at.first)))
    np.testing.assert_allclose(slope("first") / (60 * h), at.second, atol=1e-4 * np.max(np.abs(at.second)))


def test_berman_and_wangs_stroke_starts_at_the_dorsal_reversal_and_goes_forward():
    at = SHAPED(np.array([0.0, 0.25, 0.5]))
    np.testing.assert_allclose(at.angles[:, 0] - 0.1, [-70 * deg, 0.0, 70 * deg], atol=1e-12)
    assert at.first[1, 0] > 0
    np.testing.assert_allclose(at.first[[0, 2], 0], 0.0, atol=1e-12)
    upright = replace(SHAPED, pitch_lead=0.0, pitch_offset=0.0)(np.array([0.25, 0.75])).angles[:, 2]
    np.testing.assert_allclose(upright, [45 * deg, 135 * deg], atol=1e-12)  # attack 45 deg either way


def test_berman_and_wangs_shapes_run_from_cosine_to_triangle_and_from_sine_to_square():
    p = np.linspace(0.0, 1.0, 101)
    soft = BermanWangStroke(stroke_amplitude=1.0, stroke_shape=1e-4, pitch_amplitude=1.0, pitch_shape=1e-4)(p).angles
    np.testing.assert_allclose(soft[:, 0], -np.cos(2 * np.pi * p), atol=1e-8)
    np.testing.assert_allclose(soft[:, 2], np.pi / 2 - np.sin(2 * np.pi * p), atol=1e-8)
    sharp = BermanWangStroke(stroke_amplitude=1.0, stroke_shape=1 - 1e-9, pitch_amplitude=1.0, pitch_shape=500.0)
    hard = sharp(p).angles
    np.testing.assert_allclose(hard[:, 0], 1 - 4 * np.abs(p - 0.5), atol=1e-4)
    np.testing.assert_allclose(hard[1:50, 2], np.pi / 2 - 1, atol=1e-12)


def test_a_fourier_series_of_a_fourier_stroke_is_itself():
    rng = np.random.default_rng(0)
    cosine, sine = rng.normal(size=(3, 6)), rng.normal(size=(3, 6))
    sine[:, 0] = 0.0
    p = np.arange(40) / 40
    found = fourier_stroke(p, FourierStroke(cosine=cosine, sine=sine)(p).angles, 5)
    np.testing.assert_allclose(found.cosine, cosine, atol=1e-13)
    np.testing.assert_allclose(found.sine, sine, atol=1e-13)


def test_a_modulation_is_there_after_its_ramp_and_not_before():
    p = np.array([0.1, 0.29, 1.41, 1.9])
    plain, ramped = SHAPED(p), RAMPED(p)
    swing = plain.angles[2:, 0] - 0.1
    np.testing.assert_allclose(ramped.angles[:2] - plain.angles[:2], [[0.0, 0.0, 0.02]] * 2, atol=1e-14)
    change = np.stack([0.1 * swing - 0.1, np.full(2, 0.03), np.full(2, -0.05)], axis=1)
    np.testing.assert_allclose(ramped.angles[2:] - plain.angles[2:], change, atol=1e-12)


def test_paddling_adds_d_alpha_to_the_right_attack_angle_going_forward_and_takes_it_going_back():
    stroke = StrokeKinematics.symmetric(replace(SHAPED, pitch_lead=0.0, pitch_offset=0.0), 200.0)
    paddled = stroke.modulated(*paddling(3 * deg))
    mid = np.array([0.25, 0.75])
    left, right = (paddled.wing(side)(mid).angles[:, 2] for side in ("left", "right"))
    attack = np.array([[right[0], np.pi - right[1]], [left[0], np.pi - left[1]]])
    np.testing.assert_allclose(attack, np.array([[48, 42], [42, 48]]) * deg, atol=1e-12)


def test_rates_are_those_of_time():
    stroke = hover_stroke(200.0)
    motion, acceleration = stroke.motion(np.array([0.1]), "right")
    at = stroke.right(np.array([0.1]))
    assert motion.stroke_rate[0] == pytest.approx(200.0 * at.first[0, 0])
    assert acceleration[0, 2] == pytest.approx(200.0**2 * at.second[0, 2])


def test_what_is_no_stroke_is_refused():
    with pytest.raises(InvalidParameterError, match="stroke_shape"):
        BermanWangStroke(stroke_amplitude=1.0, stroke_shape=1.0)
    with pytest.raises(InvalidParameterError, match="frequency"):
        hover_stroke(float("nan"))
    with pytest.raises(InvalidInputError, match="end where it began"):
        SampledStroke(phase=PHASE, samples=np.linspace([0, 0, 0], [1, 0, 0], 201))
    with pytest.raises(InvalidInputError, match="was measured from"):
        SampledStroke(phase=PHASE, samples=SHAPED(PHASE).angles, periodic=False)(np.array([1.2]))
    with pytest.raises(InvalidInputError, match="need 41 samples"):
        fourier_stroke(PHASE[:30], SHAPED(PHASE[:30]).angles, 20)
