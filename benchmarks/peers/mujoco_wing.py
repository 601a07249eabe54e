"""MuJoCo on a fly of two ellipsoid wings and a free body: its ellipsoid fluid model, wings drawn along the stroke.

One position actuator a joint, with damping; fed forward, so that inertia and damping do not make it lag:
torque = k (q* + (c q*' + I q*'') / k - q) - c q'. Units are cm, g and s, in which no number is tiny. What cannot happen
is switched off (contacts, limits, friction), and the steps run inside `mujoco.rollout`, not in Python.
"""

import mujoco
import numpy as np
import stopwatch
from mujoco import rollout

CM, GRAM = 1e2, 1e3
XML = """
<mujoco>
  <compiler angle="radian" inertiafromgeom="false"/>
  <option timestep="{step}" gravity="0 0 -981" density="{density}" viscosity="1.8e-4" integrator="{integrator}">
    <flag contact="disable" constraint="disable" equality="disable" limit="disable" frictionloss="disable"/>
  </option>
  <worldbody>
    <body name="fly"><freejoint/><inertial pos="0 0 0" mass="{mass}" fullinertia="{inertia}"/>{wings}</body>
  </worldbody>
  <actuator>{actuators}</actuator>
</mujoco>
"""
WING = """
<body pos="{hinge}">
  <joint name="{side}0" axis="{stroke}" damping="{c[0]}"/>
  <joint name="{side}1" axis="{deviation}" damping="{c[1]}"/>
  <joint name="{side}2" axis="0 1 0" damping="{c[2]}"/>
  <inertial pos="{centre}" mass="{mass}" fullinertia="{inertia}"/>
  <geom type="ellipsoid" size="{size}" pos="{middle}" fluidshape="ellipsoid" mass="0" contype="0" conaffinity="0"/>
</body>
"""


def text(*numbers):
    return " ".join(f"{x:.12g}" for x in numbers)


def model(problem, integrator):
    """Body axes: x forward, y left, z up; a wing's chord lies along x, its span along y."""
    step = 1 / (problem["frequency"] * problem["steps"])
    inertia = np.array(problem["joint_inertias"]) * GRAM * CM**2
    following = np.array(problem["following"])
    stiffness, damping = inertia * following**2, 2 * inertia * following
    wings, actuators = [], []
    for side, sign in (("left", 1), ("right", -1)):
        wings.append(wing(problem, side, sign, damping))
        actuators += [
            f'<general joint="{side}{k}" gainprm="{text(stiffness[k])}" biastype="affine" '
            f'biasprm="0 {text(-stiffness[k])} 0"/>'
            for k in range(3)
        ]
    b = np.array(problem["body_inertia"]) * GRAM * CM**2
    full = text(b[0, 0], b[1, 1], b[2, 2], -b[0, 1], b[0, 2], -b[1, 2])
    built = mujoco.MjModel.from_xml_string(
        XML.format(
            step=step, density=problem["density"] * GRAM / CM**3, integrator=integrator, wings="".join(wings),
            mass=problem["body_mass"] * GRAM, inertia=full, actuators="".join(actuators),
        )
    )  # fmt: skip
    angles, rates, accelerations = (np.array(problem[name]) for name in ("angles", "rates", "accelerations"))
    ahead = angles + (damping * rates + inertia * accelerations) / stiffness
    return built, ahead, (angles[0], rates[0])


def wing(problem, side, sign, damping):
    hinge, chord, length = np.array(problem["hinge"]) * CM, problem["mean_chord"] * CM, problem["wing_length"] * CM
    s, c = np.array(problem["wing_centre"]) * CM
    ss, cc, nn, sc = np.array(problem["wing_inertia"]) * GRAM * CM**2
    m = problem["wing_mass"] * GRAM
    central = (cc - m * s * s, ss - m * c * c, nn - m * (s * s + c * c), sign * (sc + m * s * c), 0.0, 0.0)
    # chord thickness of 5 % of the chord; the ellipse of the wing's length and area
    size = (2 * chord / np.pi, length / 2, 0.025 * chord)
    return WING.format(
        side=side, hinge=text(hinge[0], sign * hinge[1], -hinge[2]), stroke=text(0, 0, -sign), c=damping,
        deviation=text(sign, 0, 0), centre=text(c, sign * s, 0), mass=text(m), inertia=text(*central),
        size=text(*size), middle=text((problem["pitch_axis"] - 0.5) * chord, sign * length / 2, 0),
    )  # fmt: skip


def measure(problem):
    steps, beats = problem["steps"], problem["wingbeats"]
    for integrator in ("RK4", "Euler"):
        built, ahead, (angle, rate) = model(problem, integrator)
        data = mujoco.MjData(built)
        data.qpos[7:], data.qvel[6:] = np.tile(angle, 2), np.tile(rate, 2)
        size = mujoco.mj_stateSize(built, mujoco.mjtState.mjSTATE_FULLPHYSICS)
        start = np.empty(size)
        mujoco.mj_getState(built, data, start, mujoco.mjtState.mjSTATE_FULLPHYSICS)
        control = np.tile(np.hstack([ahead, ahead]), (beats, 1))
        room = np.empty((1, beats * steps, size)), np.empty((1, beats * steps, built.nsensordata))
        with rollout.Rollout(nthread=0) as flights:

            def fly(flights=flights, built=built, data=data, start=start, control=control, room=room):
                flights.rollout([built], [data], start[None], control[None], state=room[0], sensordata=room[1])
                return room[0][0]

            states = fly()
            missed = float(np.sqrt(np.mean((states[steps - 1 :: steps, 8:14] - np.tile(angle, 2)) ** 2)))
            timing = stopwatch.timed(fly)
        each = {name: timing[name] / beats for name in ("run_s", "best_s")}
        yield {
            "use": f"two ellipsoid wings, {integrator}", "setting": "as many steps, wings drawn along the stroke",
            "setup_s": 0.0, "error": missed, **each,
        }  # fmt: skip


if __name__ == "__main__":
    stopwatch.main("mujoco", measure)
