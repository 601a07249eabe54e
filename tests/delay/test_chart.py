import numpy as np
import pytest
from pd_loop import largest_delay, pd_closed, pd_open
from random_systems import random_system

from flycontrol.delay.characteristic import CharacteristicBlocks
from flycontrol.delay.chart import Axis, stability_chart
from flycontrol.delay.interconnect import delay, feedback, series
from flycontrol.delay.margins import margins
from flycontrol.delay.spectrum import rightmost_roots
from flycontrol.delay.system import DelayLTI, delay_lti
from flycontrol.errors import InvalidParameterError, NeutralSystemError

B, T = 68.63, 3 / 220
KP = Axis("kp", "1/s^2", np.linspace(-500.0, 12000.0, 14))
KD = Axis("kd", "1/s", np.linspace(-90.0, 200.0, 12))


def closed(kp: float, kd: float) -> DelayLTI:
    return pd_closed(B, kp, kd, T)


@pytest.fixture(scope="module")
def chart():
    return stability_chart(
        closed, KP, KD, ("decay_rate", "modulus_margin"), loop_at=lambda kp, kd: pd_open(B, kp, kd, T)
    )


def test_regions_agree_with_the_roots_themselves(chart):
    for i, kd in enumerate(KD.values):
        for j, kp in enumerate(KP.values):
            found = rightmost_roots(closed(kp, kd), 6)
            assert found.status == "certified"
            assert chart.unstable_roots[i, j] == (found.roots.real > 0).sum()
            assert chart.stable[i, j] == (found.abscissa < 0)


def test_the_decay_rate_is_that_of_the_rightmost_root(chart):
    exact = [[-rightmost_roots(closed(kp, kd), 6).abscissa for kp in KP.values] for kd in KD.values]
    np.testing.assert_allclose(chart.decay_rate, exact, rtol=1e-10)


def test_the_decay_rate_is_positive_exactly_where_no_root_is_unstable(chart):
    np.testing.assert_array_equal(chart.decay_rate > 0, chart.stable)


def test_the_modulus_margin_is_charted_where_the_loop_is_stable(chart):
    np.testing.assert_array_equal(np.isfinite(chart.modulus_margin), chart.stable)
    i, j = np.argwhere(chart.stable)[5]
    exact = margins(pd_open(B, KP.values[j], KD.values[i], T)).modulus_margin
    assert chart.modulus_margin[i, j] == exact


def test_over_gain_and_delay_a_loop_is_stable_up_to_its_largest_delay():
    gain, lag = Axis("factor", "", np.linspace(0.2, 3.0, 15)), Axis("T", "s", np.linspace(0.002, 0.06, 25))
    chart = stability_chart(lambda f, T: pd_closed(B, 3050 * f, 45 * f, T), gain, lag)
    exact = [largest_delay(B, 3050 * f, 45 * f) for f in gain.values]
    np.testing.assert_array_equal(chart.stable, lag.values[:, None] < exact)


def test_a_loop_and_its_mirror_image_have_the_same_chart():
    """x' = A x - g x(t - tau) with the sign of both states turned is the same loop."""

    def system_at(a: float, g: float, sign: float = 1.0) -> DelayLTI:
        return delay_lti(
            A=[[-1.0, sign * a], [sign * a, -1.0]], B1=[[1.0], [0.0]], B2=-g * np.eye(2), C1=[[1.0, 0.0]], C2=np.eye(2),
            tau=[0.7, 0.7],
        )  # fmt: skip

    a, g = Axis("a", "", np.linspace(-3.0, 3.0, 9)), Axis("g", "", np.linspace(-2.0, 4.0, 8))
    chart = stability_chart(system_at, a, g, ("decay_rate",))
    np.testing.assert_array_equal(chart.unstable_roots, chart.unstable_roots[:, ::-1])
    np.testing.assert_allclose(chart.decay_rate, chart.decay_rate[:, ::-1], rtol=1e-9)


