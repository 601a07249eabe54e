import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from flycontrol.errors import InvalidInputError, InvalidParameterError
from flycontrol.model.morphology import drosophila_hydei, pitch_rotation, slender_inertia
from flycontrol.model.recording import WingAngles
from flycontrol.model.stroke import attack_angle, derivative, wing_axes
from flycontrol.units import deg

angle = st.floats(-1.4, 1.4)


def one(stroke: float, deviation: float, pitch: float) -> WingAngles:
    return WingAngles(stroke=np.array([stroke]), deviation=np.array([deviation]), pitch=np.array([pitch]))


@given(angle, angle, st.floats(0.0, 3.1), st.sampled_from(["left", "right"]))
def test_the_wings_axes_are_orthonormal(stroke, deviation, pitch, side):
    axes = wing_axes(one(stroke, deviation, pitch), side)
    frame = np.stack([axes.span[0], axes.chord[0], axes.normal[0]])
    np.testing.assert_allclose(frame @ frame.T, np.eye(3), atol=1e-14)


@given(angle, angle, st.floats(0.0, 3.1))
def test_the_left_wing_is_the_mirror_image_of_the_right(stroke, deviation, pitch):
    left, right = (wing_axes(one(stroke, deviation, pitch), side) for side in ("left", "right"))
    np.testing.assert_allclose(left.span, right.span * [1, -1, 1], atol=1e-15)
    np.testing.assert_allclose(left.chord, right.chord * [1, -1, 1], atol=1e-15)


def test_a_swept_forward_raised_wing_points_forward_and_up():
    span = wing_axes(one(30 * deg, 20 * deg, 90 * deg), "right").span[0]
    assert span[0] > 0
    assert span[1] > 0
    assert span[2] < 0  # z is down


def test_a_pitch_of_45_deg_attacks_at_45_deg_on_both_half_strokes():
    pitch = np.array([45.0, 135.0]) * deg
    np.testing.assert_allclose(attack_angle(pitch, np.array([1.0, -1.0])), 45 * deg, rtol=1e-15)


def test_the_derivative_is_exact_for_polynomials_of_degree_four_edges_included():
    x = np.linspace(0, 1, 11)
    np.testing.assert_allclose(derivative(x**4 - x**2, 10.0), 4 * x**3 - 2 * x, atol=1e-12)


def test_the_derivatives_error_at_a_third_of_the_wingbeats_samples_is_as_its_docstring_says():
    step = 2 * np.pi * 3 / 40
    t = np.arange(400)
    error = np.max(np.abs(derivative(np.sin(step * t), 1.0)[2:-2] - step * np.cos(step * t[2:-2]))) / step
    assert error == pytest.approx(step**4 / 30, rel=0.1)


def test_too_short_a_channel_has_no_rate():
    with pytest.raises(InvalidInputError, match="at least 5 samples"):
        derivative(np.zeros(4), 1.0)


def test_the_long_axis_of_a_slender_body_carries_its_smallest_moment():
    inertia = np.array(slender_inertia(0.64, 1.07, 0.57))
    moments, axes = np.linalg.eigh(inertia)
    np.testing.assert_allclose(moments, [0.14, 1.07, 1.07], atol=1e-12)
    nose = axes[:, 0] * np.sign(axes[0, 0])
    assert nose[2] < 0  # nose up
    assert np.degrees(np.arctan2(-nose[2], nose[0])) == pytest.approx(47.2, abs=0.1)


def test_the_stroke_plane_frame_is_nose_down_from_the_body():
    nose_S = pitch_rotation(drosophila_hydei().stroke_plane_angle) @ [1.0, 0.0, 0.0]
    np.testing.assert_allclose(nose_S, [np.cos(55 * deg), 0.0, -np.sin(55 * deg)], atol=1e-15)


def test_impossible_inertias_are_refused():
    with pytest.raises(InvalidParameterError, match="slender body"):
        slender_inertia(2.0, 1.0, 0.5)
