"""Mean loads by the body's motion: symmetry, weight, and what other parts of the package say of yaw."""

from dataclasses import replace

import numpy as np
import pytest
from hovering_fly import derivatives, floquet, trim
from simulated_fly import FLY, MELANOGASTER

from flycontrol.flight.body_coordinates import natural_scales
from flycontrol.flight.periodic_orbit import FINE
from flycontrol.flight.quasi_steady import QuasiSteadyModel
from flycontrol.flight.stroke_derivatives import stroke_derivatives
from flycontrol.flight.trim import tethered_trim
from flycontrol.flight.yaw_coefficients import yaw_coefficients
from flycontrol.model.stroke_kinematics import hover_stroke

LONGITUDINAL, LATERAL = [0, 2, 4], [1, 3, 5]


def test_a_symmetric_stroke_does_not_mix_longitudinal_and_lateral_motion():
    scales = natural_scales(FLY, trim().kinematics)[:6]
    matrix = derivatives().matrix * scales
    for rows, columns in ((LONGITUDINAL, LATERAL), (LATERAL, LONGITUDINAL)):
        largest = np.max(np.abs(matrix[rows]), axis=1, keepdims=True)
        assert np.max(np.abs(matrix[np.ix_(rows, columns)]) / largest) < 1e-12


def test_every_motion_is_damped_along_itself():
    assert np.all(np.diag(derivatives().matrix) < 0)


def test_yaw_damping_is_that_of_the_blade_elements_and_lies_where_it_was_published():
    """The same translational air by polynomials and by arctangents; other rates and instants see other kinks."""
    translating = replace(FLY, air=QuasiSteadyModel(terms=("translational",)))
    motion, _ = trim().kinematics.motion(np.arange(2000) / 2000, "right")
    blades = yaw_coefficients(MELANOGASTER, motion, np.zeros(3)).damping
    assert stroke_derivatives(translating, trim().kinematics).yaw_damping == pytest.approx(blades, rel=2e-5)
    assert 21e-12 < derivatives().yaw_damping < 54e-12


def test_held_at_rest_a_tethered_trim_carries_the_weight_and_tilts_it_with_the_body():
    found = stroke_derivatives(FLY, tethered_trim(FLY, hover_stroke()).kinematics)
    weight = MELANOGASTER.weight
    np.testing.assert_allclose(found.force / weight, [0.0, 0.0, -1.0], atol=1e-5)
    np.testing.assert_allclose(found.gravity[:3] / weight, [[0, -1], [1, 0], [0, 0]], atol=1e-6)


def test_the_mass_matrix_holds_the_fly_and_little_air():
    """Carried air weighs a thousandth of the fly; the mass matrix is symmetric."""
    inertia = derivatives().inertia
    np.testing.assert_allclose(np.diag(inertia)[:3], MELANOGASTER.mass, rtol=2e-3)
    assert np.all(np.diag(inertia)[:3] > MELANOGASTER.mass)
    np.testing.assert_allclose(inertia, inertia.T, rtol=1e-10, atol=1e-10 * inertia[5, 5])


def test_flight_averaged_at_rest_has_the_longitudinal_exponents_within_a_hundredth():
    """Lateral ones are farther off: their loads alternate between half strokes, and averaging loses that."""
    averaged = {mode.name: mode.exponent for mode in derivatives().modes}
    for mode in floquet().modes:
        if mode.name.startswith(("pitch", "vertical")):
            assert abs(averaged[mode.name] - mode.exponent) < 0.01 * abs(mode.exponent)


def test_the_stated_error_is_small_and_holds_a_finer_computation():
    finer = stroke_derivatives(FLY, trim().kinematics, settings=replace(FINE, steps=3200))
    scales = natural_scales(FLY, trim().kinematics)[:6]
    largest = np.max(np.abs(derivatives().matrix * scales), axis=1, keepdims=True)
    assert np.max(derivatives().error * scales / largest) < 2e-3
    apart = np.abs(finer.matrix - derivatives().matrix) * scales / largest
    assert np.all(apart < derivatives().error * scales / largest + 1e-6)
