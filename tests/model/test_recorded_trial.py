import numpy as np
import pytest

from flycontrol.errors import InvalidInputError
from flycontrol.flight.feedback import YawFeedback
from flycontrol.flight.feedback_flight import controlled_flight
from flycontrol.flight.flapping_fly import FlappingFly
from flycontrol.flight.multibody.freedoms import YAW_ONLY
from flycontrol.flight.pulses import BodyPulse
from flycontrol.flight.settings import MarchSettings
from flycontrol.identify.gains.fit import fit_gains
from flycontrol.io.morphology import read_morphology_table
from flycontrol.model.morphology import morphology_from_table
from flycontrol.model.recorded_trial import trial_of_recording
from flycontrol.model.recording import Recording
from flycontrol.model.simulated_recording import simulated_recording, simulated_trial
from flycontrol.model.stroke_kinematics import hover_stroke
from flycontrol.model.trial import Pulse
from flycontrol.model.yaw import PDController

PULSE = Pulse(onset=5e-3, duration=4.5e-3)


@pytest.fixture(scope="module")
def flown():
    """A tethered fly under its own control, pushed by a pulse."""
    stroke = hover_stroke()
    morphology = morphology_from_table(read_morphology_table(), "Drosophila melanogaster", stroke.frequency)
    return controlled_flight(
        FlappingFly(morphology=morphology, body=YAW_ONLY), stroke,
        YawFeedback(gains=PDController(proportional=0.031, derivative=0.45e-3), delay=13.6e-3), 16,
        pulses=[BodyPulse(start=PULSE.onset, duration=PULSE.duration, torque_S=(0.0, 0.0, 1e-9))],
        settings=MarchSettings(steps=200, samples=40, estimate_error=False),
    )  # fmt: skip


def test_a_recorded_flight_is_the_trial_that_was_simulated(flown):
    recording = simulated_recording(flown.trajectory, "flight", stroke_plane_angle=0.9)
    made, known = trial_of_recording(recording, PULSE), simulated_trial(flown.trajectory, "flight", PULSE)
    np.testing.assert_allclose(made.yaw - made.yaw[0], known.yaw - known.yaw[0], atol=1e-9)
    there = np.isfinite(made.paddling)
    assert there.sum() >= 13
    command = np.interp(
        made.time[there], known.time[np.isfinite(known.paddling)], known.paddling[~np.isnan(known.paddling)]
    )
    largest = np.nanmax(np.abs(known.paddling))
    assert np.max(np.abs(made.paddling[there] - command)) < 0.1 * largest  # wingbeats begin at other phases


def test_a_recording_is_no_trial_and_the_sentence_says_what_makes_it_one(flown):
    recording = simulated_recording(flown.trajectory, "flight", stroke_plane_angle=0.9)
    with pytest.raises(InvalidInputError, match="trial_of_recording"):
        fit_gains([recording])


def test_a_recording_without_yaw_is_refused():
    with pytest.raises(InvalidInputError, match="blind has no yaw angle"):
        trial_of_recording(Recording(name="blind", rate=1e3, time=np.arange(3.0), source_sha256=""), PULSE)
