import pytest

from flycontrol.model.equations import hinge_torque, hinge_transmission


def test_a_hinge_at_rest_at_its_rest_angle_exerts_no_torque():
    assert hinge_torque(2e-9, 1e-12, pitch=1.3, rest_angle=1.3, pitch_rate=0.0) == 0.0


def test_the_hinge_pulls_back_to_its_rest_angle_and_brakes_the_flip():
    assert hinge_torque(2e-9, 0.0, pitch=1.4, rest_angle=1.3, pitch_rate=0.0) == pytest.approx(-2e-10)
    assert hinge_torque(0.0, 1e-12, pitch=1.4, rest_angle=1.3, pitch_rate=500.0) == pytest.approx(-5e-10)


def test_a_bias_of_ten_degrees_paddles_by_six_with_the_reviews_mu():
    assert hinge_transmission(0.6, 10.0) == pytest.approx(6.0)
