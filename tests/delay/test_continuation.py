import numpy as np
import pytest
from pd_loop import largest_delay, newton_step, pd_closed, pd_open
from random_systems import random_system

from flycontrol.delay.interconnect import append, delay, feedback, series
from flycontrol.delay.locus import RootLocus, root_locus
from flycontrol.delay.margins import margins
from flycontrol.delay.spectrum import rightmost_roots
from flycontrol.delay.system import DelayLTI, delay_lti
from flycontrol.errors import InvalidParameterError, NeutralSystemError

B, KP, KD, T = 68.63, 3050.0, 45.0, 3 / 220  # the nominal yaw loop


def scaled(factor: float) -> DelayLTI:
    return pd_closed(B, factor * KP, factor * KD, T)


def delayed(T: float) -> DelayLTI:
    return pd_closed(B, KP, KD, T)


def delayed_integrator(k: float) -> DelayLTI:
    """s = -k exp(-s / 4)."""
    return delay_lti(A=[[0.0]], B1=[[1.0]], B2=[[-k]], C1=[[1.0]], C2=[[1.0]], tau=[0.25])


def at(locus: RootLocus, k: int) -> np.ndarray:
    return locus.branches[np.isfinite(locus.branches[:, k]), k]


@pytest.fixture(scope="module")
def gain_locus():
    return root_locus(scaled, np.geomspace(0.02, 4.0, 120))


@pytest.fixture(scope="module")
def delay_locus():
    return root_locus(delayed, np.geomspace(0.1, 4.0, 120) * T)


def test_the_locus_crosses_the_axis_in_the_gain_where_the_gain_margin_says(gain_locus):
    loop = margins(pd_open(B, KP, KD, T))
    (crossing,) = gain_locus.crossings
    assert gain_locus.status == "certified"
    assert crossing.value == pytest.approx(loop.gain_margin, rel=1e-12)
    assert crossing.frequency == pytest.approx(loop.phase_crossovers[0], rel=1e-12)
    assert crossing.rightward


def test_the_locus_crosses_the_axis_in_the_delay_where_the_delay_margin_is_spent(delay_locus):
    loop = margins(pd_open(B, KP, KD, T))
    (crossing,) = delay_locus.crossings
    assert delay_locus.status == "certified"
    assert crossing.value == pytest.approx(T + loop.delay_margin, rel=1e-12)
    assert crossing.value == pytest.approx(largest_delay(B, KP, KD), rel=1e-12)
    assert crossing.frequency == pytest.approx(loop.gain_crossovers[0], rel=1e-12)
    assert crossing.rightward


def test_where_two_roots_meet_the_characteristic_equation_and_its_derivative_vanish(gain_locus, delay_locus):
    for locus, loop in ((gain_locus, lambda f: (f * KP, f * KD, T)), (delay_locus, lambda T: (KP, KD, T))):
        (meeting,) = locus.collisions
        (kp, kd, lag), s = loop(meeting.value), meeting.root
        delayed_part = (kd * s + kp) * np.exp(-s * lag)
        terms = np.array([s**2, B * s, delayed_part])
        slopes = np.array([2 * s, B, kd * np.exp(-s * lag), -lag * delayed_part])
        assert abs(terms.sum()) < 1e-13 * np.abs(terms).sum()
        assert abs(slopes.sum()) < 1e-13 * np.abs(slopes).sum()
        assert not meeting.splits


def test_two_roots_of_a_delayed_integrator_meet_at_1_over_e_and_cross_at_half_pi():
    """s = -k exp(-s T): double root -1/T at k T = 1/e; roots +-jw at k = w = (pi/2 + 2 pi m) / T."""
    locus = root_locus(delayed_integrator, np.linspace(0.5, 40.0, 30), count=6)
    (meeting,) = locus.collisions
    assert (meeting.value, meeting.root) == pytest.approx((4 / np.e, -4.0), rel=1e-12)
    exact = 4 * np.array([np.pi / 2, 5 * np.pi / 2])
    assert [c.value for c in locus.crossings] == pytest.approx(exact, rel=1e-13)
    assert [c.frequency for c in locus.crossings] == pytest.approx(exact, rel=1e-13)
    assert all(c.rightward for c in locus.crossings)


def test_the_right_one_of_two_real_roots_becomes_the_upper_one_of_the_pair(gain_locus):
    (meeting,) = gain_locus.collisions
    through, ends = (gain_locus.branches[b] for b in meeting.branches)
    before = gain_locus.values < meeting.value
    assert (through[before].imag == 0).all()
    assert (ends[before].imag == 0).all()
    assert (ends[before].real < through[before].real).all()
    assert (through[~before].imag > 0).all()
    assert np.isnan(ends[~before]).all()


