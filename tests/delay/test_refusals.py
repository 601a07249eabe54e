"""Wrong use is refused in a sentence: what was required, what arrived, what to do."""

import control
import numpy as np
import pytest

from flycontrol.delay import (
    Axis,
    count_right_of,
    delay,
    delay_lti,
    feedback,
    fitted,
    forced_response,
    frequency_response,
    initial_response,
    interconnect,
    margins,
    named,
    pade,
    parallel,
    pd_boundary,
    response,
    rightmost_roots,
    root_locus,
    sampled,
    series,
    stability_chart,
    to_statespace,
)
from flycontrol.delay.certificate import certify_interval, largest_certified_delay, stability_certificate
from flycontrol.delay.convert import static_gain
from flycontrol.delay.disk_margins import disk_margins
from flycontrol.delay.norms import h2_norm, hinf_norm, linfnorm, system_norm
from flycontrol.delay.nyquist import nyquist_response
from flycontrol.delay.pade_order import pade_certificate, pade_order
from flycontrol.delay.sensitivity import gangof4
from flycontrol.delay.timeresponse import impulse_response, step_response
from flycontrol.errors import AlgebraicLoopError, InvalidParameterError, NeutralSystemError, UnstableSystemError

LAG = control.tf([1.0], [1.0, 1.0])
LATE = control.tf([1.0], [1.0, 0.0]) * delay(0.5)  # closed: stable up to a delay of pi/2, or a gain of pi
UNSTABLE = control.tf([1.0], [1.0, -1.0]) * delay(0.1)
TWO, THREE = delay([0.1, 0.2]), delay([0.1, 0.2, 0.3])
ECHO = delay_lti(A=[[-1.0]], B1=[[1.0]], B2=[[1.0]], C1=[[1.0]], C2=[[1.0]], D22=[[0.5]], tau=[1.0])

NOT_A_DELAY = [-1, -1e-9, np.nan, np.inf, "13.6 ms", None, 1j, [0.1, -0.1], [[0.1]]]

OF_ANOTHER_SHAPE = [
    (lambda: TWO * THREE, r"\(3, 3\) and \(2, 2\)"),
    (lambda: TWO + THREE, r"\(2, 2\) and \(3, 3\)"),
    (lambda: np.ones((2, 3)) * TWO, r"\(2, 2\) and \(2, 3\)"),
    (lambda: feedback(TWO, THREE), r"\(2, 2\).*\(2, 2\), got \(3, 3\)"),
    (lambda: gangof4(TWO, LAG), r"\(2, 2\).*\(2, 2\), got \(1, 1\)"),
    (lambda: feedback(static_gain(np.ones((1, 2)))), r"square system, got shape \(outputs, inputs\) = \(1, 2\)"),
    (lambda: margins(TWO), r"one input and one output, got shape \(outputs, inputs\) = \(2, 2\)"),
    (lambda: delay_lti(A=np.eye(2), B1=[[1.0]], C1=[[1.0]]), r"B1 must have shape \(2, 1\).*got \(1, 1\)"),
]

NORMS_AND_PEAKS = [hinf_norm, h2_norm, system_norm, lambda G: gangof4(G, 0.1).peaks()]

OF_RETARDED_SYSTEMS_ONLY = [
    rightmost_roots,
    hinf_norm,
    h2_norm,
    linfnorm,
    margins,
    nyquist_response,
    frequency_response,
    stability_certificate,
    lambda G: count_right_of(G, 0.0),
    lambda G: response(G, 1.0),
    lambda G: step_response(G, 1.0),
    lambda G: impulse_response(G, 1.0),
    lambda G: pade_order(G, 0.1),
]

OF_WHAT_HAS_NO_STATE_SPACE = [
    lambda: control.tf([1.0, 0.0], [1.0]) * delay(0.1),
    lambda: delay(0.1) * control.tf([1.0, 0.0, 0.0], [1.0, 1.0]),
    lambda: feedback(LATE, control.tf([45.0, 3050.0], [1.0])),
]

ALGEBRAIC_LOOPS = [
    lambda: feedback(static_gain(-1.0)),
    lambda: feedback(1.0, 1.0, 1.0),
    lambda: feedback(delay(0.0), -1.0),
    lambda: feedback(control.ss([[-1.0]], [[1.0]], [[1.0]], [[-1.0]])),
]