def test_over_two_delays_that_may_be_swapped_the_chart_is_symmetric():
    """x' = -x(t - h) - x(t - g)."""

    def system_at(h: float, g: float) -> DelayLTI:
        return delay_lti(A=[[0.0]], B1=[[1.0]], B2=[[-1.0, -1.0]], C1=[[1.0]], C2=[[1.0], [1.0]], tau=[h, g])

    lag = np.linspace(0.05, 4.0, 12)
    chart = stability_chart(system_at, Axis("h", "s", lag), Axis("g", "s", lag), ("decay_rate",))
    np.testing.assert_array_equal(chart.unstable_roots, chart.unstable_roots.T)
    np.testing.assert_allclose(chart.decay_rate, chart.decay_rate.T, rtol=1e-9)
    np.testing.assert_array_equal(np.diag(chart.stable), lag < np.pi / 4)  # one delay: 2 h < pi / 2


def test_a_slice_is_a_chart_with_one_value_on_one_axis():
    across = stability_chart(closed, KP, Axis("kd", "1/s", [45.0]), ("decay_rate",))
    upward = stability_chart(closed, Axis("kp", "1/s^2", [3050.0]), KD, ("decay_rate",))
    assert across.decay_rate.shape == (1, 14)
    assert upward.decay_rate.shape == (12, 1)
    assert across.decay_rate[0, 3] == pytest.approx(-rightmost_roots(closed(KP.values[3], 45.0), 4).abscissa, rel=1e-10)


def test_decay_rates_of_random_families_are_those_of_the_certified_spectrum():
    for seed in range(8):
        x = random_system(seed, 1 + seed % 4, 1 + seed % 3, chained=seed % 2 == 0)

        def system_at(gain: float, lag: float, x=x) -> DelayLTI:
            tau = np.append(lag, x.tau[1:])
            return delay_lti(A=x.A, B1=x.B1, B2=gain * x.B2, C1=x.C1, C2=x.C2, D22=x.D22, tau=tau)

        gain, lag = Axis("gain", "", np.linspace(0.5, 2.0, 4)), Axis("lag", "s", np.linspace(0.3, 2.0, 4))
        chart = stability_chart(system_at, gain, lag, ("decay_rate",))
        exact = [[-rightmost_roots(system_at(g, h), 4).abscissa for g in gain.values] for h in lag.values]
        np.testing.assert_allclose(chart.decay_rate, exact, rtol=1e-8, atol=1e-9)


def test_a_point_with_a_root_on_the_axis_is_said():
    chart = stability_chart(closed, Axis("kp", "1/s^2", [0.0, 1000.0]), Axis("kd", "1/s", [10.0]))
    assert chart.unstable_roots.tolist() == [[-1, 0]]
    assert chart.stable.tolist() == [[False, True]]


def test_blocks_alone_give_the_same_chart(chart):
    A, B2, D22, tau = np.array([[0.0, 1.0], [0.0, -B]]), np.array([[0.0], [-1.0]]), np.zeros((1, 1)), np.array([T])

    def blocks(kp: float, kd: float) -> CharacteristicBlocks:
        return CharacteristicBlocks(A, B2, np.array([[kp, kd]]), D22, tau)

    light = stability_chart(blocks, KP, KD, ("decay_rate",))
    np.testing.assert_array_equal(light.unstable_roots, chart.unstable_roots)
    np.testing.assert_array_equal(light.decay_rate, chart.decay_rate)


def test_a_delay_that_vanishes_at_the_edge_is_charted_without_it():
    plant = delay_lti(A=[[0.0, 1.0], [0.0, -B]], B1=[[0.0], [1.0]], C1=[[3050.0, 45.0]])
    chart = stability_chart(
        lambda f, T: feedback(series(delay(T), plant * f)),
        Axis("factor", "", [0.5, 1.0]),
        Axis("T", "s", [0.0, T, 0.05]),
        ("decay_rate",),
    )
    assert chart.unstable_roots.tolist() == [[0, 0], [0, 0], [0, 2]]
    exact = -np.roots([1.0, B + 45.0, 3050.0]).real.max()
    assert chart.decay_rate[0, 1] == pytest.approx(exact, rel=1e-12)


def test_progress_is_told_for_every_row_and_part():
    told: list[tuple[int, int, str]] = []
    stability_chart(
        closed, KP, KD, ("decay_rate", "boundary"), progress=lambda done, total, what: told.append((done, total, what))
    )
    assert [done for done, _, _ in told] == list(range(1, 15))
    assert {total for _, total, _ in told} == {14}
    assert told[-1][2] == "boundary"


