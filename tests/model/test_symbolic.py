import casadi as ca
import numpy as np
import pytest

from flycontrol.errors import InvalidParameterError
from flycontrol.model.equations import paddling_torque, stroke_averaged_torque
from flycontrol.model.symbolic import SymbolicDelaySystem, linearisation, linearised, pade_augmented, right_hand_side
from flycontrol.model.yaw import YawLoop, yaw_system

PARAMETERS = [3.06e-13, 21e-12, 3050 * 3.06e-13, 45 * 3.06e-13, 3 / 220]  # I, beta, K_P, K_D, T
N_MAX, OMEGA = 5e-10, 1000.0  # N m, rad/s


@pytest.mark.parametrize(
    ("variant", "further"),
    [
        ({"saturated": True}, [N_MAX]),
        ({"quadratic": True}, [OMEGA]),
        ({"saturated": True, "quadratic": True}, [N_MAX, OMEGA]),
    ],
)
def test_every_nonlinear_variant_linearises_to_the_same_system(variant, further):
    plain = linearised(linearisation(yaw_system()), PARAMETERS)
    other = linearised(linearisation(yaw_system(**variant)), PARAMETERS + further)
    for block in ("A", "B1", "B2", "C1", "C2", "D11", "D12", "D21", "D22", "tau"):
        np.testing.assert_allclose(getattr(other, block), getattr(plain, block), rtol=1e-14, err_msg=block)


def test_a_saturated_fly_never_exceeds_its_largest_torque():
    system = right_hand_side(yaw_system(saturated=True))
    torque = [float(system([0, 0], w, 0, [*PARAMETERS, N_MAX])[1][2]) for w in (-1e-6, -1e-10, 1e-12, 1e-6)]
    assert np.abs(torque).max() <= N_MAX
    assert torque[0] == pytest.approx(N_MAX, rel=1e-12)
    assert torque[2] == pytest.approx(-1e-12, rel=1e-5)  # tanh x = x - x^3 / 3, x = 0.002


def test_the_square_of_the_yaw_rate_corrects_only_the_paddling_gain_and_by_a_thousandth():
    """gamma d_alpha (1 + (psi' / omega)^2): 0.07 % or so at 36 rad/s against a wing of a thousand rad/s or more."""
    system = right_hand_side(yaw_system(quadratic=True))
    resting, turning = (float(system([0, rate], 1e-10, 0, [*PARAMETERS, OMEGA])[1][2]) for rate in (0.0, 36.0))
    assert turning / resting - 1 == pytest.approx((36.0 / OMEGA) ** 2, rel=1e-9)
    assert turning / resting - 1 < 0.002


def test_equation_2_has_the_damping_and_the_paddling_gain_of_its_expansion():
    """N = -4 omega C_D(alpha0) psi' + 2 omega^2 C_D'(alpha0) d_alpha at first order."""
    alpha0, omega, rate, paddling = (ca.SX.sym(name) for name in ("alpha0", "omega", "psi_dot", "d_alpha"))

    def drag(alpha):  # measured on a revolving wing, angles in degrees
        return 1.92 - 1.55 * ca.cos((2.04 * alpha * 180 / np.pi - 9.82) * np.pi / 180)

    torque = stroke_averaged_torque(drag, alpha0, omega, rate, paddling)
    slopes = ca.Function("slopes", [alpha0, omega, rate, paddling], [ca.jacobian(torque, ca.vertcat(rate, paddling))])
    for angle, speed in ((np.pi / 4, 1000.0), (0.6, 800.0)):
        damping, gain = np.array(slopes(angle, speed, 0.0, 0.0)).ravel()
        argument = 2.04 * angle - np.deg2rad(9.82)
        C_D, slope = 1.92 - 1.55 * np.cos(argument), 1.55 * 2.04 * np.sin(argument)
        assert damping == pytest.approx(-4 * speed * C_D, rel=1e-12)
        assert gain == pytest.approx(2 * speed**2 * slope, rel=1e-12)


def test_with_linear_drag_equation_2_keeps_the_yaw_rates_square_only_in_the_paddling_gain():
    """Eq. 2 with C_D linear is exactly -4 omega C_D psi' + 2 omega^2 C_D' d_alpha (1 + (psi' / omega)^2)."""
    C_D, slope, omega, alpha0 = 1.9, 3.0, 900.0, np.pi / 4
    for rate, paddling in ((36.0, 0.1), (-20.0, -0.2), (100.0, 0.05)):
        exact = stroke_averaged_torque(lambda a: C_D + slope * (a - alpha0), alpha0, omega, rate, paddling)
        gamma = 2 * omega**2 * slope
        kept = -4 * omega * C_D * rate + paddling_torque(gamma, paddling, rate, omega)
        assert kept == pytest.approx(exact, rel=1e-13)


def test_a_mirror_image_turns_the_torque_around():
    def drag(alpha):
        return 1.92 - 1.55 * np.cos(2.04 * alpha - 0.17)

    there = stroke_averaged_torque(drag, 0.8, 900.0, 30.0, 0.1)
    assert stroke_averaged_torque(drag, 0.8, 900.0, -30.0, -0.1) == pytest.approx(-there, rel=1e-14)


def test_the_symbolic_pade_keeps_nonlinear_terms():
    augmented = right_hand_side(pade_augmented(yaw_system(saturated=True), 3))
    far = ca.DM([0.0, 0.0, 1e-3, 1e-3, 1e-3])  # delayed signals far above N_max
    assert abs(float(augmented(far, ca.DM(0, 1), 0, [*PARAMETERS, N_MAX])[1][2])) <= N_MAX


def test_the_linearisation_is_exact_in_the_parameters_too():
    """CasADi's derivative of A by a gain, against the matrices' own linear dependence."""
    loop = YawLoop.from_rates(b=69.0, kp=3050.0, kd=45.0, delay=0.01)
    more = YawLoop.from_rates(b=69.0, kp=3051.0, kd=45.0, delay=0.01)
    difference = more.closed_loop().C2 - loop.closed_loop().C2
    np.testing.assert_allclose(difference, [[1.0, 0.0]], atol=1e-11)


def test_a_chain_of_delays_without_a_state_between_is_refused_by_the_symbolic_pade():
    x, w, u, p = ca.SX.sym("x"), ca.SX.sym("w", 2), ca.SX.sym("u"), ca.SX.sym("p", 0)
    chain = SymbolicDelaySystem(
        states=x, delayed=w, inputs=u, parameters=p, derivative=-x + w[1] + u, outputs=x,
        delayed_signals=ca.vertcat(x, w[0]), delays=ca.SX([0.1, 0.2]),
    )  # fmt: skip
    with pytest.raises(InvalidParameterError, match="give that chain of delays a state"):
        pade_augmented(chain, 2)
