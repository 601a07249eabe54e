"""What eight versions of a motion say of its three asymmetries."""

from itertools import permutations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from flycontrol.errors import InvalidParameterError
from flycontrol.model.stroke import ANGLES
from flycontrol.model.symmetrised import VERSIONS
from flycontrol.reduce.factorial import Factorial

values = arrays(float, 8, elements=st.floats(-1e3, 1e3))
ROUNDING = 1e-11  # of eight numbers below 1e3


@given(values)
def test_shapley_effects_add_up_to_the_total(v):
    of = Factorial(values=v)
    assert abs(of.shapley.sum() - of.total) < ROUNDING


@given(values)
def test_effects_alone_add_up_to_the_total_but_for_the_interaction(v):
    of = Factorial(values=v)
    assert abs(of.alone.sum() + of.interaction - of.total) < ROUNDING


@given(values)
def test_shapley_effects_are_the_mean_over_all_orders_of_keeping_one_angle_after_another(v):
    by_kept = {frozenset(kept): v[k] for k, kept in enumerate(VERSIONS)}
    steps = {angle: [] for angle in ANGLES}
    for order in permutations(ANGLES):
        for place, angle in enumerate(order):
            steps[angle].append(by_kept[frozenset(order[: place + 1])] - by_kept[frozenset(order[:place])])
    assert np.allclose(Factorial(values=v).shapley, [np.mean(steps[angle]) for angle in ANGLES], atol=ROUNDING)


@given(values)
def test_effects_of_all_sets_of_angles_rebuild_every_version(v):
    effects = Factorial(values=v).effects
    for k, kept in enumerate(VERSIONS):
        parts = [effects[j] for j, part in enumerate(VERSIONS) if set(part) <= set(kept)]
        assert abs(sum(parts) - v[k]) < 10 * ROUNDING


@given(arrays(float, 3, elements=st.floats(-1e3, 1e3)), st.floats(-1e3, 1e3))
def test_angles_that_only_add_have_one_effect_by_every_measure(parts, base):
    added = [base + sum(p for p, angle in zip(parts, ANGLES, strict=True) if angle in kept) for kept in VERSIONS]
    of = Factorial(values=np.array(added))
    for effects in (of.alone, of.all_but_one, of.shapley):
        assert np.allclose(effects, parts, atol=ROUNDING)
    assert abs(of.interaction) < ROUNDING


@given(values, st.sampled_from(range(3)))
def test_an_angle_that_changes_nothing_gets_nothing(v, k):
    without = np.array([v[version & ~(1 << k)] for version in range(8)])
    of = Factorial(values=without)
    assert max(abs(of.shapley[k]), abs(of.alone[k]), abs(of.all_but_one[k])) < ROUNDING


def test_wingbeats_are_analysed_one_by_one():
    v = np.random.default_rng(3).normal(size=(5, 8))
    together = Factorial(values=v)
    for n, row in enumerate(v):
        assert np.allclose(together.shapley[n], Factorial(values=row).shapley, rtol=1e-14)


def test_other_than_eight_values_are_refused():
    with pytest.raises(InvalidParameterError, match="eight values"):
        Factorial(values=np.zeros(7))