def pd_blocks(kp, kd, T) -> CharacteristicBlocks:
    """Of one loop, or of many where parameters are arrays (k,)."""
    C2 = np.stack([kp, kd], axis=-1)[..., None, :]
    return CharacteristicBlocks(
        np.array([[0.0, 1.0], [0.0, -B]]), np.array([[0.0], [-1.0]]), C2, np.zeros((1, 1)), np.asarray(T)[..., None]
    )


def test_a_batched_family_has_the_chart_of_its_members_one_by_one():
    quantities = ("unstable_roots", "decay_rate")
    one = stability_chart(lambda kp, kd: pd_blocks(kp, kd, T), KP, KD, quantities)
    many = stability_chart(lambda kp, kd: pd_blocks(kp, kd, T), KP, KD, quantities, batched=True)
    np.testing.assert_array_equal(many.unstable_roots, one.unstable_roots)
    np.testing.assert_array_equal(many.decay_rate, one.decay_rate)
    lag = Axis("T", "s", np.linspace(0.002, 0.06, 25))
    scaled = stability_chart(lambda f, T: pd_blocks(3050 * f, 45 * f, T), Axis("f", "", [0.5, 1.0]), lag, batched=True)
    exact = [largest_delay(B, 3050 * f, 45 * f) for f in (0.5, 1.0)]
    np.testing.assert_array_equal(scaled.stable, lag.values[:, None] < exact)


def test_a_batched_family_that_does_not_fit_is_refused_in_a_sentence():
    def first_only(kp, kd) -> CharacteristicBlocks:
        return pd_blocks(np.ravel(kp)[:3], np.ravel(kd)[:3], T) if np.ndim(kp) else pd_blocks(kp, kd, T)

    def echo(kp, kd) -> CharacteristicBlocks:
        return pd_blocks(kp, kd, T)._replace(D22=np.full((1, 1), 0.5) * (np.ndim(kp) > 0))

    with pytest.raises(InvalidParameterError, match="for arrays of 14 values: blocks of shapes"):
        stability_chart(first_only, KP, KD, batched=True)
    with pytest.raises(InvalidParameterError, match="for arrays of 14 values"):
        stability_chart(lambda kp, kd: closed(np.max(kp), np.max(kd)), KP, KD, batched=True)
    with pytest.raises(InvalidParameterError, match=r"tau must be > 0 s"):
        stability_chart(lambda kp, kd: pd_blocks(kp, kd, T - 2e-6 * kp), KP, KD, batched=True)
    with pytest.raises(NeutralSystemError, match="neutral type"):
        stability_chart(echo, KP, KD, batched=True)


def test_wrong_use_is_refused_in_a_sentence():
    with pytest.raises(InvalidParameterError, match=r"no quantity 'speed'; choose from unstable_roots"):
        stability_chart(closed, KP, KD, ("speed",))  # pyright: ignore
    with pytest.raises(InvalidParameterError, match="give loop_at"):
        stability_chart(closed, KP, KD, ("modulus_margin",))
    with pytest.raises(InvalidParameterError, match="at least two values on both axes"):
        stability_chart(closed, KP, Axis("kd", "1/s", [45.0]), ("boundary",))
    for values in ([], [1.0, 1.0], [2.0, 1.0], [0.0, np.nan], [[1.0]]):
        with pytest.raises(InvalidParameterError, match="axis 'kp' must be finite and rise"):
            Axis("kp", "1/s^2", np.array(values))
    with pytest.raises(InvalidParameterError, match=r"no system at 0\.5, 0: .*tau must be > 0"):
        stability_chart(
            lambda f, T: pd_closed(B, 900 * f, 30 * f, T), Axis("f", "", [0.5, 1.0]), Axis("T", "s", [0.0, 0.01])
        )
    misfit = CharacteristicBlocks(np.eye(2), np.zeros((2, 1)), np.zeros((1, 3)), np.zeros((1, 1)), np.array([1.0]))
    with pytest.raises(InvalidParameterError, match=r"DelayLTI\.C2 must have shape"):
        stability_chart(lambda kp, kd: misfit, KP, KD)


def test_a_neutral_loop_is_refused():
    def echo(k: float, lag: float) -> DelayLTI:
        return delay_lti(A=[[-1.0]], B1=[[1.0]], B2=[[1.0]], C1=[[1.0]], C2=[[1.0]], D22=[[k]], tau=[lag])

    with pytest.raises(NeutralSystemError, match="neutral type"):
        stability_chart(echo, Axis("k", "", [0.1, 0.5]), Axis("T", "s", [0.1, 0.2]))