DIVISORS = [delay(0.1), np.ones((2, 2)), LAG * delay(0.1), static_gain(np.ones((1, 2)))]

NO_SUCH_ARGUMENT = [
    (lambda: delay_lti(A=[[0.0, 1.0], [1.0]], B1=[[1.0]], C1=[[1.0]]), r"DelayLTI\.A must be.*rows equally long"),
    (lambda: delay_lti(A=[[1j]], B1=[[1.0]], C1=[[1.0]]), r"DelayLTI\.A must be an array of real numbers"),
    (lambda: feedback(LATE, 1.0, np.nan), "sign of a feedback must be -1 or 1, got nan"),
    (lambda: feedback(LATE, 1.0, 0.5), r"sign of a feedback must be -1 or 1, got 0\.5; put a gain"),
    (lambda: rightmost_roots(LATE, 0), "count of rightmost roots must be an integer >= 1, got 0"),
    (lambda: rightmost_roots(LATE, 2.5), r"must be an integer >= 1, got 2\.5"),
    (lambda: rightmost_roots("loop"), "combines with delay systems.*got str"),
    (lambda: count_right_of(LATE, np.nan), r"finite Re s \[1/s\], got nan"),
    (lambda: frequency_response(LATE, turn=0.0), r"turn between neighbours must be > 0 and finite, got 0\.0"),
    (lambda: system_norm(LAG * delay(0.1), 3), 'p = 2 or p = "inf", got 3'),
    (lambda: to_statespace(delay(0.1)), "give the order of a Pade"),
    (lambda: certify_interval(feedback(LATE), np.nan, 1.0), "0 <= low < high in seconds, got low = nan"),
    (lambda: largest_certified_delay(feedback(LATE), tolerance=np.nan), r"in \(0, 1\), got nan"),
]

TIMES = np.linspace(0.0, 1.0, 11)
CLOSED = feedback(LATE)
FROM_STRINGS = [
    (lambda: margins(LATE, "a"), "floor of phase crossovers must be a real number, got 'a'"),
    (lambda: pade_order(LATE, "a"), "accuracy of a Pade approximation must be a real number"),
    (lambda: pade_certificate(LATE, 2, band="a"), "band of a Pade approximation must be a real number"),
    (lambda: hinf_norm(CLOSED, tol="a"), "tolerance of a norm must be a real number"),
    (lambda: h2_norm(CLOSED, "a"), "tolerance of a norm must be a real number"),
    (lambda: certify_interval(CLOSED, "a", "b"), r"low end of an interval \[s\] must be a real number"),
    (lambda: largest_certified_delay(CLOSED, low="a"), r"low \[s\] must be a real number"),
    (lambda: count_right_of(LATE, None), r"Re s \[1/s\], must be a real number, got None"),
    (lambda: disk_margins(LATE, skew="a"), "skew of a disk must be a real number"),
    (lambda: frequency_response(LATE, "a", "b"), r"lowest frequency \[rad/s\] must be a real number"),
    (lambda: frequency_response(LATE, turn="a"), "turn between neighbours must be a real number"),
    (lambda: step_response(LATE, "a"), r"Times of a response \[s\] must be real numbers, got 'a'"),
    (lambda: initial_response(LATE, 1.0, "ab"), "initial state must be real numbers, got 'ab'"),
    (lambda: response(LATE, "a"), r"end of a response \[s\] must be a real number"),
    (lambda: response(LATE, 1.0, edges="a"), r"Input edges \[s\] must be real numbers"),
    (lambda: response(LATE, 1.0, [0.0], [[1.0], [1.0, 2.0]]), "Inputs must be real numbers in rows equally long"),
    (lambda: response(LATE, 1.0)("a"), "Times of a response"),
    (lambda: Axis("gain", "1/s", "x"), "values of the axis 'gain' must be real numbers, got 'x'"),
    (lambda: root_locus(lambda k: feedback(k * LATE), "ab"), "Parameter values of a root locus must be real numbers"),
    (lambda: root_locus(lambda k: feedback(k * LATE), [1.0, 2.0], "a"), "integer count >= 1, got 'a'"),
    (lambda: pd_boundary("a", 1.0, [1.0]), r"damping rate of a PD boundary \[1/s\] must be a real number"),
    (lambda: sampled("ab", [1.0, 2.0]), r"Times of samples \[s\] must be real numbers"),
    (lambda: LATE("a"), r"complex frequency s \[1/s\] must be a number, got 'a'"),
    (parallel, "sum needs at least one system"),
    (series, "series connection needs at least one system"),
]

