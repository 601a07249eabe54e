from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from random_systems import drawn_alike, random_points, random_system

from flycontrol.delay import DelayLTI, delay, delay_lti, feedback, is_retarded, rightmost_roots, series, static_gain
from flycontrol.delay.algebraic_loop import closed_directly
from flycontrol.delay.redundancy import merge_delays
from flycontrol.errors import AlgebraicLoopError

seeds = st.integers(0, 2**32 - 1)
POINTS = random_points(9)


def split(system: DelayLTI, seed: int) -> DelayLTI:
    """Every channel twice, fed alike; each reader of its delayed signal reads one of the two."""
    x, q = system, system.n_delays
    readers = np.vstack([x.B2, x.D12, x.D22])
    second = np.random.default_rng(seed).integers(0, 2, size=readers.shape)
    B2, D12, D22 = np.split(np.hstack([readers * (1 - second), readers * second]), [x.n_states, len(readers) - q])
    C2, D21, D22 = (np.vstack([block, block]) for block in (x.C2, x.D21, D22))
    return replace(x, B2=B2, D12=D12, C2=C2, D21=D21, D22=D22, tau=np.tile(x.tau, 2))


def transposed(system: DelayLTI) -> DelayLTI:
    x = system
    return DelayLTI(x.A.T, x.C1.T, x.C2.T, x.B1.T, x.B2.T, x.D11.T, x.D21.T, x.D12.T, x.D22.T, x.tau)


@drawn_alike
@given(seeds, st.integers(1, 4))
def test_channels_fed_by_one_signal_become_one_again(seed, delays):
    system = random_system(seed, 2, delays, 2, 2, chained=True)
    merged = merge_delays(split(system, seed))
    assert merged.n_delays == delays
    np.testing.assert_allclose(merged(POINTS), system(POINTS), rtol=1e-9, atol=1e-10 * np.abs(system(POINTS)).max())


@drawn_alike
@given(seeds, st.integers(1, 4))
def test_channels_of_which_only_the_sum_is_used_become_one(seed, delays):
    """The transposed statement."""
    system = random_system(seed, 2, delays, 2, 2, chained=True)
    merged = merge_delays(transposed(split(transposed(system), seed)))
    assert merged.n_delays == delays
    np.testing.assert_allclose(merged(POINTS), system(POINTS), rtol=1e-9, atol=1e-10 * np.abs(system(POINTS)).max())


def test_a_delay_written_many_times_in_a_formula_is_one_channel():
    D, P = delay(0.1), random_system(1, 2, 0)
    assert (2 * D + 3 * D - D).n_delays == 1
    assert (P * D + 3 * D).n_delays == 1
    assert (D * P + D * (2 * P)).n_delays == 1
    assert (D + P - D).n_delays == 0
    assert (0 * D).n_delays == 0
    assert (D * D).n_delays == 2
    assert (delay(0.1) + delay(0.2)).n_delays == 2


def test_merging_leaves_every_characteristic_root_where_it_was():
    loop = random_system(4, 3, 1)
    doubled = split(loop, 2)
    one, two = rightmost_roots(merge_delays(doubled), 6), rightmost_roots(doubled, 6)
    np.testing.assert_allclose(one.roots[:6], two.roots[:6], rtol=1e-9)


def test_a_ring_of_delays_that_nothing_feeds_keeps_its_roots():
    """w = 0.5 w(t - 1): hidden, but of neutral type all the same."""
    hidden = delay_lti(A=[[-1.0]], B1=[[1.0]], C1=[[1.0]], D22=[[0.5]], tau=[1.0])
    assert not is_retarded(merge_delays(hidden))


def test_gains_of_any_size_along_a_chain_are_no_algebraic_loop():
    """Torque over inertia in SI units: 1 / 3e-13 kg m^2."""
    chain = series(static_gain(1e13), static_gain(3e12), static_gain(1e13))
    assert chain.D11[0, 0] == pytest.approx(3e38, rel=1e-14)


def test_a_loop_is_judged_in_any_units():
    direct = np.array([[0.0, 0.5e-12], [0.5e12, 0.0]])
    np.testing.assert_allclose(closed_directly(direct), [[4 / 3, 2e-12 / 3], [2e12 / 3, 4 / 3]], rtol=1e-14)
    with pytest.raises(AlgebraicLoopError):
        closed_directly(np.array([[0.0, 1e-12], [1e12, 0.0]]))


def test_a_loop_is_judged_as_a_whole():
    """Signal 1 alone has gain 1 around itself, but signal 2 settles it: det (I - M) = -1."""
    np.testing.assert_allclose(
        closed_directly(np.array([[1.0, 1.0], [1.0, 0.0]])), [[-1.0, -1.0], [-1.0, 0.0]], atol=1e-15
    )


@pytest.mark.parametrize("gain", [1 + 1e-9, 1 - 1e-9])
def test_a_loop_close_to_gain_one_still_has_its_solution(gain):
    assert closed_directly(np.array([[gain]]))[0, 0] == pytest.approx(1 / (1 - gain), rel=1e-12)


@drawn_alike
@given(seeds, st.integers(1, 7))
def test_where_no_path_leads_the_closed_gain_is_exactly_zero(seed, size):
    """Rounding in I - M = L U must not invent paths: they would turn a retarded system neutral."""
    rng = np.random.default_rng(seed)
    direct = rng.normal(size=(size, size)) * (rng.uniform(size=(size, size)) < 0.3)
    closed = closed_directly(direct)
    np.testing.assert_allclose(
        closed, np.linalg.inv(np.eye(size) - direct), rtol=1e-7, atol=1e-8 * np.abs(closed).max()
    )
    paths = np.linalg.matrix_power(np.eye(size) + (direct != 0), size) > 0
    assert not closed[~paths].any()


@drawn_alike
@given(seeds)
def test_direct_paths_that_only_touch_a_retarded_loop_leave_it_retarded(seed):
    rng = np.random.default_rng(seed)
    P, K = (
        random_system(seed, 2, 0, 3, 3),
        static_gain(rng.normal(size=(3, 3)) * 10.0 ** rng.integers(-9, 9, size=(3, 3))),
    )
    assert is_retarded(feedback(P * K * delay(rng.uniform(0.1, 1.0, size=3)), np.eye(3)))
