"""Gains and delay from recordings of known truth."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.stats
from perturbed_fly import AT_REST, PULSE, TIMES, TRUTH, recording

from flycontrol.errors import InvalidInputError, InvalidParameterError
from flycontrol.identify.gains.fit import fit_gains
from flycontrol.identify.gains.model import Prior, Unknown, gain_model
from flycontrol.identify.gains.response import yaw_response
from flycontrol.identify.gains.spoken import spoken, spoken_range
from flycontrol.model.trial import Pulse, TorqueTrace, Trial
from flycontrol.units import deg


def test_without_noise_the_truth_comes_back_from_no_starting_values():
    found = fit_gains([recording(0, noise=1e-9)], gain_model(fixed=AT_REST))
    assert found.converged
    for name, truth in TRUTH.items():
        kind = "impulse[fly]" if name == "impulse" else name
        assert abs(found[kind].value / truth - 1) < 1e-9, name


@pytest.mark.parametrize(
    ("kp", "kd", "delay", "damping"),
    [(1500, 5, 0.008, 176), (6000, 90, 0.009, 100), (800, 60, 0.02, 120), (3000, 0, 0.005, 150), (900, 20, 0.03, 69)],
)
def test_the_delay_is_found_over_the_range_that_flies_have(kp, kd, delay, damping):
    truth = {"kp": kp, "kd": kd, "delay": delay, "damping": damping, "impulse": 35.0}
    found = fit_gains([recording(1, truth=truth)], gain_model(fixed=AT_REST | {"damping": damping}))
    assert found.converged
    for name in ("kp", "kd", "delay"):
        assert abs(found[name].value - truth[name]) < 4 * found[name].standard_error, name


@pytest.mark.slow
@pytest.mark.parametrize("free_damping", [False, True])
def test_95_percent_intervals_hold_the_truth_in_95_percent_of_400_recordings(free_damping):
    model = gain_model(fixed=AT_REST | ({} if free_damping else {"damping": TRUTH["damping"]}))
    names = ["kp", "kd", "delay", *(["damping"] if free_damping else [])]
    inside = dict.fromkeys(names, 0)
    for seed in range(400):
        found = fit_gains([recording(seed)], model)
        for name in names:
            inside[name] += found[name].low <= TRUTH[name] <= found[name].high
    low, high = scipy.stats.binom.ppf([0.0005, 0.9995], 400, 0.95)
    assert (low, high) == (364, 393)
    assert all(low <= count <= high for count in inside.values()), inside


def test_coloured_noise_is_recognised_and_widens_the_intervals():
    model = gain_model(fixed=AT_REST | {"damping": 69.0})
    trial = recording(3, correlation=0.9)
    careful, naive = fit_gains([trial], model), fit_gains([trial], model, noise="white")
    assert careful.noise[0][0].order >= 1
    assert abs(careful.noise[0][0].pacf[0] - 0.9) < 0.06
    assert careful["kp"].standard_error > 3 * naive["kp"].standard_error  # sqrt(1.9 / 0.1) = 4.4 for slow signals
    assert careful["kp"].freedom < 60 < naive["kp"].freedom


def test_recordings_of_several_strengths_share_gains_and_keep_their_own_impulses():
    trials = [
        recording(k, truth=TRUTH | {"impulse": impulse}, name=f"trial {k}")
        for k, impulse in enumerate([10.0, 20.0, 35.0, -30.0])
    ]
    found = fit_gains(trials, gain_model(fixed=AT_REST))
    assert [e.name for e in found.estimates if e.kind == "impulse"] == [f"impulse[trial {k}]" for k in range(4)]
    for e in found.estimates:
        truth = [10.0, 20.0, 35.0, -30.0][int(e.name[-2])] if e.kind == "impulse" else TRUTH.get(e.kind, 0.0)
        assert abs(e.value - truth) < 4 * e.standard_error, e.name
    alone = fit_gains(trials[2:3], gain_model(fixed=AT_REST))
    assert found["kp"].standard_error < alone["kp"].standard_error


def test_missing_samples_and_gaps_do_not_move_the_estimate_beyond_its_error():
    whole = recording(5)
    yaw = np.array(whole.yaw)
    yaw[200:260] = np.nan
    yaw[::7] = np.nan
    found = fit_gains(
        [Trial(name="holes", time=TIMES, yaw=yaw, rate=8000.0, perturbation=PULSE)], gain_model(fixed=AT_REST)
    )
    assert abs(found["delay"].value - TRUTH["delay"]) < 4 * found["delay"].standard_error


def test_a_paddling_recording_gives_its_gain():
    gamma = 2.0e4
    response = yaw_response(TRUTH, TIMES, PULSE, torque=True)
    rng = np.random.default_rng(8)
    trial = Trial(
        name="wings", time=TIMES, yaw=response.yaw + 0.3 * deg * rng.standard_normal(801), rate=8000.0,
        perturbation=PULSE, paddling=response.fly / gamma + 0.2 * deg * rng.standard_normal(801),
    )  # fmt: skip
    found = fit_gains([trial], gain_model(fixed=AT_REST, estimate=["paddling_gain"]))
    assert abs(found["paddling_gain"].value - gamma) < 4 * found["paddling_gain"].standard_error
    assert found["paddling_gain"].standard_error < 0.05 * gamma


def test_saturated_paddling_is_found():
    truth = TRUTH | {"limit": 900.0}
    found = fit_gains([recording(2, truth=truth)], gain_model(fixed=AT_REST | {"damping": 69.0}, estimate=["limit"]))
    assert abs(found["limit"].value - 900.0) < 4 * found["limit"].standard_error


def test_an_integral_gain_is_found():
    truth = TRUTH | {"ki": 6e4}
    found = fit_gains([recording(2, truth=truth)], gain_model("PID", fixed=AT_REST | {"damping": 69.0}))
    assert abs(found["ki"].value - 6e4) < 4 * found["ki"].standard_error


def test_outlying_samples_hardly_move_a_robust_fit():
    trial = recording(6)
    yaw = np.array(trial.yaw)
    yaw[::23] += 10 * deg
    spoilt = Trial(name="spoilt", time=TIMES, yaw=yaw, rate=8000.0, perturbation=PULSE)
    model = gain_model(fixed=AT_REST | {"damping": 69.0, "heading": 0.0})
    robust, plain = fit_gains([spoilt], model, loss="huber", noise="white"), fit_gains([spoilt], model, noise="white")
    assert abs(robust["kp"].value - 3050) < 0.3 * abs(plain["kp"].value - 3050)


def test_a_prior_counts_like_one_more_measurement():
    model = gain_model(fixed=AT_REST, settings={"damping": Unknown(low=0.0, prior=Prior(mean=69.0, deviation=0.01))})
    with_prior, fixed = (
        fit_gains([recording(4)], model),
        fit_gains([recording(4)], gain_model(fixed=AT_REST | {"damping": 69.0})),
    )
    assert abs(with_prior["kp"].value - fixed["kp"].value) < 0.02 * fixed["kp"].standard_error


def test_a_fly_that_nothing_moved_is_not_identifiable():
    rng = np.random.default_rng(0)
    still = Trial(
        name="still", time=TIMES, yaw=0.3 * deg * rng.standard_normal(801), rate=8000.0, perturbation=None
    )  # fmt: skip
    found = fit_gains([still], gain_model(fixed=AT_REST))
    assert found.status.startswith("not identifiable: no perturbation is known")
    assert np.isinf(found["kp"].standard_error)


@pytest.mark.parametrize(("onset", "ends"), [(0.1, "100 to 104.5"), (5.0, "5000 to 5004.5"), (-0.0045, "-4.5 to 0")])
def test_a_pulse_outside_the_recording_is_refused(onset, ends):
    elsewhere = recording(0, perturbation=Pulse(onset=onset, duration=0.0045))
    with pytest.raises(InvalidInputError, match=f"fly: the pulse from {ends} ms lies outside the recording from 0 to"):
        fit_gains([recording(0, name="first"), elsewhere])


def test_a_trace_that_shares_no_time_with_yaw_is_refused():
    later = TorqueTrace(time=TIMES + 1, drive=np.sin(TIMES), unit="A")
    with pytest.raises(InvalidInputError, match="fly: the trace of the drive and yaw share no time"):
        fit_gains([replace(recording(0), perturbation=later)])


@pytest.mark.parametrize("before_the_end", [1e-9, 5e-5, 3e-4])
def test_a_pulse_at_the_very_end_shows_too_little(before_the_end):
    last = Pulse(onset=TIMES[-1] - before_the_end, duration=0.0045)
    found = fit_gains([replace(recording(0), perturbation=last)])
    assert not found.usable
    assert "ms after the onset, too short for a reflex to act and be answered" in found.status


@pytest.mark.parametrize("start", [np.zeros(3), np.zeros((8, 8)), 1.0, [np.nan] * 8])
def test_a_start_that_is_not_one_number_for_each_unknown_is_refused(start):
    with pytest.raises(InvalidParameterError, match="start must have one finite number for each of the 8 unknowns"):
        fit_gains([recording(0)], start=start)


def test_a_bad_request_is_refused_in_a_sentence():
    with pytest.raises(InvalidInputError, match="at least one trial"):
        fit_gains([])
    with pytest.raises(InvalidInputError, match="named 'fly'"):
        fit_gains([recording(0), recording(1)])
    with pytest.raises(InvalidParameterError, match="both fixed and to be estimated"):
        gain_model(fixed={"kp": 1.0}, estimate=["kp"])
    with pytest.raises(InvalidParameterError, match="noise must be"):
        fit_gains([recording(0)], noise="pink")
    with pytest.raises(InvalidInputError, match="no trial has paddling"):
        fit_gains([recording(0)], gain_model(estimate=["paddling_gain"]))


def test_a_result_prints_its_status_and_every_estimate_on_a_line():
    found = fit_gains([recording(0)], gain_model(fixed=AT_REST | {"damping": 69.0}))
    lines = str(found).splitlines()
    assert lines[0] == found.status
    assert len(lines) == 2 + len(found.estimates)
    delay = next(line for line in lines if line.startswith("delay"))
    assert f"{found['delay'].value * 1e3:.4g} ms (from {found['delay'].low * 1e3:.4g} to" in delay
    assert repr(found) == f"<FitResult: {found.status}>"


def test_a_unit_of_two_words_is_said_once_in_a_range():
    assert spoken_range(4e4, 5e4, "1/s^2 per rad") == "from 4e+04 to 5e+04 1/s^2 per rad"
    assert spoken(np.inf, "1/s^2") == "unlimited"
