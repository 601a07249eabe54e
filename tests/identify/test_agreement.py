import numpy as np
import pytest

from flycontrol.errors import InvalidInputError
from flycontrol.identify.agreement import agreement


def test_what_agrees_agrees_whatever_the_flights_means():
    rng = np.random.default_rng(1)
    required = [rng.standard_normal(30), 5.0 + rng.standard_normal(20)]
    found = agreement([2 * required[0] + 7, 2 * required[1] - 3], required)
    for estimate, value in ((found.correlation, 1.0), (found.slope, 2.0), (found.slope_of_required, 0.5)):
        assert (estimate.low, estimate.value, estimate.high) == pytest.approx((value, value, value), rel=1e-12)
    assert found.wingbeats == 50


def test_noise_of_what_is_supplied_lowers_correlation_and_one_slope_only():
    """Noise of standard deviation 2 on unit signal: r = 1 / sqrt(5), slopes 1 and 1 / 5; errors of 1 / sqrt(n)."""
    rng = np.random.default_rng(2)
    required = rng.standard_normal(40000)
    found = agreement([required + 2 * rng.standard_normal(40000)], [required])
    assert found.correlation.value == pytest.approx(1 / np.sqrt(5), abs=0.02)
    assert found.slope.value == pytest.approx(1.0, abs=0.05)
    assert found.slope_of_required.value == pytest.approx(0.2, abs=0.01)


def test_memory_widens_the_interval():
    """Each value stands five times: the interval is that of a fifth as many values."""
    rng = np.random.default_rng(3)
    a, b = (rng.standard_normal(80) for _ in range(2))
    once = agreement([a], [b], block=1).correlation
    repeated = [np.repeat(v, 5) for v in (a, b)]
    blind, aware = (agreement([repeated[0]], [repeated[1]], block=n).correlation for n in (1, 15))
    width = [e.high - e.low for e in (once, blind, aware)]
    assert width[1] < 0.55 * width[0]
    assert width[2] > 0.8 * width[0]


def test_series_that_do_not_match_are_refused():
    with pytest.raises(InvalidInputError, match="at least 3"):
        agreement([np.zeros(4)], [np.zeros(5)])
