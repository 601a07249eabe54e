"""Recovery times measured in noise, and the band that a fit predicts, against loops of known recovery."""

import functools

import numpy as np
import pytest
import scipy.signal
import scipy.stats

from flycontrol.errors import InvalidInputError, InvalidParameterError
from flycontrol.identify.gains.drawn_loops import drawn_loops
from flycontrol.identify.gains.fit import fit_gains
from flycontrol.identify.gains.model import Unknown, gain_model
from flycontrol.identify.gains.noise import Noise
from flycontrol.identify.gains.problem import fit_problem
from flycontrol.identify.gains.recoveries import measured_recoveries
from flycontrol.identify.gains.recovery_band import pulse_width, recovery_against_strength, recovery_band
from flycontrol.identify.gains.response import yaw_response
from flycontrol.identify.gains.smoothing import autocovariance, smoothed
from flycontrol.model.recovery import recovery_curve
from flycontrol.model.trial import Pulse, TorqueTrace, Trial
from flycontrol.model.yaw import YawLoop
from flycontrol.units import deg, ms

FLY = {"kp": 3050.0, "kd": 45.0, "delay": 0.0136, "damping": 69.0}
PULSE = Pulse(onset=0.01, duration=0.0045)
TIMES = np.arange(0.0, 0.12, 0.0005)
MODEL = gain_model(fixed={"initial_yaw": 0.0, "initial_rate": 0.0, "damping": 69.0})


def recorded(seed, peak=20.0, noise=0.3, *, times=TIMES, heading=0.3, name="fly"):
    yaw = yaw_response(FLY | {"impulse": 1.0}, times, PULSE).yaw
    whole = yaw_response(FLY | {"impulse": 1.0}, TIMES, PULSE).yaw
    rng = np.random.default_rng(seed)
    coloured = scipy.signal.lfilter([np.sqrt(1 - 0.66**2)], [1, -0.66], rng.standard_normal(len(times) + 50))[50:]
    yaw = heading + yaw * peak * deg / np.abs(whole).max() + noise * deg * coloured
    return Trial(name=name, time=times, yaw=yaw, rate=2000.0, perturbation=PULSE)


def fitted(trials, noise=1):
    return fit_gains(trials, MODEL, noise=noise)


@functools.cache
def true_recovery(peak):
    loop = YawLoop.from_rates(b=69, kp=3050, kd=45, delay=0.0136)
    return float(recovery_curve(loop, PULSE.duration, [peak * deg]).times[0])


def test_without_noise_the_measured_recovery_is_that_of_the_loop():
    trials = [recorded(0, peak, 1e-6, name=f"{peak} deg") for peak in (5.0, -10.0, 20.0, 35.0)]
    for recovery, peak in zip(measured_recoveries(fitted(trials, "white")), (5.0, -10.0, 20.0, 35.0), strict=True):
        assert abs(recovery.time - true_recovery(abs(peak))) < 0.02 * ms, peak  # straight between samples 0.5 ms apart
        assert abs(recovery.peak / deg - peak) < 0.01 * abs(peak)
        assert abs(recovery.heading - 0.3) < 1e-6
        assert recovery.low <= recovery.time <= recovery.high


@pytest.mark.parametrize("seeds", [40, pytest.param(300, marks=pytest.mark.slow)])
def test_95_percent_intervals_of_a_measured_recovery_hold_the_true_one(seeds):
    inside = peaks = 0
    widths = []
    for seed in range(seeds):
        (recovery,) = measured_recoveries(fitted([recorded(seed)]))
        inside += recovery.low <= true_recovery(20.0) <= recovery.high
        peaks += abs(recovery.peak - 20 * deg) < 1.96 * recovery.peak_error
        widths.append(recovery.high - recovery.low)
    assert np.median(widths) < 15 * ms  # some see the second swing, 1.3 deg, touch the band's edge
    least = scipy.stats.binom.ppf(0.0005, seeds, 0.95)
    assert inside >= least
    assert peaks >= scipy.stats.binom.ppf(0.0005, seeds, 0.93)  # the largest of noisy values is a little too large


def test_a_fly_that_never_left_the_band_recovers_in_no_time():
    (recovery,) = measured_recoveries(fitted([recorded(0, peak=1.5, noise=0.05)]))
    assert (recovery.time, recovery.low) == (0.0, 0.0)
    assert recovery.sentence == "fly: never left the band."


def test_a_recording_that_ends_too_early_says_so():
    (recovery,) = measured_recoveries(fitted([recorded(0, times=TIMES[TIMES < 0.055])]))
    assert not recovery.recovered
    assert recovery.time == recovery.high == np.inf
    assert recovery.sentence == "fly: not recovered within the 44 ms that the recording shows after the onset."


def test_a_recording_without_perturbation_has_no_recovery():
    still = Trial(
        name="still",
        time=TIMES,
        yaw=0.005 * np.random.default_rng(0).standard_normal(len(TIMES)),
        rate=2000.0,
        perturbation=None,
    )
    both = fit_gains([recorded(0), still], MODEL, noise="white")
    assert [recovery.trial for recovery in measured_recoveries(both)] == ["fly"]


