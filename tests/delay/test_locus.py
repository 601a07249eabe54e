import control
import numpy as np
import pytest
from pd_loop import KD, KP, B, T, newton_step, pd_closed, pd_open

from flycontrol.delay.interconnect import delay, feedback
from flycontrol.delay.locus import root_locus
from flycontrol.delay.margins import margins

FACTORS = np.geomspace(0.02, 4.0, 200)


@pytest.fixture(scope="module")
def gain_locus():
    return root_locus(lambda f: pd_closed(kp=f * KP, kd=f * KD), FACTORS)


def test_every_point_of_a_branch_is_a_root_at_its_value(gain_locus):
    for factor, roots in zip(gain_locus.values, gain_locus.branches.T, strict=True):
        for root in roots[np.isfinite(roots)]:
            assert newton_step(root, B, factor * KP, factor * KD, T) < 1e-9 * abs(root)


def test_no_two_branches_hold_the_same_root(gain_locus):
    for roots in gain_locus.branches.T:
        here = roots[np.isfinite(roots)]
        apart = np.abs(here[:, None] - here[None, :]) + np.eye(len(here)) * 1e9
        assert apart.min() > 1e-6 * np.abs(here).max()


def test_branches_move_no_further_than_the_roots_own_speed_allows(gain_locus):
    """Away from meeting points |ds/df| df = |(kp + kd s) e^(-sT) / f'(s)| df bounds a step."""
    for branch in gain_locus.branches:
        for k in np.flatnonzero(np.isfinite(branch[:-1]) & np.isfinite(branch[1:])):
            s, factor = branch[k], FACTORS[k]
            lag = np.exp(-s * T)
            slope = 2 * s + B + factor * (KD - T * (KD * s + KP)) * lag
            speed = abs((KD * s + KP) * lag / slope)
            step = FACTORS[k + 1] - FACTORS[k]
            close_to_another = abs(slope) < 0.5 * abs(s)
            if not close_to_another:
                assert abs(branch[k + 1] - s) < 3 * speed * step + 1e-6 * abs(s)


def test_a_branch_is_one_unbroken_piece(gain_locus):
    for branch in gain_locus.branches:
        present = np.flatnonzero(np.isfinite(branch))
        np.testing.assert_array_equal(np.diff(present), 1)


def test_the_nominal_loop_has_few_branches():
    """Eight roots: at most four pairs or so at a time, and the real ones that they split into."""
    locus = root_locus(lambda f: pd_closed(69.0, f * 3050.0, f * 45.0, 3 / 220), FACTORS)
    at_a_time = np.isfinite(locus.branches).sum(axis=0)
    assert at_a_time.max() <= 9
    assert len(locus.branches) <= 12


def test_the_gain_locus_crosses_into_the_right_half_plane_at_the_gain_margin(gain_locus):
    unstable = np.nanmax(gain_locus.branches.real, axis=0) > 0
    gain_margin = margins(pd_open()).gain_margin
    np.testing.assert_array_equal(unstable, gain_margin < FACTORS)


def test_the_delay_locus_leaves_the_poles_without_delay_at_first_order():
    """ds/dT = (kp + kd s) s / (2 s + b + kd) at T = 0."""
    start = 1e-6
    locus = root_locus(lambda delay: pd_closed(T=delay), np.geomspace(start, 1e-3, 20), count=2)
    for pole in np.roots([1.0, B + KD, KP]):
        expected = pole + start * (KP + KD * pole) * pole / (2 * pole + B + KD)
        # the second order is (|s| T)^2 |s|, 2e-7
        assert np.nanmin(np.abs(locus.branches[:, 0] - expected)) < 1e-6


@pytest.mark.parametrize("points", [3, 5, 8, 21])
def test_a_real_root_crosses_the_origin_where_the_closed_loop_matrix_at_rest_is_singular(points):
    """s^2 - a + (18 + 5 s) e^(-0.2 s) at s = 0: a = 18, on any grid."""

    def inverted(a):
        plant = control.ss([[0.0, 1.0], [a, 0.0]], [[0.0], [1.0]], np.eye(2), 0.0)
        return feedback(plant, delay(0.2) * np.array([[18.0, 5.0]]))

    locus = root_locus(inverted, np.linspace(10.0, 22.0, points), 4)
    at_rest = [crossing for crossing in locus.crossings if crossing.frequency == 0.0]
    assert len(at_rest) == 1
    assert at_rest[0].value == pytest.approx(18.0, rel=1e-14)
    assert at_rest[0].rightward
