"""Figures of the benchmark loop, b = 20, kp = 900, kd = 55, T = 13.6 ms, by general code and by closed form."""

import mpmath
import numpy as np
import pytest
from pd_loop import KD, KP, B, T, crossover, largest_delay, pd_closed, pd_open
from scipy.optimize import brentq

from flycontrol.delay.margins import margins
from flycontrol.delay.spectrum import rightmost_roots


def abscissa(**changed):
    return rightmost_roots(pd_closed(**changed), 1).abscissa


def printed(value: float, figure: str) -> None:
    """The value, rounded to the figure's digits, is the figure."""
    assert f"{value:.{len(figure.split('.')[1])}f}" == figure


def test_the_rightmost_root_is_the_published_one():
    assert rightmost_roots(pd_closed(), 3).roots[0] == pytest.approx(-15.3021682879626, abs=1e-10)


def test_the_next_pair_is_the_published_one():
    upper, lower = rightmost_roots(pd_closed(), 3).roots[1:3]
    assert upper == lower.conjugate()
    printed(upper.real, "-39.8216")
    printed(upper.imag, "86.7614")


def test_the_rightmost_roots_are_those_of_forty_digits():
    with mpmath.workdps(40):

        def f(s):
            return s**2 + B * s + (KD * s + KP) * mpmath.exp(-s * mpmath.mpf(T))

        for start in (-15.3, -39.8 + 86.8j):
            exact = complex(mpmath.findroot(f, start))
            nearest = min(rightmost_roots(pd_closed(), 4).roots, key=lambda root: abs(root - exact))
            assert abs(nearest - exact) < 1e-12 * abs(exact)


def test_the_largest_stable_delay_is_where_the_rightmost_root_crosses():
    found = brentq(lambda delay: abscissa(T=delay), 0.02, 0.04, xtol=1e-15)
    printed(1e3 * found, "30.2732")
    assert found == pytest.approx(largest_delay(B, KP, KD), rel=1e-12)


def test_the_delay_margin_leads_to_the_largest_stable_delay():
    printed(1e3 * (T + margins(pd_open()).delay_margin), "30.2732")
    assert T + margins(pd_open()).delay_margin == pytest.approx(largest_delay(B, KP, KD), rel=1e-12)


def test_the_critical_derivative_gain_is_where_the_rightmost_root_crosses():
    found = brentq(lambda kd: abscissa(kd=kd), 100.0, 150.0, xtol=1e-12)
    printed(found, "124.431")


def test_the_critical_derivative_gain_spends_the_whole_delay_margin():
    """The delay that a loop with this kd could bear is the delay that it has."""
    found = brentq(lambda kd: margins(pd_open(kd=kd, T=1e-4)).delay_margin + 1e-4 - T, 100.0, 150.0, xtol=1e-10)
    printed(found, "124.431")


def test_the_critical_derivative_gain_lies_on_the_d_curve():
    """kp = w^2 cos wT + b w sin wT, kd = w sin wT - b cos wT."""
    w = brentq(lambda w: w**2 * np.cos(w * T) + B * w * np.sin(w * T) - KP, 100.0, 150.0, xtol=1e-12)
    printed(w * np.sin(w * T) - B * np.cos(w * T), "124.431")


def test_the_only_gain_crossover_is_that_of_the_closed_form():
    assert margins(pd_open()).gain_crossovers == pytest.approx([crossover(B, KP, KD)], rel=1e-13)
