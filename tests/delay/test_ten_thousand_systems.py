"""Never a missing rightmost root: ten thousand random systems against the certificate and against other counts."""

from collections import Counter

import numpy as np
import pytest
from random_systems import KINDS, kind_of, varied_system

from flycontrol.delay.spectrum import Spectrum, rightmost_roots
from flycontrol.delay.system import DelayLTI

pytestmark = pytest.mark.slow

WANTED = 6


@pytest.fixture(scope="module")
def spectra():
    return [rightmost_roots(varied_system(seed), WANTED) for seed in range(10_000)]


def discretised(system: DelayLTI, order: int) -> np.ndarray:
    """Eigenvalues with every delay line cut into Legendre-Gauss-Radau cells of degree `order`: another discretisation.

    Each line is a chain of equal cells, at most a fifth of the longest delay long; v_t = -v_theta / length in a cell,
    collocated at the right Radau points (Lagrange through these and the inflow), which is the discontinuous Galerkin
    method: dissipative at what it does not resolve, so its spurious eigenvalues lie far left.
    """
    x = right_radau(order)
    D = lagrange_slopes(np.concatenate([[0.0], x]))[1:]
    n, q = system.n_states, system.n_delays
    cells = np.maximum(1, np.ceil(5 * system.tau / system.tau.max())).astype(int)
    offsets = n + order * np.concatenate([[0], np.cumsum(cells)])
    M = np.zeros((offsets[-1], offsets[-1]))
    outflow = offsets[1:] - 1
    M[:n, :n], M[:n, outflow] = system.A, system.B2
    for i in range(q):
        speed = cells[i] / system.tau[i]
        for cell in range(cells[i]):
            rows = slice(offsets[i] + cell * order, offsets[i] + (cell + 1) * order)
            M[rows, rows] = -speed * D[:, 1:]
            if cell:
                M[rows, rows.start - 1] -= speed * D[:, 0]
            else:
                M[rows, :n] -= speed * np.outer(D[:, 0], system.C2[i])
                M[rows, outflow] -= speed * np.outer(D[:, 0], system.D22[i])
    return np.linalg.eigvals(M)


def right_radau(order: int) -> np.ndarray:
    """Nodes of (0, 1] with the end included: roots of P_n - P_(n-1)."""
    series = np.zeros(order + 1)
    series[order], series[order - 1] = 1.0, -1.0
    nodes = np.sort(np.polynomial.legendre.legroots(series).real)
    nodes[-1] = 1.0
    return (nodes + 1) / 2


def lagrange_slopes(x: np.ndarray) -> np.ndarray:
    """Derivatives of the Lagrange polynomials through x at x."""
    gaps = x[:, None] - x[None, :] + np.eye(len(x))
    weights = 1.0 / gaps.prod(axis=1)
    D = weights[None, :] / weights[:, None] / gaps
    np.fill_diagonal(D, 0.0)
    return D - np.diag(D.sum(axis=1))


def test_all_ten_thousand_spectra_are_certified(spectra):
    others = {seed: (kind_of(seed), found.status) for seed, found in enumerate(spectra) if found.status != "certified"}
    assert others == {}


def test_the_draw_holds_every_kind_size_and_number_of_delays():
    drawn = Counter((kind_of(seed), 1 + seed % 5, 1 + seed // 5 % 3, seed // 15 % 2) for seed in range(10_000))
    assert len(drawn) == len(KINDS) * 5 * 3 * 2
    assert min(drawn.values()) > 60


def test_as_many_roots_are_listed_as_were_asked_for(spectra):
    """A delay gives infinitely many roots, so there are always six."""
    assert [seed for seed, found in enumerate(spectra) if len(found.roots) < WANTED] == []


def matches(found: Spectrum, independent: np.ndarray, closeness: float) -> bool:
    """Whether both methods have the same roots right of the line, each within `closeness` of its modulus."""
    right = independent[independent.real > found.line]
    if len(right) != len(found.roots):
        return False
    distance = np.abs(right[:, None] - found.roots[None, :])
    return bool((distance.min(axis=0) < closeness * (1 + np.abs(found.roots))).all())


@pytest.mark.parametrize("kind", KINDS)
def test_every_tenth_has_the_roots_that_another_discretisation_finds_and_no_others(spectra, kind):
    """Compared where 5 x 12 Radau nodes resolve all that can lie right of the line: |s tau| < 30."""
    compared, differing = 0, []
    for seed in range(0, 10_000, 10):
        found, system = spectra[seed], varied_system(seed)
        reach = np.abs(found.roots).max() * system.tau.max()
        if kind_of(seed) != kind or reach > 30.0:
            continue
        compared += 1
        # a close pair is known to the square root of the discretisation's 1e-10
        if not matches(found, discretised(system, 12), 1e-5):
            differing.append(seed)
    assert differing == []
    assert compared > 100
