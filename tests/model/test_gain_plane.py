import numpy as np
import pytest

from flycontrol.delay.frequency import evaluate
from flycontrol.delay.spectrum import rightmost_roots
from flycontrol.model.gain_plane import delay_slice, gain_plane
from flycontrol.model.gains import fastest_decay, gain_crossover
from flycontrol.model.yaw import YawLoop

B, KP, KD, T = 69.0, 3050.0, 45.0, 3 / 220


def fly(kp: float = KP, kd: float = KD, delay: float = T) -> YawLoop:
    return YawLoop.from_rates(b=B, kp=kp, kd=kd, delay=delay)


@pytest.fixture(scope="module")
def plane():
    return gain_plane(fly())


@pytest.fixture(scope="module")
def over_delay():
    return delay_slice(fly())


def test_the_count_and_the_closed_form_agree_at_every_point(plane, over_delay):
    for part in (plane, over_delay):
        assert part.agreeing == part.chart.unstable_roots.size
        assert 0.1 < part.chart.stable.mean() < 0.9  # the chart shows both sides


def test_the_edge_of_the_stable_gains_has_a_root_at_its_frequency(plane):
    for k in range(20, len(plane.edge_omega), 60):
        roots = rightmost_roots(fly(plane.edge.kp[k], plane.edge.kd[k]).closed_loop(), 3).roots
        assert abs(roots[0].real) < 1e-9 * abs(roots[0])
        assert roots[0].imag == pytest.approx(plane.edge_omega[k], rel=1e-10)


def test_the_edge_ends_where_a_real_root_passes_the_origin(plane):
    size = plane.edge.kp.max()
    assert plane.edge.kp[0] == 0
    assert plane.edge.kd[0] == -B
    assert abs(plane.edge.kp[-1]) < 1e-9 * size


def test_no_gains_of_the_chart_decay_faster_than_the_closed_form(plane):
    assert np.nanmax(plane.chart.decay_rate) < plane.fastest_rate
    kp, kd, s0 = fastest_decay(B, T)
    assert plane.fastest == (kp, kd)
    # a triple root is known to the cube root of rounding
    assert fly(kp, kd).poles(1)[0].real == pytest.approx(s0, rel=1e-4)


def test_the_distance_from_minus_one_is_the_modulus_margin_of_a_stable_loop(plane):
    rng = np.random.default_rng(7)
    for i, j in rng.permutation(np.argwhere(plane.chart.stable))[:25]:
        loop = fly(float(plane.chart.x.values[j]), float(plane.chart.y.values[i]))
        assert plane.distance[i, j] == pytest.approx(loop.margins().modulus_margin, rel=1e-9)


def test_both_lines_over_the_delay_carry_a_pair_on_the_imaginary_axis(over_delay):
    for k in (100, 200, 399):
        factor = over_delay.factor[k]
        wc = gain_crossover(B, factor * KP, factor * KD)
        for delay in (over_delay.largest_stable_delay[k], over_delay.next_crossing[k]):
            L = fly(factor * KP, factor * KD, delay).open_loop()
            assert evaluate(L, np.array([wc]))[0] == pytest.approx(-1.0, abs=1e-9)


def test_a_loop_far_off_keeps_the_stable_region_in_sight():
    far = gain_plane(fly(kp=1e7, kd=-1e4))
    assert far.chart.stable.sum() > 50
    assert far.chart.x.values[-1] < 1e7


@pytest.mark.parametrize("gains", [{"kp": -10.0}, {"kd": -70.0}, {"delay": 0.0}])
def test_there_is_no_slice_where_no_delay_is_stable(gains):
    assert delay_slice(fly(**gains)) is None


def test_there_is_no_plane_without_a_delay():
    assert gain_plane(fly(delay=0.0)) is None


@pytest.mark.parametrize("delay", [13.6e-3, 0.011504735754005175])
def test_without_damping_the_stable_part_ends_at_a_quarter_of_a_turn(delay):
    """w cos wT = 0 there, where rounding may leave either sign."""
    loop = YawLoop.from_rates(b=0.0, kp=500.0, kd=30.0, delay=delay)
    assert gain_plane(loop).edge_omega[-1] == pytest.approx(np.pi / 2 / delay, rel=1e-12)
