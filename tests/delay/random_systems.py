"""Random delay systems that tests draw from: every test names its seed, so a failure can be drawn again."""

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
