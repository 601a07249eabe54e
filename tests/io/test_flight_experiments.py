import numpy as np
import pytest

from flycontrol.errors import InvalidInputError
from flycontrol.io.flight_experiments import experiment_text, read_flight_experiment
from flycontrol.model.flight_experiment import FREEDOMS, TorqueJoint
from flycontrol.model.hinge import DampedSpring
from flycontrol.model.morphology import pitch_rotation
from flycontrol.units import deg, ms


@pytest.fixture
def read(tmp_path):
    """Read an experiment from its text."""

    def reader(text):
        path = tmp_path / "flight.toml"
        path.write_text(text)
        return read_flight_experiment(path)

    return reader


@pytest.fixture
def refused(read):
    """The sentence that refuses an experiment's text."""

    def reader(text):
        with pytest.raises(InvalidInputError) as refusal:
            read(text)
        return str(refusal.value)

    return reader


def test_the_text_of_the_default_experiment_is_the_default_experiment(read):
    text = read(experiment_text())
    default = read_flight_experiment()
    for name in ("name", "morphology", "stroke", "trim", "wingbeats", "free", "pulses", "air", "steps", "samples"):
        assert getattr(text, name) == getattr(default, name), name


def test_by_default_the_published_fly_hovers_in_trim_and_is_hit_by_a_yaw_torque_of_one_wingbeat():
    default = read_flight_experiment()
    (pulse,) = default.pulses
    assert default.morphology.species == "Drosophila melanogaster"
    assert len(default.trim) == 3
    assert default.free == FREEDOMS
    assert pulse.torque_S[:2] == (0.0, 0.0)
    assert pulse.duration.at(220.0) * 220.0 == pytest.approx(1.0, rel=1e-15)


def test_what_a_file_leaves_out_is_as_in_the_default_but_pulses(read):
    own, default = read("[march]\nwingbeats = 7"), read_flight_experiment()
    assert own.wingbeats == 7
    assert (own.stroke, own.morphology, own.free, own.steps) == (
        default.stroke,
        default.morphology,
        default.free,
        default.steps,
    )
    assert own.pulses == own.steering == ()


def test_onsets_in_wingbeats_follow_the_frequency_and_onsets_in_ms_do_not(read):
    flight = read(
        '[[pulse]]\naxis = "yaw"\ntorque = "1e-9 N m"\nonset = "2 wingbeats"\nduration = "1 wingbeat"\n'
        '[[pulse]]\naxis = "yaw"\ntorque = "1e-9 N m"\nonset = "9 ms"\nduration = "4 ms"\n'
    )
    first, second = flight.pulses
    assert first.onset.at(200.0) == pytest.approx(10 * ms, rel=1e-15)
    assert first.onset.at(250.0) == pytest.approx(8 * ms, rel=1e-15)
    assert second.onset.at(200.0) == second.onset.at(250.0) == pytest.approx(9 * ms, rel=1e-15)


def test_a_torque_about_a_body_axis_is_turned_into_the_stroke_plane(read):
    flight = read(
        '[[pulse]]\naxis = "roll"\nframe = "body"\ntorque = "1e-9 N m"\nonset = "2 wingbeats"\nduration = "1 wingbeat"'
    )
    turned = pitch_rotation(flight.morphology.stroke_plane_angle) @ [1e-9, 0.0, 0.0]
    np.testing.assert_allclose(flight.pulses[0].torque_S, turned, rtol=1e-15)


def test_paddling_raises_the_right_wing_and_lowers_the_left_one(read):
    flight = read('[[stroke.modulation]]\nramp = [3, 4]\npaddling = "3 deg"')
    steered = flight.steered(flight.stroke)
    late = np.array([9.2])
    plain = flight.stroke.right(late).angles
    assert steered.right(late).angles - plain == pytest.approx(np.array([[0, 0, 3 * deg]]), abs=1e-15)
    assert steered.left(late).angles - plain == pytest.approx(np.array([[0, 0, -3 * deg]]), abs=1e-15)
    assert steered.left(np.array([2.9])).angles == pytest.approx(flight.stroke.left(np.array([2.9])).angles, abs=0)


def test_a_fly_may_differ_from_a_published_one(read):
    flight = read('[morphology]\nfly = "drosophila_melanogaster"\nwing_length = "2.5 mm"')
    assert flight.morphology.wing_length == 2.5e-3
    assert flight.morphology.mass == read_flight_experiment().morphology.mass


def test_freedoms_come_one_by_one(read):
    assert read('[body]\nfree = ["yaw", "down"]').free == ("down", "yaw")
    assert read('[body]\nfree = "none"').free == ()


def test_hinges_are_springs_or_torques_of_both_wings_or_of_one(read):
    flight = read(
        "[trim]\nmoves = []\n"
        '[hinges]\npitch = { kind = "spring", stiffness = "2e-9 N m/rad", rest_angle = "80 deg" }\n'
        '[hinges.left]\nstroke = { kind = "torque", amplitude = "4e-8 N m" }\n'
    )
    assert flight.left.pitch == flight.right.pitch == DampedSpring(stiffness=2e-9, rest_angle=80 * deg)
    assert flight.left.stroke == TorqueJoint(amplitude=4e-8)
    assert flight.right.stroke is None


