import control
import numpy as np
import pytest
import scipy.linalg
from hypothesis import given
from hypothesis import strategies as st
from random_systems import drawn_alike, random_points, random_system

from flycontrol.delay import delay, feedback, interconnect, named, static_gain, summing_junction, to_statespace
from flycontrol.errors import AlgebraicLoopError, InvalidParameterError

seeds = st.integers(0, 2**32 - 1)
POINTS = random_points(5)


def same(system, transfer):
    np.testing.assert_allclose(system(POINTS), transfer, rtol=1e-8, atol=1e-9 * np.abs(transfer).max())


def two_parts(seed, delays=2):
    """P with inputs u, d and outputs angle, rate; K with inputs e[0], e[1] and output u."""
    P = named(random_system(seed, 3, delays, 2, 2), inputs=["u", "d"], outputs=["angle", "rate"], name="P")
    K = named(random_system(seed + 1, 1, min(delays, 1), 2, 1), inputs="e", outputs="u", name="K")
    return P, K


def closed_by_hand(P, K, F, G, H):
    """u = F y + G v, y = blockdiag(P, K) u, reading H y, in complex numbers."""
    parts = np.array([scipy.linalg.block_diag(p, k) for p, k in zip(P(POINTS), K(POINTS), strict=True)])
    return H @ np.linalg.solve(np.eye(3) - parts @ F, parts @ G)


# u, d, e[0], e[1] from angle, rate, u
LOOP = np.array([[0.0, 0.0, 1.0], [0.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 2.0, 0.0]])


@drawn_alike
@given(seeds)
def test_connections_by_name_are_the_loop_solved_by_hand(seed):
    P, K = two_parts(seed)
    whole = interconnect(
        [P, K], [["P.u", "K.u"], ["K.e[0]", "-P.angle"], ["K.e[1]", ("P", "rate", 2.0)]], ["P.d"], ["P.angle", "K.u"]
    )
    G, H = np.eye(4)[:, [1]], np.eye(3)[[0, 2]]
    same(whole, closed_by_hand(P, K, LOOP, G, H))


@drawn_alike
@given(seeds)
def test_signals_of_one_name_find_each_other_and_equal_outputs_add_up(seed):
    P, K = two_parts(seed)
    junction = summing_junction(["r", "-angle"], "e[0]")
    double = named(static_gain(1.5), inputs="rate", outputs="e[1]")
    half = named(static_gain(0.5), inputs="rate", outputs="e[1]")
    whole = interconnect([P, half, K, junction, double], inputs=["r", "d"], outputs=["angle", "u"])
    assert (whole.input_names, whole.output_names) == (("r", "d"), ("angle", "u"))
    same(whole, closed_by_hand(P, K, LOOP, np.eye(4)[:, [2, 1]], np.eye(3)[[0, 2]]))


@drawn_alike
@given(seeds)
def test_without_delays_it_is_the_interconnection_of_python_control(seed):
    P, K = two_parts(seed, delays=0)
    theirs = [to_statespace(P), to_statespace(K)]
    connections = [["P.u", "K.u"], ["K.e", "-P"], ["P.d", ("K", 0, 0.5)]]
    for inplist, outlist in ((["K.e"], ["P"]), (["d", ["K.e[0]", "P.u"]], [["angle", "rate"], "-K.u", "P.d"])):
        expected = control.interconnect(theirs, connections, inplist, qualified(outlist), check_unused=False)
        ours = interconnect(theirs, connections, inplist, outlist)
        same(ours, np.moveaxis(expected(POINTS, squeeze=False), -1, 0))


def qualified(outlist):
    """python-control reads names in an inner list only with their system."""
    return [["P.angle", "P.rate"] if port == ["angle", "rate"] else port for port in outlist]


def test_the_loop_of_python_controls_manual_has_its_closed_form_with_a_delay_in_it():
    P = control.tf(1, [1, 0], inputs="u", outputs="y")
    C = control.tf(10, [1, 1], inputs="e", outputs="u")
    late = named(delay(0.1), inputs="y", outputs="seen")
    loop = interconnect([P, C, late, summing_junction(["r", "-seen"], "e")], inputs="r", outputs="y")
    L = control.tf([10], [1, 1, 0])
    same(loop, feedback(L, delay(0.1))(POINTS))


def test_the_same_junction_as_python_control():
    for arguments in ((["r", "-y", "d"], "e"), ("-u", "y"), (["r", "-y"], "e", 3)):
        ours, theirs = summing_junction(*arguments), control.summing_junction(*arguments)
        np.testing.assert_array_equal(ours.D11, theirs.D)
        assert (ours.input_names, ours.output_names) == (tuple(theirs.input_labels), tuple(theirs.output_labels))


@pytest.mark.parametrize(
    ("one", "other"),
    [
        ("P", 0),
        ("P.u", (0, [0, 1, 2])),
        ("P.u[1:]", ("P", ["u[1]", "u[2]"])),
        ("-P.u[0:2]", ("P", "u[:2]", -1.0)),
        ("u", "P.u"),
        (("-P", 2), ("P", "-u[2]")),
    ],
)
def test_a_signal_can_be_specified_in_many_ways(one, other):
    P = named(random_system(3, inputs=3), inputs="u", name="P")
    first, second = (interconnect([P], [], [spec], ["P"], check_unused=False) for spec in (one, other))
    np.testing.assert_array_equal(first.B1, second.B1)
    assert first.n_inputs >= 1


