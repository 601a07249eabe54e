import numpy as np
import pytest

from flycontrol.model.turn import TurnModel, find_turns, paddling_turn
from flycontrol.model.wingbeats import Wingbeats
from flycontrol.units import deg

MODEL = TurnModel(damping=70.0, paddling=3e4, offset=40.0, wing_speed=870.0)
BEATS = Wingbeats(reversals=np.arange(61) / 190.0)


def bump(centre: float, height: float, width: float = 4.0) -> np.ndarray:
    return height * np.exp(-(((np.arange(60) - centre) / width) ** 2))


def test_a_turn_to_the_right_and_one_to_the_left_are_found_and_whole():
    turns = find_turns(bump(15, 25.0) - bump(42, 20.0), BEATS)
    assert [t.complete for t in turns] == [True, True]
    assert turns[0].first < 15 < turns[0].last < turns[1].first < 42 < turns[1].last


def test_two_turns_the_same_way_are_told_apart():
    assert len(find_turns(bump(15, 25.0, 3.0) + bump(40, 20.0, 3.0), BEATS)) == 2


def test_a_turn_cut_by_the_recording_is_called_incomplete():
    (turn,) = find_turns(bump(58, 25.0), BEATS)
    assert not turn.complete


def test_less_than_five_degrees_is_no_turn():
    assert find_turns(bump(30, 0.5), BEATS) == []


def test_a_turn_begins_and_ends_below_a_fifth_of_its_peak():
    rate = bump(30, 25.0)
    (turn,) = find_turns(rate, BEATS)
    assert rate[turn.first - 1] < 5.0 <= rate[turn.first]
    assert rate[turn.last + 1] < 5.0 <= rate[turn.last]


def test_eq_4_balances_exactly_for_its_own_plant():
    """r' = -b r + g d + c integrated exactly: Delta psi = (g int d + c dt) / b - Delta r / b, term by term."""
    d_alpha = bump(20, 2 * deg)
    rate = [0.0]
    decay = np.exp(-MODEL.damping / 190.0)
    drive = MODEL.paddling * d_alpha + MODEL.offset
    for k in range(60):
        rate.append(decay * rate[-1] + (1 - decay) / MODEL.damping * drive[k])
    at_reversals = np.array(rate)
    angle = (drive / 190.0 - np.diff(at_reversals)) / MODEL.damping
    for interval in find_turns(angle * 190.0, BEATS):
        turn = paddling_turn(interval, BEATS, at_reversals, d_alpha, angle, MODEL)
        assert turn.by_plant_with_offset + turn.rate_change_correction == pytest.approx(turn.angle, rel=1e-12)
        assert turn.by_wing_speed == pytest.approx(MODEL.wing_speed * turn.paddling_integral, rel=1e-15)


def test_without_damping_eq_5_has_no_value():
    (interval,) = find_turns(bump(30, 25.0), BEATS)
    undamped = TurnModel(damping=-1.0, paddling=1.0, offset=0.0, wing_speed=870.0)
    turn = paddling_turn(interval, BEATS, np.zeros(61), bump(30, 1 * deg), bump(30, 0.1), undamped)
    assert np.isnan(turn.by_plant)
