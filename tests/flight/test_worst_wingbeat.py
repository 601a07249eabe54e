from dataclasses import replace

import pytest

from flycontrol.errors import InvalidParameterError
from flycontrol.flight.experiments import planned_flight
from flycontrol.flight.flight_record import FlightRecorder
from flycontrol.io.flight_experiments import read_flight_experiment

UNTRIMMED = "[trim]\nmoves = []\n[march]\nwingbeats = 5\nsteps = 100\nsamples = 10\n"
PULSE = '[[pulse]]\naxis = "roll"\ntorque = "{} N m"\nonset = "2 wingbeats"\nduration = "1 wingbeat"\n'


@pytest.fixture
def experiment(tmp_path):
    def read(text):
        (tmp_path / "flight.toml").write_text(text)
        return read_flight_experiment(tmp_path / "flight.toml")

    return read


def flown(experiment):
    planned = planned_flight(experiment)
    recorder = FlightRecorder(planned)
    for piece in planned.chunks():
        recorder.add(piece)
    return recorder.finish()


def test_the_wingbeat_of_a_pulse_is_repeated_and_the_worst_one_told(experiment):
    calm, pushed = flown(experiment(UNTRIMMED)), flown(experiment(UNTRIMMED + PULSE.format(60e-9)))
    assert calm.step_error_wingbeats == (0, 4)
    assert pushed.step_error_wingbeats == (0, 2, 4)
    assert pushed.step_error_wingbeat > 0
    assert pushed.step_error.attitude > calm.step_error.attitude


def test_steps_that_suit_the_calm_fly_but_not_its_pulse_are_refused_with_the_pulses_wingbeat(experiment):
    whole = experiment(UNTRIMMED + PULSE.format(60e-9))
    calm = flown(replace(whole, pulses=()))
    first = max(error.attitude for error in [calm.step_error])
    with pytest.raises(InvalidParameterError, match="number 2, counted from 0"):
        flown(replace(whole, tolerance=1.01 * first))


def test_a_fly_that_yaws_along_a_ramp_has_an_attitude_error(experiment):
    ramp = '[body]\nfree = "yaw"\n[[stroke.modulation]]\nramp = [1, 2]\npaddling = "5 deg"\n'
    found = flown(experiment(UNTRIMMED + ramp))
    assert found.step_error_wingbeats == (0, 1, 4)
    assert found.step_error.attitude > 0
