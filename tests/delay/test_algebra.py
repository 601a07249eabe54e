import operator

import control
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from random_systems import drawn_alike, random_points, random_system

from flycontrol.delay import delay, delay_lti, feedback, is_retarded, pade, rightmost_roots, series, static_gain
from flycontrol.errors import InvalidParameterError, NeutralSystemError, UnstableSystemError

seeds = st.integers(0, 2**32 - 1)
POINTS = random_points(11)


def direct(seed, inputs, outputs, delays=2):
    """A random system with a direct path too; with a chain of delays if there are two or more."""
    fed = random_system(seed, 2, delays, inputs, outputs, chained=True)
    return fed + np.random.default_rng(seed).normal(size=(outputs, inputs))


def same(system, transfer, scale=None):
    value = system(POINTS)
    assert value.shape == transfer.shape
    scale = np.abs(transfer).max(initial=0.0) if scale is None else scale
    np.testing.assert_allclose(value, transfer, rtol=1e-8, atol=1e-9 * scale)


def a_system(rng, s):
    system = random_system(rng.integers(2**32), rng.integers(0, 3), rng.integers(0, 4), chained=True)
    return system, system(s)


def a_square_system(rng, s):
    system = random_system(rng.integers(2**32), rng.integers(0, 3), rng.integers(0, 4), 2, 2, chained=True)
    return system, system(s)


def a_delay(rng, s):
    time = rng.uniform()
    return delay(time), np.exp(-time * s)[:, None, None]


def a_vector_of_delays(rng, s):
    times = rng.uniform(size=2)
    return delay(times), np.exp(-times * s[:, None, None]) * np.eye(2)


def a_number(rng, s):
    number = rng.choice([float, np.float64])(rng.normal())
    return number, np.full((len(s), 1, 1), number)


def a_matrix(rng, s):
    matrix = rng.normal(size=(2, 2))
    return matrix, np.broadcast_to(matrix, (len(s), 2, 2))


def a_transfer_function(rng, s):
    numerator, denominator = rng.normal(size=2), np.append(1.0, rng.uniform(0.5, 2.0, size=2))
    value = np.polyval(numerator, s) / np.polyval(denominator, s)
    return control.tf(numerator, denominator), value[:, None, None]


def a_state_space(rng, s):
    A, B, C, D = rng.normal(size=(4, 2, 2))
    through = np.linalg.inv(s[:, None, None] * np.eye(2) - A)
    return control.ss(A, B, C, D), C @ through @ B + D


KINDS = (
    a_system, a_square_system, a_delay, a_vector_of_delays, a_number, a_matrix, a_transfer_function, a_state_space
)  # fmt: skip


def operand(kind, seed):
    """An operand and its transfer matrix at POINTS, without any arithmetic of delay systems."""
    return kind(np.random.default_rng(seed), POINTS)


def on_paper(sign, left, right):
    """+, -, * of transfer matrices; one by one they apply to every entry of the other."""
    if sign != "*":
        return left + right if sign == "+" else left - right
    return left * right if 1 in (left.shape[-1], right.shape[-1]) else left @ right


OPERATORS = {"+": operator.add, "-": operator.sub, "*": operator.mul}
terms = st.lists(st.tuples(st.sampled_from("+-*"), st.sampled_from(KINDS), seeds, st.booleans()), max_size=4)


@drawn_alike
@given(seeds, terms)
def test_an_expression_of_systems_is_the_expression_of_their_transfer_matrices(seed, steps):
    """Operands of every kind on either side."""
    system, transfer = operand(a_system, seed)
    size = np.abs(transfer).max()
    for sign, kind, other_seed, on_the_left in steps:
        other, value = operand(kind, other_seed)
        pair, values = ((other, system), (value, transfer)) if on_the_left else ((system, other), (transfer, value))
        system, transfer = OPERATORS[sign](*pair), on_paper(sign, *values)
        large = np.abs(value).max()
        size = 2 * size * large if sign == "*" else size + large
    same(system, transfer, size)


@pytest.mark.parametrize("kind", KINDS)
def test_every_operand_stands_on_either_side_of_every_operator(kind):
    system = direct(1, 2, 2)
    transfer = system(POINTS)
    other, value = operand(kind, 7)
    for sign, apply in OPERATORS.items():
        same(apply(system, other), on_paper(sign, transfer, value))
        same(apply(other, system), on_paper(sign, value, transfer))


@pytest.mark.parametrize("kind", [kind for kind in KINDS if kind is not a_transfer_function])
def test_every_operand_but_a_transfer_function_divides_by_a_delay_system(kind):
    system = np.eye(2) + 0.3 * direct(1, 2, 2)
    other, value = operand(kind, 7)
    same(other / system, on_paper("*", value, np.linalg.inv(system(POINTS))))