def test_a_base_name_among_the_inputs_gives_the_whole_its_full_names():
    P = named(random_system(3, inputs=2), inputs="u", outputs="y", name="P")
    whole = interconnect([P], inputs="u", outputs=["y"])
    assert (whole.input_names, whole.output_names) == (("u[0]", "u[1]"), ("y",))
    renamed = interconnect([P], [], ["P.u[1]", "P.u[0]"], "P", inputs=["b", "a"], outputs="z")
    assert (renamed.input_names, renamed.output_names) == (("b", "a"), ("z",))
    np.testing.assert_array_equal(renamed.B1, P.B1[:, ::-1])


def test_an_input_can_be_read_as_an_output():
    """The control signal of a loop: K / (1 + K P), and the reference itself."""
    P, K = random_system(1), random_system(2)
    parts = [named(P, inputs="u", outputs="y"), named(K, inputs="e", outputs="u"), summing_junction(["r", "-y"], "e")]
    whole = interconnect(parts, inputs="r", outputs=["u", "e", "r"])
    S = 1 / (1 + (P(POINTS) * K(POINTS))[:, 0, 0])
    expected = np.stack([K(POINTS)[:, 0, 0] * S, S, np.ones_like(S)], axis=-1)
    same(whole, expected[..., None])


def test_a_whole_without_inputs_is_a_loop_on_its_own():
    P = named(random_system(1), name="P")
    assert interconnect([P], ["P", "-P"]).n_inputs == 0


def test_names_of_a_whole_serve_in_the_next_diagram():
    inner = named(feedback(random_system(1), delay(0.1)), inputs="u", outputs="y", name="inner")
    outer = interconnect([inner, summing_junction(["r", "-y"], "u")], inputs="r", outputs="y")
    same(outer, feedback(inner)(POINTS))


REFUSED = [
    ({"connections": [["P.u", "K.v"]]}, r"'K.v' selects no output; the outputs are P.angle, P.rate, K.u"),
    ({"connections": [["P.x", "K.u"]]}, r"'P.x' selects no input; the inputs are P.u, P.d, K.e\[0\], K.e\[1\]"),
    ({"connections": [["Q.u", "K.u"]]}, "'Q.u' selects no input"),
    ({"connections": [["P.u", "P"]]}, r"selects 1 input\(s\) and 'P' 2 output\(s\)"),
    ({"connections": [("P.u", "K.u"), ["K", "P"]]}, r"a list \[input, output, ...\], got \('P.u', 'K.u'\)"),
    ({"connections": [["P.u.x", "K.u"]]}, "no signal specification"),
    ({"connections": [["P.u", ("K", "u", "2")]]}, "no signal specification"),
    ({"connections": [["P", "P"], ["K", "P"]], "outlist": ["x"]}, "no output or input; the outputs are"),
    ({"connections": [["P", "P"], ["K", "P"]], "outlist": ["P"], "outputs": ["a"]}, "makes 2 output.* 1 names"),
    ({"connections": [["P.u", "K.u"], ["K", "P"]]}, "Input P.d is connected to nothing"),
    ({}, r"Input P.d, K.e\[0\], K.e\[1\] is connected to nothing"),
]  # fmt: skip


@pytest.mark.parametrize(("arguments", "sentence"), REFUSED)
def test_a_diagram_that_does_not_hold_together_is_refused_by_name(arguments, sentence):
    with pytest.raises(InvalidParameterError, match=sentence):
        interconnect(two_parts(1), **arguments)


def test_names_that_mean_two_things_are_refused():
    P = named(delay(0.1), inputs="u", outputs="y", name="u")
    with pytest.raises(InvalidParameterError, match="name of a system and of an input"):
        interconnect([P], [], ["u"], [])
    with pytest.raises(InvalidParameterError, match="ambiguous: 2 systems are called 'u'"):
        interconnect([P, P], [], ["u.u"], [])


def test_inputs_held_at_zero_are_asked_for():
    P, K = two_parts(1)
    whole = interconnect([P, K], [["P.u", "K.u"]], "K.e", "angle", check_unused=False)
    same(whole, P(POINTS)[:, :1, :1] @ K(POINTS))


def test_an_algebraic_loop_in_a_diagram_is_refused():
    parts = [named(static_gain(1.0), inputs="a", outputs="b"), named(static_gain(1.0), inputs="b", outputs="a")]
    with pytest.raises(AlgebraicLoopError, match="no unique solution"):
        interconnect(parts, outputs="a")


def test_a_junction_refuses_a_dimension_that_is_none():
    with pytest.raises(InvalidParameterError, match="dimension of a summing junction"):
        summing_junction(["r", "-y"], "e", dimension=0)
    with pytest.raises(InvalidParameterError, match="distinct"):
        summing_junction(["r", "-r"], "e")
