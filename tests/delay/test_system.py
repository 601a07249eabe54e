import numpy as np
import pytest
from hypothesis import given
from random_systems import drawn_alike, random_points, random_system, random_systems

from flycontrol.delay.signals import named
from flycontrol.delay.spectrum import rightmost_roots
from flycontrol.delay.system import characteristic_matrix, delay_lti, is_retarded
from flycontrol.delay.timeresponse import step_response
from flycontrol.errors import InvalidParameterError


@drawn_alike
@given(random_systems(inputs=2, outputs=3, chained=True))
def test_the_transfer_matrix_is_the_linear_fractional_transformation_of_its_blocks(system):
    """G = P11 + P12 E (I - P22 E)^-1 P21 with P the undelayed part and E = diag exp(-s tau)."""
    s = complex(random_points(7, 1)[0])
    n, m, p = system.n_states, system.n_inputs, system.n_outputs
    through = np.linalg.inv(s * np.eye(n) - system.A)
    C, B = np.vstack([system.C1, system.C2]), np.hstack([system.B1, system.B2])
    P = C @ through @ B + np.block([[system.D11, system.D12], [system.D21, system.D22]])
    E = np.diag(np.exp(-s * system.tau))
    inner = np.linalg.inv(np.eye(system.n_delays) - P[p:, m:] @ E)
    expected = P[:p, :m] + P[:p, m:] @ E @ inner @ P[p:, :m]
    # the nested inverses here lose digits where the delayed loop is nearly singular
    np.testing.assert_allclose(system(s), expected, rtol=1e-8, atol=1e-10 * np.abs(expected).max())


@drawn_alike
@given(random_systems(chained=True))
def test_the_transfer_function_of_a_real_system_is_conjugate_symmetric(system):
    s = random_points(3)
    np.testing.assert_allclose(system(s.conj()), system(s).conj(), rtol=1e-10)


def test_the_characteristic_determinant_is_that_of_the_textbook():
    """det = s^2 + b s + (kd s + kp) exp(-s T) for PD control of a damped double integrator."""
    b, kp, kd, T = 20.0, 900.0, 55.0, 0.0136
    system = delay_lti(
        A=[[0, 1], [0, -b]], B1=[[0], [1]], B2=[[0], [-1]], C1=[[1, 0]], C2=[[kp, kd]], tau=[T]
    )  # fmt: skip
    s = 40 * random_points(5)
    expected = s**2 + b * s + (kd * s + kp) * np.exp(-s * T)
    np.testing.assert_allclose(np.linalg.det(characteristic_matrix(system, s)), expected, rtol=1e-12)


def test_a_transfer_matrix_keeps_the_shape_of_the_frequencies():
    system = random_system(1, 3, 2, inputs=2, outputs=3)
    s = random_points(1, 6).reshape(2, 3)
    assert system(s).shape == (2, 3, 3, 2)
    np.testing.assert_allclose(system(s)[1, 2], system(s[1, 2]), rtol=1e-13)


def test_a_chain_of_delays_is_retarded_and_a_ring_of_delays_is_neutral():
    chain = random_system(1, 2, 3, chained=True)
    assert is_retarded(chain)
    ring = delay_lti(
        A=[[-1.0]], B1=[[1.0]], C1=[[1.0]], D22=[[0.0, 0.5], [0.5, 0.0]], tau=[1.0, 2.0]
    )  # fmt: skip
    assert not is_retarded(ring)


@pytest.mark.parametrize(
    ("blocks", "sentence"),
    [
        ({"C1": [[1.0]]}, r"DelayLTI.C1 must have shape \(1, 2\).*got \(1, 1\)"),
        ({"B2": [[1.0]], "tau": [1.0]}, r"DelayLTI.B2 must have shape \(2, 1\).*got \(1, 1\)"),
        ({"A": [[1.0, np.nan], [0.0, 1.0]]}, "DelayLTI.A must be finite"),
        ({"tau": [0.0]}, "tau must be > 0 s"),
        ({"tau": [-0.1]}, "tau must be > 0 s"),
        ({"tau": [np.inf]}, "tau must be finite"),
    ],
)
def test_blocks_that_fit_no_system_are_refused_by_name_and_shape(blocks, sentence):
    fitting = {"A": np.zeros((2, 2)), "B1": [[0.0], [1.0]], "C1": [[1.0, 0.0]]}
    with pytest.raises(InvalidParameterError, match=sentence):
        delay_lti(**{**fitting, **blocks})


def test_blocks_cannot_be_changed_after_the_fact():
    with pytest.raises(ValueError, match="read-only"):
        random_system(1).A[0, 0] = 1.0


def test_a_part_of_a_system_is_that_entry_of_its_transfer_matrix():
    system = named(random_system(5, inputs=2, outputs=3), inputs=["a", "b"], outputs=["x", "y", "z"])
    s = random_points(6)
    for i in range(3):
        for j in range(2):
            np.testing.assert_allclose(system[i, j](s)[:, 0, 0], system(s)[:, i, j], rtol=1e-12, atol=1e-13)
    part = system[1:, -1]
    np.testing.assert_allclose(part(s), system(s)[:, 1:, 1:], rtol=1e-12, atol=1e-13)
    assert (part.input_names, part.output_names) == (("b",), ("y", "z"))
    for key in ((3, 0), (0, 2), 0, (0, "a")):
        with pytest.raises(InvalidParameterError, match=r"numbered from 0|sys\[outputs, inputs\]"):
            system[key]


def test_poles_are_the_rightmost_roots():
    system = random_system(3)
    np.testing.assert_array_equal(system.poles(4), rightmost_roots(system, 4).roots)


def test_long_results_have_short_reprs():
    system = random_system(3)
    stepped = step_response(system, 1.0)
    for shown in (stepped, stepped.exact[0]):
        assert len(repr(shown)) < 150
