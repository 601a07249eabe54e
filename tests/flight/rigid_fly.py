"""The fly as pinocchio builds it, joint by joint, and random flies."""

import numpy as np
import pinocchio as pin

from flycontrol.flight.kernels.wing import CENTRE_C, CENTRE_S, CONSTANTS, I_CC, I_NN, I_SC, I_SS, MASS

NO_BLADES = np.zeros((2, 4, 1))
NO_COEFFICIENTS = np.zeros((5, 9))
FREE = (1.0, 1.0, 1.0)
ZERO = (0.0, 0.0, 0.0)


def pinocchio_model(body: np.ndarray, wings: np.ndarray) -> pin.Model:
    """Free flyer, then for either wing -+z (stroke), -+x (deviation), y (pitch); right wing first."""
    model = pin.Model()
    inertia = np.zeros((3, 3))
    inertia[np.triu_indices(3)] = body[1:7]
    inertia += np.triu(inertia, 1).T
    thorax = model.addJoint(0, pin.JointModelFreeFlyer(), pin.SE3.Identity(), "body")
    model.appendBodyToJoint(thorax, pin.Inertia(body[0], np.zeros(3), inertia), pin.SE3.Identity())
    for side, name, wing in ((1.0, "right", wings[1]), (-1.0, "left", wings[0])):
        parent, place = thorax, pin.SE3(np.eye(3), body[7:] * [1.0, side, 1.0])
        for angle, axis in (("stroke", (0, 0, -side)), ("deviation", (-side, 0, 0)), ("pitch", (0, 1, 0))):
            parent = model.addJoint(parent, pin.JointModelRevoluteUnaligned(np.array(axis, float)), place, name + angle)
            place = pin.SE3.Identity()
        axes = np.array([[0.0, side, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]]).T  # span, chord, normal at zero angles
        centre = axes @ [wing[CENTRE_S], wing[CENTRE_C], 0.0]
        hinge = axes @ np.array([
            [wing[I_SS], wing[I_SC], 0.0], [wing[I_SC], wing[I_CC], 0.0], [0.0, 0.0, wing[I_NN]],
        ]) @ axes.T  # fmt: skip
        central = hinge - wing[MASS] * (centre @ centre * np.eye(3) - np.outer(centre, centre))
        model.appendBodyToJoint(parent, pin.Inertia(wing[MASS], centre, central), pin.SE3.Identity())
    return model


def random_body(rng: np.random.Generator) -> np.ndarray:
    factor = rng.normal(size=(3, 3))
    inertia = (factor @ factor.T + np.eye(3)) * 1e-13
    return np.array([rng.uniform(0.5, 2.0) * 1e-6, *inertia[np.triu_indices(3)], *(rng.normal(size=3) * 3e-4)])


def random_wing(rng: np.random.Generator) -> np.ndarray:
    """A flat cloud of six points."""
    s, c = (rng.normal(size=(6, 2)) * [1e-3, 3e-4] + [1.5e-3, -1e-4]).T
    m = rng.uniform(0.2, 1.0, 6) * 1e-9
    wing = np.zeros(CONSTANTS)
    wing[[MASS, CENTRE_S, CENTRE_C]] = m.sum(), m @ s / m.sum(), m @ c / m.sum()
    wing[[I_SS, I_CC, I_NN, I_SC]] = m @ c**2, m @ s**2, m @ (c**2 + s**2), -m @ (s * c)
    return wing
