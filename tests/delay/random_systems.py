"""Random delay systems that tests draw from: every test names its seed, so a failure can be drawn again."""

from dataclasses import replace

import numpy as np
from hypothesis import settings
from hypothesis import strategies as st

from flycontrol.delay.system import DelayLTI, delay_lti

drawn_alike = settings(derandomize=True, deadline=None, max_examples=60)


def random_system(
    seed: int, states: int = 3, delays: int = 2, inputs: int = 1, outputs: int = 1, *, chained: bool = False
) -> DelayLTI:
    """Random retarded system, rates about 1/s, delays 0.05 to 1.5 s; `chained` lets delays feed later ones."""
    rng = np.random.default_rng(seed)
    n, q, m, p = states, delays, inputs, outputs
    forward = np.triu(rng.normal(size=(q, q)), 1) if chained else np.zeros((q, q))  # nilpotent: no loop of delays alone
    return delay_lti(
        A=rng.normal(size=(n, n)) - np.eye(n), B1=rng.normal(size=(n, m)), B2=rng.normal(size=(n, q)),
        C1=rng.normal(size=(p, n)), C2=rng.normal(size=(q, n)), D11=np.zeros((p, m)), D12=rng.normal(size=(p, q)),
        D21=rng.normal(size=(q, m)), D22=forward, tau=rng.uniform(0.05, 1.5, size=q),
    )  # fmt: skip


def random_systems(*, states: int = 4, delays: int = 3, inputs: int = 1, outputs: int = 1, chained: bool = False):
    """Strategy: random systems with up to so many states and delays."""
    return st.builds(
        lambda seed, n, q: random_system(seed, n, q, inputs, outputs, chained=chained),
        st.integers(0, 2**32 - 1), st.integers(1, states), st.integers(1, delays),
    )  # fmt: skip


def random_points(seed: int, count: int = 6) -> np.ndarray:
    """Complex frequencies [1/s] around the imaginary axis, where no random system has a pole but by chance."""
    rng = np.random.default_rng(seed)
    return rng.normal(size=count) + 3j * rng.normal(size=count)


KINDS = ("plain", "commensurate delays", "stiff", "badly scaled", "lightly damped")


def kind_of(seed: int) -> str:
    """Which of the five kinds `varied_system` draws for a seed."""
    return KINDS[seed // 30 % 5]


def varied_system(seed: int) -> DelayLTI:
    """Random system whose size and kind follow from the seed: 1-5 states, 1-3 delays, chained or not, five kinds.

    Plain: as `random_system`. Commensurate: delays are multiples of 0.1 s, equal ones among them. Stiff: rates of the
    states spread over three decades. Badly scaled: units of states and delayed signals spread over eight decades, same
    roots as a plain one. Lightly damped: undelayed modes near the imaginary axis, perturbed by weak delayed feedback.
    """
    plain = random_system(seed, 1 + seed % 5, 1 + seed // 5 % 3, chained=seed // 15 % 2 == 1)
    rng = np.random.default_rng([seed, 1])
    n, q, kind = plain.n_states, plain.n_delays, kind_of(seed)
    if kind == "commensurate delays":
        return replace(plain, tau=0.1 * rng.integers(1, 16, size=q))
    if kind == "stiff":
        rate = 10.0 ** rng.uniform(0.0, 3.0, size=(n, 1))
        return replace(plain, A=rate * plain.A, B1=rate * plain.B1, B2=rate * plain.B2)
    if kind == "badly scaled":
        x, z = 10.0 ** rng.uniform(-4.0, 4.0, size=(n, 1)), 10.0 ** rng.uniform(-4.0, 4.0, size=(q, 1))
        return replace(
            plain, A=x * plain.A / x.T, B1=x * plain.B1, B2=x * plain.B2 / z.T, C1=plain.C1 / x.T,
            C2=z * plain.C2 / x.T, D12=plain.D12 / z.T, D21=z * plain.D21, D22=z * plain.D22 / z.T,
        )  # fmt: skip
    if kind == "lightly damped":
        turning = rng.normal(size=(n, n))
        return replace(plain, A=3.0 * (turning - turning.T) - 0.02 * np.eye(n), B2=0.03 * plain.B2)
    return plain
