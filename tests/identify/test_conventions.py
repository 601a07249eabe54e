from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from flycontrol.errors import InvalidInputError
from flycontrol.flight.aerodynamics import BodyMotion, flight_loads
from flycontrol.identify.conventions import establish_conventions
from flycontrol.model.morphology import drosophila_hydei, pitch_rotation
from flycontrol.model.recording import Recording, WingAngles
from flycontrol.model.stroke import wing_motion
from flycontrol.units import deg

FLY = drosophila_hydei()
RATE, FREQUENCY = 7500.0, 187.5


def wings(time: np.ndarray, side: int) -> WingAngles:
    """Slow roll and pitch commands: amplitude differs between the wings, and the mean stroke wanders."""
    phase = 2 * np.pi * FREQUENCY * time
    roll, pitch = np.sin(2 * np.pi * 19.0 * time), np.sin(2 * np.pi * 31.0 * time + 1.0)
    return WingAngles(
        stroke=-(68 * deg + side * 4 * deg * roll) * np.cos(phase) + 4 * deg * pitch,
        deviation=8 * deg * np.sin(2 * phase) + 2 * deg * pitch,
        pitch=90 * deg - 47 * deg * np.sin(phase + 0.1),
    )


@pytest.fixture(scope="module")
def made_flight() -> Recording:
    """A fly held in place that is spun up by its own wings' torque: the truth about its conventions is known."""
    time = np.arange(1500) / RATE
    left, right = wings(time, -1), wings(time, 1)
    still = BodyMotion(velocity=np.zeros((1500, 3)), angular_velocity=np.zeros((1500, 3)))
    torque = flight_loads(FLY, wing_motion(left, RATE), wing_motion(right, RATE), still).total.torque
    rates = np.cumsum(torque - torque.mean(axis=0), axis=0) / RATE / np.diag(FLY.inertia_S)
    level = np.diag([1.0, -1.0, -1.0]) @ pitch_rotation(FLY.stroke_plane_angle)
    return Recording(
        name="made",
        rate=RATE,
        time=time,
        source_sha256="",
        position_W=np.zeros((1500, 3)),
        velocity_S=np.zeros((1500, 3)),
        angular_velocity_S=0.1 * rates,
        q_WB=np.tile(Rotation.from_matrix(level).as_quat()[[3, 0, 1, 2]], (1500, 1)),
        left=left,
        right=right,
    )


def test_true_conventions_are_supported(made_flight):
    evidence = establish_conventions(made_flight, FLY)
    assert evidence.wing_pitch.finding == "supported"
    assert evidence.stroke_sense.finding == "supported"
    assert evidence.left_right.finding == "supported"


def test_exchanged_wings_are_contradicted_by_roll_and_by_nothing_else(made_flight):
    evidence = establish_conventions(replace(made_flight, left=made_flight.right, right=made_flight.left), FLY)
    assert evidence.left_right.finding == "contradicted"
    assert evidence.wing_pitch.finding == "supported"


def test_a_reversed_pitch_is_contradicted_by_weight_support(made_flight):
    def turn(wing: WingAngles) -> WingAngles:
        return replace(wing, pitch=np.pi - wing.pitch)

    turned = replace(made_flight, left=turn(made_flight.left), right=turn(made_flight.right))
    assert establish_conventions(turned, FLY).wing_pitch.finding == "contradicted"


def test_forward_called_backward_is_contradicted_by_pitching(made_flight):
    def turn(wing: WingAngles) -> WingAngles:
        return replace(wing, stroke=-wing.stroke, pitch=np.pi - wing.pitch)

    turned = replace(made_flight, left=turn(made_flight.left), right=turn(made_flight.right))
    evidence = establish_conventions(turned, FLY)
    assert evidence.stroke_sense.finding == "contradicted"
    assert evidence.wing_pitch.finding == "supported"


def test_a_flight_without_attitude_is_refused_in_a_sentence(made_flight):
    with pytest.raises(InvalidInputError, match="quaternion is needed"):
        establish_conventions(replace(made_flight, q_WB=None), FLY)


def test_the_frames_angle_is_found_from_velocities(made_flight):
    rng = np.random.default_rng(0)
    path = np.cumsum(rng.standard_normal((1500, 3)), axis=0) * 1e-6
    moving = replace(made_flight, position_W=path)
    bare = establish_conventions(replace(moving, velocity_S=None), FLY)
    assert bare.frame is None
    from flycontrol.identify.motion import body_motion

    known = replace(moving, velocity_S=body_motion(replace(moving, velocity_S=None), FLY).velocity)
    frame = establish_conventions(known, FLY).frame
    assert frame is not None
    assert frame.fitted_angle == pytest.approx(55 * deg, abs=1e-12)
    assert frame.residual < 1e-12 < frame.residual_reversed
