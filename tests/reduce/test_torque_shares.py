"""Shares of the yaw torque with intervals over wingbeats."""

from dataclasses import replace

import numpy as np
import pytest
from reduced_fly import FLY

from flycontrol.errors import InvalidInputError, InvalidParameterError
from flycontrol.model.collapsed_wingbeats import CollapsedWingbeats
from flycontrol.model.stroke import ANGLES
from flycontrol.model.symmetrised import VERSIONS
from flycontrol.model.wing_stroke import BermanWangStroke
from flycontrol.reduce.torque_shares import shares_of_collapsed, shares_of_mean, shares_of_slope
from flycontrol.units import deg

BITS = np.array([[angle in kept for angle in ANGLES] for kept in VERSIONS], dtype=float)  # (8, 3)
PARTS = np.array([0.2, -0.1, 0.9])  # of stroke, deviation, pitch: additive, total 1


def additive(per_beat: np.ndarray) -> np.ndarray:
    """Torques (n, 8) of effects (n, 3) that do not interact."""
    return per_beat @ BITS.T


def noisy(n: int, rng: np.random.Generator, scale: float = 0.3) -> np.ndarray:
    return additive(PARTS + scale * rng.normal(size=(n, 3)))


def test_shares_of_the_mean_are_those_of_the_mean_effects():
    torques = noisy(40, np.random.default_rng(1))
    shares = shares_of_mean(torques)
    means = torques[:, [1, 2, 4]].mean(axis=0)
    assert np.allclose([shares.shapley[a].value for a in ANGLES], means / means.sum(), rtol=1e-12)
    assert abs(shares.interaction.value) < 1e-12


def test_wingbeats_that_are_alike_leave_no_doubt():
    shares = shares_of_mean(additive(np.tile(PARTS, (12, 1))))
    for k, angle in enumerate(ANGLES):
        share = shares.shapley[angle]
        assert np.allclose([share.value, share.low, share.high], PARTS[k], rtol=0, atol=1e-12)


@pytest.mark.parametrize("wingbeats", [10, 40])
def test_intervals_hold_the_truth_as_often_as_they_say(wingbeats):
    """95 % within 2.5 standard errors of 300 trials, and within 1.5 % that 200 draws and ratios cost."""
    rng = np.random.default_rng(20)
    inside = np.zeros(3)
    for _ in range(300):
        effects = shares_of_mean(noisy(wingbeats, rng), draws=200).effects
        inside += [effects[a].low <= p <= effects[a].high for a, p in zip(ANGLES, PARTS, strict=True)]
    assert np.all(np.abs(inside / 300 - 0.95) < 2.5 * np.sqrt(0.95 * 0.05 / 300) + 0.015)


def test_shares_of_a_torque_that_may_be_none_have_no_bounds():
    balanced = np.array([0.5, 0.2, -0.7])
    shares = shares_of_mean(additive(balanced + 0.3 * np.random.default_rng(2).normal(size=(20, 3))))
    assert not shares.bounded
    assert shares.shapley["pitch"].low == -np.inf
    assert shares.effects["pitch"].high < 0  # the effect itself is as well known as ever
    assert "no bounds" in shares.status


def test_wrong_zeros_and_noise_that_the_body_does_not_follow_leave_the_slopes_shares():
    """Noise moves them within their own interval."""
    rng = np.random.default_rng(4)
    required = np.sin(np.arange(400) / 5.0)
    follows = additive(required[:, None] * PARTS)
    shares = shares_of_slope([follows], [required])
    moved = shares_of_slope([follows + additive(np.array([[3.0, -1.0, 2.0]]))], [required])
    for k, angle in enumerate(ANGLES):
        assert abs(shares.shapley[angle].value - PARTS[k]) < 1e-12
        assert abs(moved.shapley[angle].value - PARTS[k]) < 1e-12
    noisy_shares = shares_of_slope([follows + additive(rng.normal(size=(400, 3)))], [required])
    for k, angle in enumerate(ANGLES):
        assert noisy_shares.shapley[angle].low < PARTS[k] < noisy_shares.shapley[angle].high


def test_flights_are_pooled_about_their_own_means():
    required = np.sin(np.arange(30) / 3.0)
    one = additive(required[:, None] * PARTS)
    pooled = shares_of_slope([one, one + 7.0 * BITS[:, 2]], [required, required])
    assert abs(pooled.shapley["pitch"].value - PARTS[2]) < 1e-12
    assert pooled.wingbeats == 60


