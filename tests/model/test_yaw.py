import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flycontrol.delay.interconnect import feedback
from flycontrol.delay.pade import pade
from flycontrol.delay.response import response
from flycontrol.delay.spectrum import rightmost_roots
from flycontrol.errors import InvalidParameterError
from flycontrol.model.gain_plane import gain_plane
from flycontrol.model.loci import delay_locus, gain_locus
from flycontrol.model.yaw import PDController, YawLoop, YawPlant

INERTIA, DAMPING = 3.06e-13, 21e-12  # kg m^2, N m s


def fly(delay: float = 3 / 220, inertia: float = INERTIA) -> YawLoop:
    """The nominal loop."""
    return YawLoop(
        plant=YawPlant(inertia=inertia, damping=DAMPING / INERTIA * inertia),
        controller=PDController(proportional=3050.0 * inertia, derivative=45.0 * inertia),
        delay=delay,
    )


loops = st.builds(
    YawLoop.from_rates,
    b=st.floats(0.0, 200.0), kp=st.floats(10.0, 1e4), kd=st.floats(-5.0, 100.0), delay=st.floats(1e-3, 0.05),
    inertia=st.floats(1e-13, 1.0),
)  # fmt: skip


@settings(derandomize=True, deadline=None, max_examples=40)
@given(loops)
def test_casadis_linearisation_is_the_matrices_written_by_hand(loop):
    system = loop.closed_loop()
    inertia, b = loop.plant.inertia, loop.plant.damping_rate
    np.testing.assert_allclose(system.A, [[0.0, 1.0], [0.0, -b]], rtol=1e-14)
    np.testing.assert_allclose(system.B1, [[0.0], [1 / inertia]], rtol=1e-14)
    np.testing.assert_allclose(system.B2 @ system.C2, [[0.0, 0.0], [-loop.kp, -loop.kd]], rtol=1e-14)
    np.testing.assert_allclose(system.C1, [[1.0, 0.0], [0.0, 1.0], [0.0, 0.0]], atol=0)
    # the third output is the fly's torque, -(K_P psi + K_D psi') a delay ago
    np.testing.assert_allclose(system.D12 @ system.C2, [[0, 0], [0, 0], [-loop.kp * inertia, -loop.kd * inertia]])
    assert not system.D11.any()
    assert not system.D21.any()
    assert not system.D22.any()
    assert system.tau == pytest.approx([loop.delay], rel=0)


@settings(derandomize=True, deadline=None, max_examples=40)
@given(loops, st.complex_numbers(min_magnitude=1.0, max_magnitude=500.0))
def test_negative_feedback_closes_the_open_loop_to_the_closed_loop(loop, s):
    """psi / N_ext = G / (1 + L), G = 1 / (I s^2 + beta s)."""
    around = loop.open_loop()(s)[0, 0]
    plant = 1 / (loop.plant.inertia * s**2 + loop.plant.damping * s)
    expected = (loop.controller.proportional + loop.controller.derivative * s) * np.exp(-s * loop.delay) * plant
    assert around == pytest.approx(expected, rel=1e-11)
    psi = loop.closed_loop()(s)[0, 0]
    assert psi * (1 + around) == pytest.approx(plant, rel=1e-8)
    assert feedback(loop.open_loop())(s)[0, 0] * (1 + around) == pytest.approx(around, rel=1e-8)


@pytest.mark.parametrize("order", [1, 2, 3, 4, 8, 16])
def test_the_symbolic_pade_augmentation_is_the_pade_of_the_exact_closed_loop(order):
    symbolic, numeric = fly().pade_closed_loop(order), pade(fly().closed_loop(), order)
    s = np.array([1.0, 30j, -20 + 100j, 400 + 300j])
    np.testing.assert_allclose(symbolic(s), numeric(s), rtol=1e-10)
    for root in rightmost_roots(numeric, 4).roots:
        assert np.abs(np.linalg.eigvals(symbolic.A) - root).min() < 1e-9 * abs(root)


def test_the_pade_loop_is_handed_out_as_python_controls_state_space():
    import control

    model = fly().pade(3)
    assert isinstance(model, control.StateSpace)
    assert (model.ninputs, model.noutputs, model.nstates) == (1, 3, 5)
    s = 20 + 60j
    np.testing.assert_allclose(model(s), pade(fly().closed_loop(), 3)(s), rtol=1e-10)


def test_positive_gains_restore():
    """After a push to the right the fly's torque is to the left, and both gains add to it."""
    pushed = response(fly().closed_loop(), 0.04, [0.0, 0.0045], [[1e-9], [0.0]])
    yaw, rate, torque = pushed(np.linspace(0.0, 0.04, 401))
    # a positive pulse turns right at first and the first torque of the fly, a delay later, is negative
    assert yaw[100] > 0
    assert rate[40] > 0
    assert not torque[:136].any()
    assert torque[150] < 0
    without_delay = fly(delay=0.0)
    assert rightmost_roots(without_delay.closed_loop()).abscissa < 0
    reversed_gains = YawLoop.from_rates(b=69.0, kp=-3050.0, kd=45.0, delay=0.0)
    assert rightmost_roots(reversed_gains.closed_loop()).abscissa > 0