def test_backwards_the_same_branches_are_found_and_the_pair_splits_to_the_right(gain_locus):
    back = root_locus(scaled, gain_locus.values[::-1])
    (meeting,) = back.collisions
    right, left = (back.branches[b][-1] for b in meeting.branches)
    assert left.real < right.real
    for k in (0, 60, 119):
        here, there = (np.sort_complex(at(locus, i)) for locus, i in ((gain_locus, k), (back, 119 - k)))
        many = min(len(here), len(there))  # the two ends may bring in other roots from the far left
        np.testing.assert_allclose(here[-many:], there[-many:], rtol=1e-12)


def random_family(seed: int):
    """Systems of 1 to 4 states and 1 to 3 delays over a gain, a delay or a plant matrix, and the values."""
    x = random_system(seed, 1 + seed % 4, 1 + seed % 3, chained=seed % 2 == 0)
    direction = np.random.default_rng(seed + 10**6).normal(size=x.A.shape)

    def member(A=x.A, B2=x.B2, tau=x.tau) -> DelayLTI:
        return delay_lti(A=A, B1=x.B1, B2=B2, C1=x.C1, C2=x.C2, D22=x.D22, tau=tau)

    return [
        (lambda v: member(B2=v * x.B2), np.linspace(0.1, 2.0, 9)),
        (lambda v: member(tau=np.append(x.tau[:-1], v)), np.linspace(0.1, 2.0, 9)),
        (lambda v: member(A=x.A + v * direction), np.linspace(-1.0, 1.0, 9)),
    ][seed % 3]


@pytest.mark.parametrize("seeds", [range(30), pytest.param(range(30, 200), marks=pytest.mark.slow)])
def test_the_branches_of_random_loops_hold_every_root_that_the_certified_spectrum_has(seeds):
    """Two hundred loops in all, a third of them over a gain, over a delay, and over a plant matrix."""
    checked = 0
    for seed in seeds:
        system_at, values = random_family(seed)
        locus = root_locus(system_at, values, count=6)
        assert locus.status == "certified", seed
        for k in (0, 5, 8):
            spectrum = rightmost_roots(system_at(values[k]), 6)
            if spectrum.status != "certified":
                continue
            upper = spectrum.roots[spectrum.roots.imag >= 0]
            apart = np.abs(upper[:, None] - at(locus, k)[None, :])
            # simple roots to rounding; 1e-8 leaves room for a pair of them close together
            assert (apart.min(axis=1) < 1e-8 * np.abs(upper)).all(), seed
            assert len(set(apart.argmin(axis=1))) == len(upper), seed
            checked += 1
    assert checked > 2.8 * len(seeds)


@pytest.mark.parametrize("seed", [*range(12), *(pytest.param(seed, marks=pytest.mark.slow) for seed in range(12, 60))])
def test_a_finer_grid_joins_the_same_roots(seed):
    """Were a branch to jump to another root on the coarse grid, it would not on one four times as fine."""
    system_at, values = random_family(seed)
    coarse = root_locus(system_at, values, count=6)
    fine = root_locus(system_at, np.interp(np.arange(33) / 4, np.arange(9), values), count=6)
    for branch in coarse.branches:
        present = np.flatnonzero(np.isfinite(branch))
        first = present[0]
        same = np.abs(fine.branches[:, 4 * first] - branch[first]) < 1e-8 * abs(branch[first])
        for twin in fine.branches[same]:
            np.testing.assert_allclose(twin[4 * present], branch[present], rtol=1e-8)
    assert len(fine.crossings) == len(coarse.crossings)


def test_a_branch_that_enters_from_the_far_left_is_followed_back_to_the_first_value(delay_locus):
    assert len(delay_locus.entries) > 0
    for entry in delay_locus.entries:
        branch = delay_locus.branches[entry.branch]
        k = np.flatnonzero(delay_locus.values == entry.value)[0]
        assert branch[k] == entry.root
        assert np.isfinite(branch[: k + 1]).all()
        assert branch[0].real < branch[k].real


