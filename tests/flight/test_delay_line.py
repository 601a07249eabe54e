"""The delay line and the sensors' filters, against functions that are known."""

import numpy as np
import pytest

from flycontrol.flight.delay_line import DelayLine
from flycontrol.flight.sensors import BodyMotion, Haltere, integrated

STEP = 1e-3
TIME = STEP * np.arange(101)


def line_of(value, rate):
    line = DelayLine(STEP, len(TIME))
    line.write(0, value(TIME), rate(TIME))
    return line


def test_a_cubic_comes_out_exactly_with_its_derivatives():
    cubic = np.polynomial.Polynomial([1.0, -40.0, 900.0, 5e3])
    line = line_of(cubic, cubic.deriv())
    at = np.linspace(0, TIME[-1], 777)
    expected = np.stack([cubic(at), cubic.deriv()(at), cubic.deriv(2)(at)])
    np.testing.assert_allclose(line.read(at), expected, rtol=0, atol=1e-9 * np.abs(expected).max(axis=1).max())


def test_a_sine_is_read_within_the_stated_error():
    """h^4 / 384 max |v''''|: nothing else is lost between entries."""
    w = 300.0
    line = line_of(lambda t: np.sin(w * t), lambda t: w * np.cos(w * t))
    at = np.linspace(0, TIME[-1], 5001)
    error = np.abs(line.read(at)[0] - np.sin(w * at)).max()
    assert 0.9 < error / ((w * STEP) ** 4 / 384) < 1.0


def test_before_the_flight_the_signal_was_as_at_its_beginning():
    line = line_of(lambda t: 2 + 3 * t, lambda t: 3 + 0 * t)
    np.testing.assert_array_equal(line.read(np.array([-1.0, -1e-9])), [[2.0, 2.0], [0.0, 0.0], [0.0, 0.0]])


def test_what_is_written_in_pieces_reads_as_if_written_at_once():
    w, whole = 50.0, line_of(lambda t: np.sin(50 * t), lambda t: 50 * np.cos(50 * t))
    pieces = DelayLine(STEP, len(TIME))
    for first, last in ((0, 1), (1, 40), (39, 101)):
        part = TIME[first:last]
        pieces.write(first, np.sin(w * part), w * np.cos(w * part))
    at = np.linspace(0, TIME[-1], 333)
    np.testing.assert_array_equal(pieces.read(at), whole.read(at))


@pytest.mark.parametrize("tau", [2e-3, 2e-2])
def test_a_haltere_filters_a_turning_rate_as_its_equation_says(tau):
    """tau y' = r - y from y = 0 with r = sin wt; Simpson's rule leaves an error of (w h)^4 order."""
    w = 200.0
    r = np.stack([np.sin(w * TIME), w * np.cos(w * TIME)])
    motion = BodyMotion(heading=np.zeros((3, len(TIME))), yaw_rate=r)
    angle, rate, acceleration = Haltere(time_constant=tau).sensed(motion, None, STEP)
    exact = (np.sin(w * TIME) - w * tau * np.cos(w * TIME) + w * tau * np.exp(-TIME / tau)) / (1 + (w * tau) ** 2)
    np.testing.assert_allclose(rate, exact, rtol=0, atol=2e-4 * np.abs(exact).max())
    np.testing.assert_allclose(acceleration, (r[0] - exact) / tau, rtol=0, atol=2e-4 * np.abs(r[0]).max() / tau)
    turned = (1 - np.cos(w * TIME)) / w
    np.testing.assert_allclose(angle, turned - tau * exact, rtol=0, atol=2e-4 * np.abs(angle).max())


def test_the_integral_of_a_cubic_is_exact():
    cubic = np.polynomial.Polynomial([1.0, -40.0, 900.0, 5e3])
    found = integrated(cubic(TIME), cubic.deriv()(TIME), 0.5, STEP)
    np.testing.assert_allclose(found, 0.5 + cubic.integ()(TIME), rtol=1e-13)