@pytest.mark.parametrize("factor", [1e-3, 7.0, 1e13])
def test_only_ratios_to_the_inertia_matter_for_yaw(factor):
    heavier = fly(inertia=factor * INERTIA)
    np.testing.assert_allclose(heavier.poles(6), fly().poles(6), rtol=1e-11)
    assert heavier.margins().modulus_margin == pytest.approx(fly().margins().modulus_margin, rel=1e-11)
    assert (heavier.kp, heavier.kd) == pytest.approx((3050.0, 45.0), rel=1e-14)
    strong = response(heavier.closed_loop(), 0.1, inputs=[[factor]])([0.03, 0.1])[0]
    np.testing.assert_allclose(strong, response(fly().closed_loop(), 0.1, inputs=[[1.0]])([0.03, 0.1])[0], rtol=1e-11)


def test_a_loop_without_delay_has_the_two_poles_of_its_quadratic():
    poles = np.sort_complex(fly(delay=0.0).poles())
    np.testing.assert_allclose(poles, np.sort_complex(np.roots([1.0, DAMPING / INERTIA + 45.0, 3050.0])), rtol=1e-12)
    assert fly(delay=0.0).pade(3).nstates == 2


def test_a_vanishing_delay_leads_to_the_loop_without_delay():
    np.testing.assert_allclose(fly(delay=1e-9).poles(2), fly(delay=0.0).poles(2), rtol=1e-6)


@pytest.mark.parametrize(
    ("make", "sentence"),
    [
        (lambda: YawPlant(inertia=0.0, damping=1.0), "inertia must be > 0 kg m"),
        (lambda: YawPlant(inertia=np.nan, damping=1.0), "inertia must be > 0"),
        (lambda: YawPlant(inertia=1.0, damping=-1.0), "damping must be >= 0 N m s"),
        (lambda: PDController(proportional=np.inf), "proportional must be a finite number"),
        (lambda: PDController(proportional=1.0, derivative=np.nan), "derivative must be a finite number"),
        (lambda: fly(delay=-0.01), "delay must be >= 0 s"),
        (lambda: fly(delay=np.nan), "delay must be >= 0 s"),
    ],
)
def test_what_no_fly_can_be_is_refused(make, sentence):
    with pytest.raises(InvalidParameterError, match=sentence):
        make()


@settings(derandomize=True, deadline=None, max_examples=30)
@given(loops, st.floats(1e3, 1e5), st.complex_numbers(min_magnitude=1.0, max_magnitude=500.0))
def test_an_integral_term_adds_its_share_to_the_open_and_the_closed_loop(loop, ki, s):
    """L = (K_P + K_D s + K_I / s) exp(-s T) / (I s^2 + beta s), and psi / N_ext = G / (1 + L)."""
    inertia = loop.plant.inertia
    pid = YawLoop.from_rates(
        b=loop.plant.damping_rate, kp=loop.kp, kd=loop.kd, ki=ki, delay=loop.delay, inertia=inertia
    )
    plant = 1 / (inertia * s**2 + loop.plant.damping * s)
    demand = inertia * (loop.kp + loop.kd * s + ki / s)
    around = pid.open_loop()(s)[0, 0]
    assert around == pytest.approx(demand * np.exp(-s * loop.delay) * plant, rel=1e-10)
    closed = pid.closed_loop()(s)[:, 0]
    assert closed[0] * (1 + around) == pytest.approx(plant, rel=1e-8)
    assert closed[2] == pytest.approx(-demand * np.exp(-s * loop.delay) * closed[0], rel=1e-8)


def test_an_integral_term_lets_no_constant_torque_keep_an_error():
    pid = YawLoop.from_rates(b=69.0, kp=3050.0, kd=45.0, ki=3e4, delay=0.0136)
    late = response(pid.closed_loop(), 1.5, inputs=[[100.0]])(np.array([1.5]))
    assert abs(late[0, 0]) < 1e-4 * 100 / 3050  # where PD keeps N / K_P
    assert late[2, 0] == pytest.approx(-100.0, rel=1e-4)


def test_an_integral_loop_without_delay_has_the_roots_of_its_cubic():
    poles = YawLoop.from_rates(b=69.0, kp=3050.0, kd=45.0, ki=2e4, delay=0.0).poles(3)
    np.testing.assert_allclose(
        np.sort_complex(poles), np.sort_complex(np.roots([1.0, 69.0 + 45.0, 3050.0, 2e4])), rtol=1e-10
    )


@pytest.mark.parametrize("closed_form", [gain_plane, gain_locus, delay_locus])
def test_a_closed_form_for_pd_refuses_an_integral_term(closed_form):
    with pytest.raises(InvalidParameterError, match="P or PD control of the yaw angle only"):
        closed_form(YawLoop.from_rates(b=69.0, kp=3050.0, kd=45.0, ki=2e4, delay=0.0136))
