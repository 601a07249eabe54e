"""A simulated flight as a camera would have recorded it."""

import numpy as np
from scipy.spatial.transform import Rotation

from flycontrol.model.recording import Recording, WingAngles
from flycontrol.model.stroke import WingMotion
from flycontrol.model.trajectory import Trajectory


def recorded(flight: Trajectory, stroke_plane_angle: float) -> Recording:
    """Pose and wing angles at the flight's samples, nothing else; v_S = Ry(angle) v_B."""
    stroke_plane_to_world = Rotation.from_quat(flight.q_WS[:, [1, 2, 3, 0]])
    body_to_world = stroke_plane_to_world * Rotation.from_euler("y", stroke_plane_angle)
    return Recording(
        name="simulated",
        rate=1.0 / float(np.diff(flight.time).mean()),
        time=flight.time.copy(),
        source_sha256="",
        position_W=flight.position_W.copy(),
        q_WB=body_to_world.as_quat()[:, [3, 0, 1, 2]],
        stroke_plane_angle=stroke_plane_angle,
        left=wing_angles_of(flight.left),
        right=wing_angles_of(flight.right),
    )


def wing_angles_of(motion: WingMotion) -> WingAngles:
    return WingAngles(stroke=motion.stroke.copy(), deviation=motion.deviation.copy(), pitch=motion.pitch.copy())
