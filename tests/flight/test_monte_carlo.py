"""Ensembles as work for many processes."""

import numpy as np
import pytest
from drawn_flights import draw

from flycontrol.errors import InvalidParameterError
from flycontrol.flight.kernels.lanes import LANES
from flycontrol.flight.monte_carlo import ensemble_work
from flycontrol.flight.settings import MarchSettings
from flycontrol.flight.simulate import simulate_flight
from flycontrol.jobs.checkpoint import Checkpoint
from flycontrol.jobs.seeded_map import seeded_map


def flown(work, **how):
    return [end for group in seeded_map(work, 1, **how) for end in group]


def test_an_ensemble_is_its_flights_one_by_one():
    ends = flown(ensemble_work(draw, LANES + 3, 3, seed=5, settings=MarchSettings(chunk=2)))
    assert len(ends) == LANES + 3
    generator = np.random.Generator(np.random.PCG64(np.random.SeedSequence(5, spawn_key=(1,))))
    for end in ends[LANES:]:
        plan = draw(generator)
        alone = simulate_flight(plan.fly, plan.stroke, 3, pulses=plan.pulses)
        np.testing.assert_allclose(end["q_WS"], alone.q_WS[-1], atol=1e-10)
        np.testing.assert_allclose(end["velocity_S"], alone.velocity_S[-1], rtol=1e-8, atol=1e-12)
        assert (end["wingbeats"], end["status"]) == (3, "complete")


def test_an_interrupted_ensemble_resumes_where_it_was(tmp_path):
    work = ensemble_work(draw, 2 * LANES, 2, seed=1)
    told = []

    def interrupt(done, *_):
        told.append(done)
        if len(told) == 2:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        flown(work, checkpoint=Checkpoint(tmp_path / "kept", identity="drawn flights"), progress=interrupt)
    resumed, whole = flown(work, checkpoint=Checkpoint(tmp_path / "kept", identity="drawn flights")), flown(work)
    assert [end["status"] for end in resumed] == ["complete"] * 2 * LANES
    for one, other in zip(resumed, whole, strict=True):
        np.testing.assert_array_equal(one["q_WS"], other["q_WS"])


def test_an_empty_ensemble_is_refused():
    with pytest.raises(InvalidParameterError, match="a flight and a wingbeat"):
        ensemble_work(draw, 0, 1, seed=1)