@pytest.mark.parametrize("seeds", [25, pytest.param(300, marks=pytest.mark.slow)])
def test_95_percent_bands_hold_the_true_recovery_time_in_95_percent_of_recordings(seeds):
    peaks = np.array([4.0, 12.0, 30.0])
    truth = np.array([true_recovery(peak) for peak in peaks])
    inside = np.zeros(3)
    for seed in range(seeds):
        band = recovery_band(fitted([recorded(seed)]), peaks * deg, draws=60, seed=seed)
        inside += (band.low <= truth) & (truth <= band.high)
    low, high = scipy.stats.binom.ppf([0.0005, 0.9995], seeds, 0.95)
    assert np.all(low <= inside), inside
    assert seeds < 100 or np.all(inside <= max(high, 0.985 * seeds)), inside  # sixty draws round outwards


def test_measured_points_of_the_same_fly_agree_with_its_band():
    trials = [recorded(k, peak, name=f"recording {k}") for k, peak in enumerate((6.0, -12.0, 18.0, 25.0))]
    found = recovery_against_strength(fitted(trials), draws=60)
    assert found.agreeing == len(found.measured) == 4
    assert found.band.peaks[0] < 2.1 * deg < 25 * deg < found.band.peaks[-1]
    assert np.all(found.band.low <= found.band.times)
    assert np.all(found.band.times <= found.band.high)
    np.testing.assert_allclose(found.expected.peaks, [abs(recovery.peak) for recovery in found.measured])
    assert found.sentence.startswith("4 of 4 recordings show a recovery")


def test_draws_have_the_covariance_of_the_fit():
    found = fitted([recorded(0)], noise="white")
    drawn = drawn_loops(found, 4000, 1)[:, 1:4]
    places = [found.problem.names.index(name) for name in ("kp", "kd", "delay")]
    errors = np.sqrt(np.diag(found.covariance)[places])
    assert np.all(np.abs(drawn.std(axis=0) / errors - 1) < 4 / np.sqrt(2 * 4000) + 0.01)  # Student's is wider by 1/f
    np.testing.assert_array_equal(drawn_loops(found, 3, 1), drawn_loops(found, 3, 1))


def test_a_pulse_is_as_wide_as_it_is_long_and_a_triangle_three_quarters():
    triangle = TorqueTrace(time=np.array([0.01, 0.013, 0.016]), drive=np.array([0.0, 2.0, 0.0]), unit="A")
    by_trace = Trial(name="trace", time=TIMES, yaw=recorded(0).yaw, rate=2000.0, perturbation=triangle)
    assert abs(pulse_width(fit_problem([recorded(0)], MODEL)) - PULSE.duration) < 1e-12
    assert abs(pulse_width(fit_problem([by_trace], MODEL)) - 0.75 * 0.006) < 1e-12


def test_smoothing_keeps_a_parabola_and_knows_its_error_in_coloured_noise():
    times = np.arange(101) / 1000
    noise = Noise(0.4, np.array([0.7]), np.eye(2))
    curve = 3 + 20 * times - 90 * times**2
    np.testing.assert_allclose(smoothed(times, curve, noise, 0.1, 0.03).values, curve, atol=1e-12)
    rng, errors = np.random.default_rng(0), []
    for _ in range(150):
        sample = scipy.signal.lfilter([0.4], [1, -0.7], rng.standard_normal(151))[50:]
        errors.append(smoothed(times, sample, noise, 0.1, 0.03).values)
    stated = smoothed(times, curve, noise, 0.1, 0.03).errors
    ratio = np.std(errors, axis=0) / stated
    assert np.all(np.abs(ratio - 1) < 4.5 / np.sqrt(300))
    assert stated[0] > 1.5 * stated[50]


def test_noise_that_is_small_enough_is_hardly_smoothed_and_large_noise_much():
    times = np.arange(101) / 1000
    small, large = (smoothed(times, times, Noise(s, np.zeros(0), np.eye(1)), 0.1, 0.03) for s in (0.05, 5.0))
    assert small.window == pytest.approx(0.004)
    assert large.window == pytest.approx(0.03)


def test_autocovariances_obey_the_equation_of_the_noise():
    noise = Noise(0.3, np.array([0.8, -0.3, 0.2]), np.eye(4))
    r, phi = autocovariance(noise, 12), noise.coefficients
    assert abs(r[0] - phi @ r[1:4] - 0.3**2) < 1e-12
    for k in range(1, 12):
        assert abs(r[k] - sum(phi[j] * r[abs(k - j - 1)] for j in range(3))) < 1e-12


def test_what_has_no_recovery_is_refused_in_a_sentence():
    found = fitted([recorded(0)], "white")
    with pytest.raises(InvalidParameterError, match="must be > 0 rad"):
        measured_recoveries(found, tolerance=0.0)
    with pytest.raises(InvalidParameterError, match="Peaks and tolerance"):
        recovery_band(found, [0.0])
    own = gain_model(
        fixed={"initial_yaw": 0.0, "initial_rate": 0.0, "damping": 69.0}, settings={"kp": Unknown(shared="fly")}
    )
    with pytest.raises(InvalidInputError, match="do not share kp"):
        recovery_band(fit_gains([recorded(0)], own, noise="white"), [0.3])
