from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from flycontrol.errors import InvalidInputError
from flycontrol.identify.flight import analyse_flight
from flycontrol.identify.turns import identify_turns
from flycontrol.io.recordings import read_recording
from flycontrol.model.morphology import drosophila_hydei
from flycontrol.model.recording import WingAngles
from flycontrol.units import deg

FLY = drosophila_hydei()
FLIGHTS = ("20121009_S0003", "20121120_S0001", "20121128_S0003")
BANKED = FLIGHTS[0]


@pytest.fixture(scope="module")
def recordings(real_data):
    return {
        name: read_recording(real_data / "muijres_freeflight" / f"{name}.txt", "muijres_freeflight") for name in FLIGHTS
    }


@pytest.fixture(scope="module")
def analyses(recordings):
    return {name: analyse_flight(recording, FLY) for name, recording in recordings.items()}


@pytest.mark.parametrize("name", FLIGHTS)
def test_every_real_wingbeat_is_found_within_the_species_range(analyses, name):
    frequencies = analyses[name].beats.frequencies
    assert np.all((frequencies > 165) & (frequencies < 220))


@pytest.mark.parametrize("name", FLIGHTS)
def test_weight_support_settles_the_sign_of_wing_pitch_on_every_real_flight(analyses, name):
    test = analyses[name].conventions.wing_pitch
    assert test.finding == "supported"
    assert 0.6 < test.as_mapped < 1.1
    assert test.turned < -0.5


def test_roll_tells_left_from_right_on_the_banked_flight_and_nothing_contradicts_it(recordings, analyses):
    assert analyses[BANKED].conventions.left_right.finding == "supported"
    assert all(a.conventions.left_right.finding != "contradicted" for a in analyses.values())
    recording = recordings[BANKED]
    swapped = analyse_flight(replace(recording, left=recording.right, right=recording.left), FLY)
    assert swapped.conventions.left_right.finding == "contradicted"


@pytest.mark.parametrize("name", FLIGHTS)
def test_the_real_stroke_plane_frame_is_pitched_55_deg_from_the_body(analyses, name):
    frame = analyses[name].conventions.frame
    assert frame.fitted_angle == pytest.approx(55 * deg, abs=0.01 * deg)
    assert frame.residual < 0.02e-3


@pytest.mark.parametrize("name", FLIGHTS)
def test_every_real_flight_gets_intervals_and_a_sentence(analyses, name):
    turning = analyses[name].turning
    for fit in (turning.plant, turning.plant_with_coupling):
        assert fit.damping.low < fit.damping.value < fit.damping.high
        assert fit.paddling.low < fit.paddling.value < fit.paddling.high
        assert fit.r2_acceleration <= fit.r2_acceleration_best + 1e-3
    assert turning.status.startswith("Eq. 3 can explain at most")


@pytest.mark.parametrize("name", FLIGHTS)
def test_no_turn_of_a_real_flight_overlaps_another(analyses, name):
    turns = analyses[name].turning.turns
    assert all(a.end <= b.start for a, b in pairwise(turns))


def test_the_same_recording_gives_the_same_verdicts(recordings, analyses):
    assert analyse_flight(recordings[BANKED], FLY).verdicts == analyses[BANKED].verdicts


def test_a_recording_without_position_still_gets_its_turns_and_says_what_it_lacks(recordings):
    bare = replace(recordings[BANKED], position_W=None)
    analysis = analyse_flight(bare, FLY)
    assert analysis.conventions is None
    assert any("position is needed" in sentence for sentence in analysis.verdicts)
    assert analysis.turning.plant is not None


def test_a_recording_without_body_rates_is_refused(recordings):
    with pytest.raises(InvalidInputError, match="angular velocity"):
        analyse_flight(replace(recordings[BANKED], angular_velocity_S=None), FLY)


def test_five_wingbeats_give_a_status_and_no_plant(recordings):
    recording = recordings[BANKED]
    few = slice(0, 250)

    def cut(wing: WingAngles) -> WingAngles:
        return WingAngles(stroke=wing.stroke[few], deviation=wing.deviation[few], pitch=wing.pitch[few])

    short = replace(
        recording,
        time=recording.time[few],
        yaw=None,
        position_W=recording.position_W[few],
        velocity_S=recording.velocity_S[few],
        angular_velocity_S=recording.angular_velocity_S[few],
        q_WB=recording.q_WB[few],
        left=cut(recording.left),
        right=cut(recording.right),
    )
    turning = identify_turns(short, FLY)
    assert turning.plant is None
    assert "wingbeats are too few" in turning.status