def wingbeats(noise: float, count: int = 12, **right: float) -> CollapsedWingbeats:
    """A left wing, and a right one that differs from it."""
    plain = BermanWangStroke(stroke_amplitude=70 * deg, stroke_offset=-3 * deg, deviation_amplitude=8 * deg)
    phase, rng = np.arange(60) / 60, np.random.default_rng(8)
    shift = {k: getattr(plain, k) + v for k, v in right.items()}

    def beats(stroke: BermanWangStroke) -> np.ndarray:
        return stroke(phase).angles + noise * rng.normal(size=(count, 60, 3))

    return CollapsedWingbeats(
        phase=phase, durations=np.full(count, 1 / 220.0), left=beats(plain), right=beats(replace(plain, **shift)),
        left_drift=np.zeros((count, 3)), right_drift=np.zeros((count, 3)),
    )  # fmt: skip


def test_a_noisy_turn_by_pitch_is_attributed_to_pitch_by_nine_tenths_and_one_by_amplitude_is_not():
    by_pitch = shares_of_collapsed(FLY, wingbeats(3 * deg, pitch_offset=6 * deg), draws=60)
    by_stroke = shares_of_collapsed(FLY, wingbeats(0.3 * deg, stroke_amplitude=15 * deg), draws=60)
    assert by_pitch.shapley["pitch"].value > 0.9
    assert by_pitch.shapley["pitch"].low > 0.75
    assert by_stroke.shapley["stroke"].low > 0.5
    assert by_stroke.shapley["pitch"].high < 0.5


def test_what_quiet_wingbeats_have_too_is_no_part_of_the_turn():
    """The same wrong zero of deviation in both; its interaction with the paddling, below 1 %, stays."""
    turn = wingbeats(0.0, pitch_offset=6 * deg, deviation_offset=4 * deg)
    quiet = wingbeats(0.0, deviation_offset=4 * deg)
    with_zero, without = (shares_of_collapsed(FLY, turn, q, draws=10).shapley["pitch"].value for q in (None, quiet))
    assert abs(with_zero - 1) > 0.02
    assert abs(without - 1) < 0.01


@pytest.mark.parametrize("count", [1, 3])
def test_too_few_wingbeats_have_no_interval(count):
    with pytest.raises(InvalidInputError, match="need 4 of them"):
        shares_of_mean(additive(np.tile(PARTS, (count, 1))))


def test_a_list_is_as_good_as_an_array():
    torques = noisy(12, np.random.default_rng(6))
    assert shares_of_mean(torques.tolist()) == shares_of_mean(torques)


@pytest.mark.parametrize("asked", [{"block": 0}, {"block": -3}, {"block": 1.5}, {"draws": 0}, {"draws": "400"}])
def test_a_bootstrap_of_no_draws_or_blocks_is_refused(asked):
    (name,) = asked
    with pytest.raises(
        InvalidParameterError, match=f"{name} of the bootstrap must be a whole number of at least 1, got"
    ):
        shares_of_mean(noisy(12, np.random.default_rng(7)), **asked)


@pytest.mark.parametrize(
    ("torques", "sentence"),
    [
        (np.zeros((12, 8)), "no torque to share"),
        (np.full((12, 8), 3e-10), "no torque to share"),
        (np.ones((12, 7)), r"got shape \(12, 7\)"),
        (np.ones(8), r"got shape \(8,\)"),
        (np.full((12, 8), np.nan), "must be finite, got 96 that are not"),
    ],
)
def test_torques_without_shares_are_refused(torques, sentence):
    with pytest.raises(InvalidInputError, match=sentence):
        shares_of_mean(torques)


@pytest.mark.parametrize(
    ("flights", "required", "sentence"),
    [
        ([], [], "at least one flight, and as many arrays of torques as of torques required, got 0 and 0"),
        ([12, 12], [12], "got 2 and 1"),
        ([12], [11], r"Flight 0 has torques of 12 wingbeats and required torques of shape \(11,\)"),
        ([12], [np.ones(12)], "a required torque that changes"),
        ([12], [np.full(12, np.nan)], "must be finite"),
    ],
)
def test_a_slope_over_nothing_is_refused(flights, required, sentence):
    rng = np.random.default_rng(8)
    needed = [rng.normal(size=r) if isinstance(r, int) else r for r in required]
    with pytest.raises(InvalidInputError, match=sentence):
        shares_of_slope([noisy(n, rng) for n in flights], needed)