def test_python_control_itself_refuses_to_divide_a_transfer_function_by_a_delay_system():
    with pytest.raises(TypeError, match="convert"):
        control.tf([1.0], [1.0, 2.0]) / (1 + delay(0.1))


@drawn_alike
@given(seeds, seeds, seeds)
def test_products_are_associative_and_distribute_over_sums(one, two, three):
    F, G, H = direct(one, 2, 3), direct(two, 3, 2), direct(three, 3, 2)
    same((F * G) * F, (F * (G * F))(POINTS))
    same(F * (G + H), (F * G + F * H)(POINTS))
    same((G + H) * F, (G * F + H * F)(POINTS))


@drawn_alike
@given(seeds, seeds)
def test_division_multiplies_by_the_inverse(one, two):
    G, H = direct(one, 2, 3), direct(two, 2, 2)
    same(G / H, G(POINTS) @ np.linalg.inv(H(POINTS)))
    same(np.eye(2) / H, np.linalg.inv(H(POINTS)))
    same(H / H, np.broadcast_to(np.eye(2) + 0j, (len(POINTS), 2, 2)), scale=1e2)


@drawn_alike
@given(seeds, seeds)
def test_feedback_is_the_forward_path_over_one_plus_the_loop(one, two):
    G, H = random_system(one), random_system(two)
    same(feedback(G, H), (G / (1 + G * H))(POINTS))
    same(feedback(1, G), (1 / (1 + G))(POINTS))
    same(G.feedback(H, sign=1), feedback(G, -H)(POINTS))
    same(1 - G.feedback(), (1 / (1 + G))(POINTS))


@drawn_alike
@given(seeds, st.integers(1, 8))
def test_the_pade_approximant_of_a_composition_is_the_composition_of_approximants(seed, order):
    """The operators only rearrange delays, and merging them changes nothing."""
    F, G = random_system(seed, 2, 2, 2, 2, chained=True), random_system(seed + 1, 2, 1, 2, 2)
    D, R = delay(0.3), pade(delay(0.3), order)
    f, g = pade(F, order), pade(G, order)
    same(pade((2 * F * D + G) * D - F * D, order), ((2 * f * R + g) * R - f * R)(POINTS))


def test_a_loop_reads_as_on_paper():
    """P exp(-0.013 s) with P of python-control, on either side."""
    P = control.tf([900.0], [1.0, 20.0, 0.0])
    expected = (P(POINTS) * np.exp(-0.013 * POINTS))[:, None, None]
    same(P * delay(0.013), expected)
    same(delay(0.013) * P, expected)
    same(control.ss(P) * delay(0.013), expected)


def test_a_state_space_of_python_control_divides_by_a_delay_system():
    P = control.ss(control.tf([900.0], [1.0, 20.0]))
    loop = 1 + 0.5 * delay(0.013) * P
    same(P / loop, (P(POINTS) / (1 + 0.5 * np.exp(-0.013 * POINTS) * P(POINTS)))[:, None, None])


def test_a_vector_of_delays_delays_each_input_by_its_own():
    both = delay([0.1, 0.0, 0.2])
    assert both.n_delays == 2
    same(both, np.exp(-POINTS[:, None, None] * [0.1, 0.0, 0.2]) * np.eye(3))
    np.testing.assert_array_equal(both.dcgain(), np.eye(3))


@pytest.mark.parametrize("wrong", [[0.1, -0.1], [0.1, np.nan], [[0.1]], "0.1", None])
def test_a_vector_with_an_impossible_delay_is_refused(wrong):
    with pytest.raises(InvalidParameterError, match="must be >= 0 s and finite"):
        delay(wrong)


@pytest.mark.parametrize("system", [static_gain(2.0), delay(0.1), delay(0.0), random_system(3, 0, 2), delay([])])
def test_systems_without_states_or_delays_or_signals_take_part_in_everything(system):
    m = system.n_inputs
    transfer = system(POINTS)
    same(2 * system + system - system * 3, np.zeros_like(transfer), scale=1.0)
    same(feedback(0.3 * system, np.eye(m)), transfer * 0.3 @ np.linalg.inv(np.eye(m) + 0.3 * transfer))
    same(series(system, delay([0.2] * m)), transfer * np.exp(-0.2 * POINTS)[:, None, None])
    assert pade(system, 3).n_delays == 0