def test_a_delay_that_goes_to_zero_leaves_the_poles_without_delay():
    plant = delay_lti(A=[[0.0, 1.0], [0.0, -B]], B1=[[0.0], [1.0]], C1=[[KP, KD]])
    poles = np.roots([1.0, B + KD, KP])

    def closed(T: float) -> DelayLTI:
        return feedback(series(delay(T), plant))

    for values in (np.linspace(0.0, 0.01, 6), np.linspace(0.01, 0.0, 6)):
        locus = root_locus(closed, values, count=4)
        k = 0 if values[0] == 0 else -1
        assert locus.status == "certified"
        np.testing.assert_allclose(np.sort(at(locus, k).real), np.sort(poles.real), rtol=1e-13)
        (meeting,) = locus.collisions
        assert (meeting.value, meeting.root) == pytest.approx((0.008055590316757, -127.931464065), rel=1e-9)


def test_a_double_integrator_leaves_the_origin_as_a_pair_when_its_gain_rises_from_zero():
    """s^2 = -4 g + O(g^(3/2)): a collision at the first value."""
    locus = root_locus(lambda g: pd_closed(0.0, 4.0 * g, 3.0 * g, 0.1), np.array([0.0, 1e-6, 0.5, 1.0]), count=4)
    meeting = locus.collisions[0]
    assert locus.status == "certified"
    assert (meeting.value, meeting.root, meeting.splits) == (0.0, 0.0, False)
    assert locus.branches[meeting.branches[0], 1] == pytest.approx(2e-3j, rel=2e-3)


def test_values_at_a_collision_show_the_double_root_on_both_branches(gain_locus):
    (meeting,) = gain_locus.collisions
    for values in ([0.3, 0.45, meeting.value, 0.7, 1.0], [0.3, meeting.value], [meeting.value, 0.7]):
        locus = root_locus(scaled, values)
        k = values.index(meeting.value)
        (again,) = locus.collisions
        assert locus.status == "certified"
        # a double root moves by the square root of rounding
        np.testing.assert_allclose(locus.branches[list(again.branches), k], meeting.root, rtol=1e-7)


def test_a_loop_with_two_delays_crosses_the_axis_where_both_of_them_say():
    """x' = -x(t - 1) - k x(t - h): at a crossing jw + exp(-jw) + k exp(-jwh) = 0."""
    h = np.sqrt(2) / 3

    def system_at(k: float) -> DelayLTI:
        return delay_lti(A=[[0.0]], B1=[[1.0]], B2=[[-1.0, -k]], C1=[[1.0]], C2=[[1.0], [1.0]], tau=[1.0, h])

    locus = root_locus(system_at, np.linspace(0.0, 20.0, 21))
    assert len(locus.crossings) >= 2
    for crossing in locus.crossings:
        s = 1j * crossing.frequency
        assert abs(s + np.exp(-s) + crossing.value * np.exp(-s * h)) < 1e-12 * abs(s)


def test_equal_parts_side_by_side_are_said_to_be_joined_by_the_least_jump():
    locus = root_locus(lambda f: append(scaled(f), scaled(f)), [0.2, 0.3, 0.4], count=6)
    assert locus.status.startswith("not certified: roots between 0.2 and 0.3 are joined by the least jump")
    for factor, k in ((0.2, 0), (0.4, 2)):
        # double roots: half of the digits
        assert max(newton_step(root, B, factor * KP, factor * KD, T) / abs(root) for root in at(locus, k)) < 1e-6


def test_values_that_neither_rise_nor_fall_are_refused():
    for values in ([1.0], [1.0, 2.0, 1.5], [1.0, 1.0], [[1.0, 2.0]]):
        with pytest.raises(InvalidParameterError, match="at least two parameter values that rise or fall"):
            root_locus(scaled, values)
    with pytest.raises(InvalidParameterError, match="finite"):
        root_locus(scaled, [0.0, np.inf])
    with pytest.raises(InvalidParameterError, match="count >= 1"):
        root_locus(scaled, [0.5, 1.0], count=0)


def test_a_family_that_refuses_a_value_is_refused_with_the_value_and_the_way_out():
    with pytest.raises(InvalidParameterError, match=r"no system at 0: .*tau must be > 0.*identity there"):
        root_locus(delayed, [0.0, 0.01])
    with pytest.raises(InvalidParameterError, match="must return a DelayLTI, got 3"):
        root_locus(lambda v: 3, [0.0, 0.01])  # pyright: ignore


def test_a_neutral_family_is_refused():
    def echo(k: float) -> DelayLTI:
        return delay_lti(A=[[-1.0]], B1=[[1.0]], B2=[[1.0]], C1=[[1.0]], C2=[[1.0]], D22=[[k]], tau=[1.0])

    with pytest.raises(NeutralSystemError, match=r"At 0\.5: .*neutral type.*lag"):
        root_locus(echo, [0.0, 1.0])
