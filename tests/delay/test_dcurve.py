import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pd_loop import pd_closed
from random_systems import drawn_alike, random_system

from flycontrol.delay.chart import Axis, StabilityChart, stability_chart
from flycontrol.delay.count import count_right_of
from flycontrol.delay.dcurve import pd_boundary
from flycontrol.delay.spectrum import rightmost_roots
from flycontrol.delay.system import characteristic_matrix, delay_lti
from flycontrol.errors import InvalidParameterError

B, T = 68.63, 3 / 220


def bounded(system_at, x: np.ndarray, y: np.ndarray) -> StabilityChart:
    return stability_chart(system_at, Axis("x", "", x), Axis("y", "", y), ("boundary",))


@pytest.fixture(scope="module")
def pd_chart():
    return bounded(lambda kp, kd: pd_closed(B, kp, kd, T), np.linspace(-1000, 12000, 16), np.linspace(-100, 300, 16))


@drawn_alike
@given(st.floats(0.0, 200.0), st.floats(1e-3, 1.0), st.floats(0.0, 60.0))
def test_on_the_closed_form_boundary_a_root_lies_on_the_axis(b, T, turn):
    """s^2 + b s + (kp + kd s) exp(-sT) at s = jw."""
    w = turn / T
    gains = pd_boundary(b, T, w)
    terms = np.array([-(w**2), 1j * b * w, gains.kp * np.exp(-1j * w * T), 1j * w * gains.kd * np.exp(-1j * w * T)])
    assert abs(terms.sum()) <= 1e-13 * np.abs(terms).sum()


@pytest.mark.parametrize("omega", [20.0, 60.0, 100.0, 140.0])
def test_the_spectrum_has_a_root_at_the_boundarys_frequency(omega):
    gains = pd_boundary(B, T, omega)
    roots = rightmost_roots(pd_closed(B, float(gains.kp), float(gains.kd), T), 6).roots
    assert np.abs(roots - 1j * omega).min() < 1e-10 * omega


def test_the_traced_boundary_of_the_pd_loop_is_the_closed_form(pd_chart):
    static, moving = sorted(pd_chart.boundary, key=lambda curve: not curve.static)
    gains = pd_boundary(B, T, moving.omega)
    # a point is exact to rounding of the box, 13000 1/s^2 by 400 1/s
    np.testing.assert_allclose(moving.x, gains.kp, atol=1e-14 * 13000)
    np.testing.assert_allclose(moving.y, gains.kd, atol=1e-14 * 400)
    np.testing.assert_allclose(static.x, 0.0, atol=1e-14 * 13000)
    assert (static.omega == 0).all()
    assert (static.y.min(), static.y.max()) == pytest.approx((-100.0, 300.0))


def test_the_curve_of_pairs_ends_where_it_leaves_the_box_and_where_its_frequency_vanishes(pd_chart):
    """At w -> 0 the closed form tends to kp = 0, kd = -b, on the static boundary."""
    (moving,) = [curve for curve in pd_chart.boundary if not curve.static]
    low, high = sorted((0, -1), key=lambda end: moving.omega[end])
    assert moving.x[low] == pytest.approx(0.0, abs=1e-6 * 13000)
    assert moving.y[low] == pytest.approx(-B, rel=1e-6)
    assert moving.x[high] == pytest.approx(-1000.0, rel=1e-14)


def test_the_number_of_unstable_roots_changes_by_two_across_the_curve_of_pairs(pd_chart):
    (moving,) = [curve for curve in pd_chart.boundary if not curve.static]
    for k in range(3, len(moving.x) - 3, 6):
        along = np.array([moving.x[k + 1] - moving.x[k - 1], moving.y[k + 1] - moving.y[k - 1]]) / [13000, 400]
        across = np.array([-along[1], along[0]]) / np.linalg.norm(along) * [13000, 400]
        sides = [
            count_right_of(pd_closed(B, moving.x[k] + e * across[0], moving.y[k] + e * across[1], T), 0.0).roots
            for e in (-1e-4, 1e-4)
        ]
        assert abs(sides[1] - sides[0]) == 2