def test_the_dc_gain_is_the_transfer_matrix_at_rest():
    G = random_system(5, 3, 2, 2, 3)
    np.testing.assert_allclose(G.dcgain(), G(1e-9).real, rtol=1e-6)
    np.testing.assert_allclose((control.tf([3.0], [1.0, 2.0]) * delay(1.0)).dcgain(), [[1.5]], rtol=1e-15)


def test_an_integrator_has_no_dc_gain():
    with pytest.raises(UnstableSystemError, match="integrator"):
        (control.tf([1.0], [1.0, 2.0, 0.0]) * delay(1.0)).dcgain()
    with pytest.raises(InvalidParameterError, match="infinite at a root"):
        (control.tf([1.0], [1.0, 2.0, 0.0]) * delay(1.0))(0.0)


def test_a_delayed_direct_path_around_a_loop_makes_it_neutral_and_a_state_in_it_retarded():
    P, D = control.tf([1.0], [1.0, 2.0]), delay(0.5)
    assert is_retarded(1 / (1 + P * D))
    assert is_retarded(feedback(D, P))
    neutral = feedback(0.5 * D)
    assert not is_retarded(neutral)
    assert not is_retarded(1 / (1 + 0.5 * D))
    same(neutral, (0.5 / (np.exp(0.5 * POINTS) + 0.5))[:, None, None])
    with pytest.raises(NeutralSystemError, match="without passing a state"):
        rightmost_roots(neutral * P)


@pytest.mark.parametrize("divisor", [delay(0.1), random_system(1), random_system(1, inputs=2, outputs=3)])
def test_division_by_what_has_no_invertible_direct_path_is_refused_with_the_way_out(divisor):
    with pytest.raises(InvalidParameterError, match=r"invertible undelayed direct path.*write feedback\(G, H\)"):
        1 / divisor


def test_units_do_not_make_a_direct_path_singular():
    """D11 with entries 1e-13 and 1e12, as torques beside accelerations have, is as regular as the identity."""
    H = np.diag([1e-13, 1e12]) + np.diag([1e-13, 1e12]) * delay([0.1, 0.2])
    same(1 / H, np.linalg.inv(H(POINTS)))


def test_operands_of_wrong_shape_are_refused_with_both_shapes():
    G, H = random_system(1, inputs=2, outputs=3), random_system(2, inputs=2, outputs=2)
    with pytest.raises(InvalidParameterError, match=r"one shape.*\(3, 2\) and \(2, 2\)"):
        G + H
    with pytest.raises(InvalidParameterError, match=r"\(3, 2\) and \(2, 2\)"):
        H * G
    with pytest.raises(InvalidParameterError, match=r"\(3, 2\) and \(5, 4\)"):
        np.ones((5, 4)) * G


@pytest.mark.parametrize("stranger", ["2", [1.0], None, 1j, np.ones(2), np.ones((1, 1, 1))])
def test_strangers_are_refused_on_either_side(stranger):
    for apply in (operator.add, operator.mul, operator.truediv):
        with pytest.raises(InvalidParameterError, match=r"combines with|real number"):
            apply(delay(0.1), stranger)
        with pytest.raises(InvalidParameterError, match=r"combines with|real number|invertible"):
            apply(stranger, delay(0.1))


def test_names_must_be_as_many_as_signals_and_distinct():
    blocks = {"A": [[1.0]], "B1": [[1.0, 1.0]], "C1": [[1.0]]}
    plain = delay_lti(**blocks)
    assert plain.input_names == plain.output_names == ()
    fields = [getattr(plain, block) for block in ("A", "B1", "B2", "C1", "C2", "D11", "D12", "D21", "D22", "tau")]
    assert type(plain)(*fields, ("u", "d"), ("y",), "P").name == "P"
    for names in (("u",), ("u", "u"), ["u", "d"], ("u", "")):
        with pytest.raises(InvalidParameterError, match="input_names must be 2 distinct names"):
            type(plain)(*fields, names)


@pytest.mark.parametrize(
    ("system", "words"),
    [
        (static_gain(np.ones((2, 3))), "<DelayLTI: 0 states, 3 inputs, 2 outputs, no delay>"),
        (delay(0.0136), "<DelayLTI: 0 states, 1 input, 1 output, delay 13.6 ms>"),
        (delay([1.5, 25e-6]), "<DelayLTI: 0 states, 2 inputs, 2 outputs, 2 delays 1.5 s, 25 us>"),
        (delay([0.3, 0.1, 0.2, 0.5, 0.4]), "<DelayLTI: 0 states, 5 inputs, 5 outputs, 5 delays 100 ms .. 500 ms>"),
    ],
)
def test_a_system_says_its_sizes_and_its_delays_with_units(system, words):
    assert repr(system) == words