SLICE = Axis("gain", "1", [1.0])
OF_THE_WRONG_KIND = [
    (lambda: stability_chart(lambda a, b: CLOSED, [1, 2], [3, 4]), r"as Axis\(name, unit, values\), got list"),
    (
        lambda: stability_chart(5, Axis("a", "", [1.0]), Axis("b", "", [1.0])),
        "family of a chart must be a function, got 5",
    ),
    (lambda: root_locus(5, [1.0, 2.0]), "family of a root locus must be a function, got 5"),
    (lambda: initial_response(CLOSED, 1.0, history=[1, 2]), r"history.*must be a function, got \[1, 2\]"),
    (lambda: initial_response(CLOSED, 6.0), "needs an initial state or a history"),
    (lambda: forced_response(LATE, TIMES, np.sin), r"got a function; hand it over as fitted\(function, \[0, end\]\)"),
    (
        lambda: fitted(lambda t: [abs(t - 1 / 3)], [0.0, 1.0]),
        r"not smooth near 0\.333333 s; give that time in `breaks`",
    ),
    (lambda: pd_boundary(1.0, 1.0, [np.nan]), r"b = 1, T = 1 and omega = \[nan\]"),
    (lambda: TWO / 0, "Division by zero"),
    (lambda: TWO / np.zeros((2, 2)), "Division by zero"),
]


@pytest.mark.parametrize(("call", "sentence"), [*FROM_STRINGS, *OF_THE_WRONG_KIND])
def test_what_is_no_number_or_of_the_wrong_kind_is_refused_in_a_sentence(call, sentence):
    with pytest.raises(InvalidParameterError, match=sentence):
        call()


def test_an_unstable_loop_has_no_disk_margin_and_is_told_so_in_words_of_the_loop():
    with pytest.raises(UnstableSystemError, match=r"closed loop is not stable \(2 pole.*no disk margin"):
        disk_margins(4.0 * LATE)


def test_systems_of_one_name_do_not_silently_share_a_signal():
    P = named(LAG, inputs="u", outputs="y", name="P")
    with pytest.raises(InvalidParameterError, match=r"2 systems called 'P' have an input 'u'.*different names"):
        interconnect([P, P], inputs="u", outputs="y")
    with pytest.raises(InvalidParameterError, match="2 systems called 'P' have an output 'y'"):
        interconnect([P, P], [], inplist=[(0, "u"), (1, "u")], outlist=["y"])
    assert interconnect([P, P], [], inplist=[(0, "u"), (1, "u")], outlist=[(0, "y"), (1, "y")]).n_outputs == 2


@pytest.mark.parametrize("seconds", NOT_A_DELAY, ids=repr)
def test_what_is_no_delay_is_refused(seconds):
    with pytest.raises(InvalidParameterError, match=r"A delay must be >= 0 s and finite.*got"):
        delay(seconds)


@pytest.mark.parametrize("tau", [-1.0, 0.0, np.nan, np.inf])
def test_a_channel_without_a_delay_is_refused(tau):
    with pytest.raises(InvalidParameterError, match=r"DelayLTI\.tau must be (> 0 s|finite), got"):
        delay_lti(A=[[0.0]], B1=[[1.0]], B2=[[1.0]], C1=[[1.0]], C2=[[1.0]], tau=[tau])


@pytest.mark.parametrize(("call", "shapes"), OF_ANOTHER_SHAPE)
def test_systems_that_do_not_fit_are_refused_with_both_shapes(call, shapes):
    with pytest.raises(InvalidParameterError, match=shapes):
        call()


@pytest.mark.parametrize("norm", NORMS_AND_PEAKS)
def test_an_unstable_system_has_no_norm(norm):
    with pytest.raises(UnstableSystemError, match=r"1 pole\(s\) with Re s > 0.*Stabilise it first"):
        norm(UNSTABLE)