def test_the_number_of_unstable_roots_changes_by_one_across_the_static_boundary(pd_chart):
    for kd in (-90.0, 0.0, 100.0, 250.0):
        left, right = (count_right_of(pd_closed(B, kp, kd, T), 0.0).roots for kp in (-1.0, 1.0))
        assert abs(left - right) == 1


def test_the_boundary_of_a_delayed_integrator_is_a_family_of_hyperbolas():
    """x' = -k x(t - T): k T = pi/2 + 2 pi m and w = k."""
    chart = bounded(
        lambda k, T: delay_lti(A=[[0.0]], B1=[[1.0]], B2=[[-k]], C1=[[1.0]], C2=[[1.0]], tau=[T]),
        np.linspace(0.5, 15.0, 14),
        np.linspace(0.1, 1.6, 14),
    )
    turns = [(curve.x * curve.y - np.pi / 2) / (2 * np.pi) for curve in chart.boundary]
    for turn, curve in zip(turns, chart.boundary, strict=True):
        np.testing.assert_allclose(turn, round(turn[0]), atol=1e-13)
        np.testing.assert_allclose(curve.omega, curve.x, rtol=1e-13)
    assert sorted(round(turn[0]) for turn in turns) == [0, 1, 2, 3]


def test_a_boundary_that_closes_is_traced_once_around():
    """x' = -k x(t - 1) loses stability at k = pi/2, here on the circle k = pi/2 - 1/4 + u^2 + v^2."""
    centre = np.pi / 2 - 0.25

    def system_at(u: float, v: float):
        return delay_lti(
            A=[[0.0]], B1=[[1.0]], B2=[[-(centre + u**2 + v**2)]], C1=[[1.0]], C2=[[1.0]], tau=[1.0]
        )  # fmt: skip

    chart = bounded(system_at, np.linspace(-1, 1, 9), np.linspace(-1, 1, 9))
    (circle,) = chart.boundary
    np.testing.assert_allclose(np.hypot(circle.x, circle.y), 0.5, rtol=1e-12)
    assert (circle.x[0], circle.y[0]) == (circle.x[-1], circle.y[-1])
    turn = np.unwrap(np.arctan2(circle.y, circle.x))
    assert abs(turn[-1] - turn[0]) == pytest.approx(2 * np.pi)


@pytest.mark.parametrize("kind", range(3))
def test_every_traced_point_of_random_families_has_a_root_on_the_axis(kind):
    """Two delays against each other, a gain against a delay, a plant matrix against a gain."""
    points = 0
    for seed in range(kind, 18, 3):
        x = random_system(seed, 1 + seed % 4, 2, chained=seed % 4 == 0)
        direction = np.random.default_rng(seed + 5).normal(size=x.A.shape)

        def member(A=x.A, B2=x.B2, tau=x.tau, x=x):
            return delay_lti(A=A, B1=x.B1, B2=B2, C1=x.C1, C2=x.C2, D22=x.D22, tau=tau)

        system_at = [
            lambda u, v, member=member: member(tau=np.array([u, v])),
            lambda u, v, member=member, x=x: member(B2=u * x.B2, tau=np.array([v, x.tau[1]])),
            lambda u, v, member=member, x=x, d=direction: member(A=x.A + u * d, B2=v * x.B2),
        ][kind]
        axes = [(0.05, 2.0, 0.05, 2.0), (-2.0, 2.0, 0.05, 2.0), (-2.0, 2.0, -2.0, 2.0)][kind]
        chart = bounded(system_at, np.linspace(*axes[:2], 10), np.linspace(*axes[2:], 10))
        for curve in chart.boundary:
            for u, v, w in zip(curve.x, curve.y, curve.omega, strict=True):
                sizes = np.linalg.svd(characteristic_matrix(system_at(u, v), 1j * w), compute_uv=False)
                assert sizes[-1] < 1e-12 * sizes[0]
                points += 1
        changes = np.diff(chart.unstable_roots, axis=0).any() or np.diff(chart.unstable_roots, axis=1).any()
        assert bool(chart.boundary) == changes
    assert points > 100


def test_values_without_meaning_are_refused():
    with pytest.raises(InvalidParameterError, match="delay >= 0"):
        pd_boundary(20.0, -0.1, [1.0])
    with pytest.raises(InvalidParameterError, match="finite b and omega"):
        pd_boundary(20.0, 0.1, [np.nan])
