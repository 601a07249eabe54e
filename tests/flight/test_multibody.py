"""Body and wings without air, against pinocchio."""

import numpy as np
import pinocchio as pin
import pytest
from rigid_fly import FREE, NO_BLADES, NO_COEFFICIENTS, ZERO, pinocchio_model, random_body, random_wing

from flycontrol.flight.kernels.dynamics import accelerations


def random_motion(rng: np.random.Generator) -> dict[str, np.ndarray]:
    q = rng.normal(size=4)
    return {
        "q": q / np.linalg.norm(q),
        "v": rng.normal(size=3),
        "w": 30 * rng.normal(size=3),
        "angles": rng.uniform(-1.2, 1.2, (2, 3)),
        "rates": 1000 * rng.normal(size=(2, 3)),
        "torques": 1e-9 * rng.normal(size=(2, 3)),
        "force": 1e-5 * rng.normal(size=3),
        "torque": 1e-9 * rng.normal(size=3),
    }


def gravity_in_body(q: np.ndarray) -> tuple[float, ...]:
    return tuple(pin.Quaternion(q[0], *q[1:]).toRotationMatrix().T @ [0.0, 0.0, -9.81])


def ours(motion, body, wings, free=(FREE, FREE, FREE, FREE), prescribed=(ZERO, ZERO)):
    """v', w', right q'', left q'' in pinocchio's order."""
    left, right = (
        (tuple(motion["angles"][k]), tuple(motion["rates"][k]), prescribed[k], tuple(motion["torques"][k]), free[2 + k])
        for k in (0, 1)
    )
    dv, dw, left_q, right_q = accelerations(
        tuple(motion["v"]), tuple(motion["w"]), gravity_in_body(motion["q"]), left, right, tuple(motion["force"]),
        tuple(motion["torque"]), *free[:2], body, wings, NO_BLADES, NO_COEFFICIENTS,
    )  # fmt: skip
    return np.concatenate([dv, dw, right_q, left_q])


def theirs(model, motion):
    """(configuration, velocity, generalised forces) for pinocchio."""
    q = np.concatenate([np.zeros(3), motion["q"][1:], motion["q"][:1], motion["angles"][1], motion["angles"][0]])
    velocity = np.concatenate([motion["v"], motion["w"], motion["rates"][1], motion["rates"][0]])
    forces = np.concatenate([motion["force"], motion["torque"], motion["torques"][1], motion["torques"][0]])
    return q, velocity, forces


def apart(a, b):
    """Largest relative difference over the blocks of equal unit."""
    return max(np.linalg.norm(a[k : k + 3] - b[k : k + 3]) / np.linalg.norm(b[k : k + 3]) for k in (0, 3, 6, 9))


@pytest.mark.parametrize("seed", range(50))
def test_accelerations_without_air_are_those_of_pinocchio(seed):
    rng = np.random.default_rng(seed)
    body, wings = random_body(rng), np.stack([random_wing(rng), random_wing(rng)])
    model = pinocchio_model(body, wings)
    motion = random_motion(rng)
    assert apart(ours(motion, body, wings), pin.aba(model, model.createData(), *theirs(model, motion))) < 1e-10


@pytest.mark.parametrize("seed", range(50))
def test_prescribed_joints_and_held_freedoms_leave_the_equations_of_the_free_ones(seed):
    """Pinocchio's inverse dynamics of our accelerations gives back the forces of every freedom that is free."""
    rng = np.random.default_rng(1000 + seed)
    body, wings = random_body(rng), np.stack([random_wing(rng), random_wing(rng)])
    model, motion = pinocchio_model(body, wings), random_motion(rng)
    free = rng.integers(0, 2, (4, 3)).astype(float)  # v, w, left wing, right wing
    prescribed = 1e6 * rng.normal(size=(2, 3)) * (1 - free[2:])
    found = ours(motion, body, wings, tuple(tuple(f) for f in free), tuple(tuple(p) for p in prescribed))
    q, velocity, forces = theirs(model, motion)
    freed = np.concatenate([free[0], free[1], free[3], free[2]]) > 0
    np.testing.assert_array_equal(found[:6][~freed[:6]], 0.0)
    np.testing.assert_array_equal(found[6:][~freed[6:]], np.concatenate(prescribed[::-1])[~freed[6:]])
    data = model.createData()
    needed = pin.rnea(model, data, q, velocity, found)
    size = np.abs(pin.crba(model, data, q)) @ np.abs(found) + np.abs(forces) + np.abs(pin.nle(model, data, q, velocity))
    assert np.max(np.abs(needed - forces)[freed] / size[freed], initial=0.0) < 1e-10