def test_what_cannot_be_meant_is_refused_with_file_line_and_a_way_out(refused):
    pulse = '[[pulse]]\naxis = "yaw"\nonset = "2 wingbeats"\nduration = "1 wingbeat"\n'
    assert "flight.toml, line 5: pulse.torque is 3e-09, without a unit" in refused(pulse + "torque = 3e-9")
    assert "line 5: pulse.torque is '3 mm', a length; a torque such as" in refused(pulse + 'torque = "3 mm"')
    assert "the nearest known key is march.wingbeats" in refused("[march]\nwingbeat = 3")
    assert "is not valid TOML" in refused("[march\nwingbeats = 3")
    assert "a time longer than 0 s is needed" in refused(
        '[[pulse]]\naxis = "yaw"\ntorque = "1e-9 N m"\nonset = "1 ms"\nduration = "0 ms"'
    )
    assert "lies outside the flight of 20 wingbeats" in refused(
        '[[pulse]]\naxis = "yaw"\ntorque = "1e-9 N m"\nonset = "30 wingbeats"\nduration = "1 wingbeat"'
    )
    assert "three different names are needed" in refused('[trim]\nmoves = ["frequency"]')
    assert "line 2: stroke.frequency is '220 kHz', outside the plausible" in refused('[stroke]\nfrequency = "220 kHz"')
    assert "line 2: morphology.fly is 'a_wasp': there is no such file, and published here are drosophila" in refused(
        '[morphology]\nfly = "a_wasp"'
    )
    assert "line 2: stroke.both.kind is 'Wang'" in refused('[stroke.both]\nkind = "Wang"')
    assert "has no stiffness, which a spring needs" in refused('[hinges]\npitch = { kind = "spring" }')
    assert "is not of a spring" in refused('[hinges]\npitch = { kind = "spring", amplitude = "1e-9 N m" }')
    assert "say moves = [] under [trim]" in refused('[hinges]\npitch = { kind = "spring", stiffness = "2e-9 N m/rad" }')


def test_a_fault_in_the_second_pulse_is_refused_with_its_own_line(refused):
    pulse = '[[pulse]]\naxis = "yaw"\nonset = "2 wingbeats"\nduration = "1 wingbeat"\n'
    assert "line 10: pulse.torque is 2, without a unit" in refused(
        pulse + 'torque = "1e-9 N m"\n' + pulse + "torque = 2"
    )


def test_what_only_the_flight_would_refuse_is_refused_when_the_file_is_read(refused):
    spring = '[trim]\nmoves = []\n[hinges]\npitch = { kind = "spring", stiffness = "2e-9 N m/rad" }\n'
    assert "Only prescribed wings are flown as an ensemble" in refused(spring + "[ensemble]\nflights = 4\n")
    assert "flight.toml, line 2: march.steps is 10; an even number of at least 20" in refused("[march]\nsteps = 10")
    assert "line 2: march.samples is 33; it must divide the 200 steps" in refused("[march]\nsamples = 33")
    assert "line 2: air.terms is []: without air no stroke hovers; say moves = []" in refused("[air]\nterms = []")
    assert "line 1: trim is []; say moves = [] under [trim]" in refused("trim = []")
    assert "a ramp of steering must end after it starts" in refused(
        '[[stroke.modulation]]\nramp = [5, 3]\npaddling = "5 deg"'
    ).replace("A ramp", "a ramp")
    assert "stroke.both is given beside left or right" in refused(
        '[stroke.both]\nkind = "Berman and Wang"\n[stroke.left]\nkind = "Berman and Wang"'
    )


def test_a_pulse_that_sticks_out_of_the_flight_is_refused_with_its_line_and_one_that_ends_with_it_is_flown(
    read, refused
):
    pulse = '[[pulse]]\naxis = "yaw"\ntorque = "1e-9 N m"\nonset = "{} wingbeats"\nduration = "1 wingbeat"\n'
    assert "line 4: A pulse from" in refused(pulse.format(19.5))
    assert "sticks out of the flight of 20 wingbeats" in refused(pulse.format(19.5))
    assert len(read(pulse.format(19)).pulses) == 1


def test_a_pulse_in_ms_is_judged_at_the_trimmed_frequency_alone(read):
    late = '[[pulse]]\naxis = "yaw"\ntorque = "1e-9 N m"\nonset = "90.8 ms"\nduration = "1 ms"\n'
    assert read(late).trim.count("frequency") == 1  # 20 wingbeats of the untrimmed 220 Hz end at 90.9 ms
    with pytest.raises(InvalidInputError, match="sticks out of the flight"):
        read(late + "[trim]\nmoves = []\n")
