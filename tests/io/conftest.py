"""A synthetic flight whose channels agree with one another, in the layout of the shipped 21-row mapping."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

FRAMES, RATE, FIRST_FRAME, WINGBEAT = 300, 7500.0, 1000, 200.0
STROKE_PLANE = np.radians(55)


def synthetic_flight():
    """(21, 300): a steady climbing turn with wingbeats at 200 Hz; body axes forward right down, world z up."""
    t = (FIRST_FRAME + np.arange(FRAMES)) / RATE
    spin_B = np.array([3.0, -2.0, 8.0])  # [rad/s]
    upright = Rotation.from_euler("x", np.pi) * Rotation.from_euler("ZY", [0.3, 0.8])
    attitude = upright * Rotation.from_rotvec(np.outer(t - t[0], spin_B))
    velocity_W = np.array([200.0, 50.0, 30.0])  # [mm/s]
    to_stroke_plane = Rotation.from_euler("y", STROKE_PLANE)
    phase = 2 * np.pi * WINGBEAT * t
    stroke, deviation, pitch = 70 * np.cos(phase), 8 * np.sin(2 * phase), 60 * np.sin(phase)
    return np.vstack(
        [
            FIRST_FRAME + np.arange(FRAMES),
            (t - t[0]) * 1e3 * 1.0005,
            *(np.outer(velocity_W, t - t[0]) + np.array([[1.0], [2.0], [3.0]])),
            *to_stroke_plane.apply(attitude.inv().apply(velocity_W)).T,
            *attitude.as_quat().T,
            *np.tile(to_stroke_plane.apply(spin_B)[:, None], FRAMES),
            *(stroke, 0.99 * stroke, deviation, 0.98 * deviation, pitch, 0.97 * pitch),
        ]
    )


@pytest.fixture
def flight():
    return synthetic_flight()


@pytest.fixture
def written(tmp_path):
    """Write a table, numbers or lines of text, and return its path."""

    def write(table, name="flight.txt", separator=" "):
        lines = [line if isinstance(line, str) else separator.join(map(repr, map(float, line))) for line in table]
        path = tmp_path / name
        path.write_text("\n".join(lines) + "\n")
        return path

    return write