@pytest.mark.parametrize("norm", [hinf_norm, h2_norm, linfnorm, system_norm])
def test_an_integrator_has_no_norm(norm):
    with pytest.raises(UnstableSystemError, match=r"pole on the imaginary axis, at 0 rad/s"):
        norm(LATE)


@pytest.mark.parametrize(
    "prove",
    [
        stability_certificate,
        lambda loop: certify_interval(loop, 0.4, 0.6),
        lambda loop: largest_certified_delay(loop, low=0.5),
    ],
)
def test_no_certificate_is_looked_for_where_none_exists(prove):
    """The loop s = -4 exp(-s/2) is unstable: 4 > pi."""
    with pytest.raises(UnstableSystemError, match=r"No certificate of stability can exist.*root at.*Change"):
        prove(feedback(4.0 * LATE))


def test_a_certificate_that_is_not_found_proves_nothing():
    """The loop is stable, 3 < pi, but a functional of order 0 does not see it; nor does Pade [1/1]."""
    tight = feedback(3.0 * LATE)
    assert rightmost_roots(tight, 2).abscissa < 0
    assert "proves nothing" in stability_certificate(tight, order=0).status
    assert "proves nothing" in certify_interval(tight, 0.49, 0.51, order=0).status
    assert "proves nothing" in pade_certificate(3.0 * LATE, 1).status


@pytest.mark.parametrize("question", OF_RETARDED_SYSTEMS_ONLY)
def test_a_delay_that_feeds_itself_is_refused_everywhere_in_the_same_words(question):
    with pytest.raises(NeutralSystemError, match=r"neutral type: a delay feeds back into itself.*Put a lag"):
        question(ECHO)


def test_closing_a_delayed_direct_path_makes_a_neutral_loop_that_no_order_approximates():
    with pytest.raises(NeutralSystemError, match=r"neutral type"):
        pade_order(0.5 * delay(0.1), 1e-2)


@pytest.mark.parametrize("build", OF_WHAT_HAS_NO_STATE_SPACE)
def test_an_improper_controller_is_refused_with_the_way_out(build):
    with pytest.raises(InvalidParameterError, match=r"improper.*feed back the plant's derivative output instead"):
        build()


@pytest.mark.parametrize("close", ALGEBRAIC_LOOPS)
def test_an_algebraic_loop_is_refused_with_the_way_out(close):
    with pytest.raises(AlgebraicLoopError, match=r"gain 1.*no unique solution; put a delay or a lag into the loop"):
        close()


@pytest.mark.parametrize("divisor", DIVISORS, ids=lambda H: type(H).__name__)
def test_division_by_what_cannot_be_inverted_is_refused_with_the_way_out(divisor):
    with pytest.raises(InvalidParameterError, match=r"invertible undelayed direct path.*write feedback\(G, H\)"):
        TWO / divisor


@pytest.mark.parametrize(("call", "sentence"), NO_SUCH_ARGUMENT)
def test_an_impossible_argument_is_refused_in_a_sentence(call, sentence):
    with pytest.raises(InvalidParameterError, match=sentence):
        call()


def test_systems_of_python_control_are_taken_wherever_delay_systems_are():
    assert rightmost_roots(LAG, 1).abscissa == -1.0
    assert count_right_of(LAG, -2.0).roots == 1
    assert pade(LAG, 3).n_states == 1
    assert to_statespace(LAG).nstates == 1
    np.testing.assert_allclose(response(LAG, 1.0, [0.0], [[1.0]])([1.0])[0, 0], 1 - np.exp(-1.0), rtol=1e-12)
    np.testing.assert_allclose(
        frequency_response(LAG, 0.5, 2.0).value, 1 / (1 + 1j * frequency_response(LAG, 0.5, 2.0).omega), rtol=1e-12
    )


def test_the_frequency_range_of_a_gain_and_of_an_integrator_with_delay_is_that_of_their_rates():
    assert frequency_response(2.0).value == pytest.approx(2.0)
    assert frequency_response(LATE).omega[0] == pytest.approx(2e-5)  # 1e-5 of 1 / delay
