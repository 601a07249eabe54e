"""Long flights and large ensembles need no more memory than short ones."""

import tracemalloc
from dataclasses import replace

import pytest
from simulated_fly import FLY, MELANOGASTER, SYMMETRIC

from flycontrol.flight.ensemble import FlightPlan
from flycontrol.flight.kernels.lanes import LANES
from flycontrol.flight.monte_carlo import ensemble_work
from flycontrol.flight.multibody.freedoms import YAW_ONLY
from flycontrol.flight.settings import MarchSettings
from flycontrol.flight.simulate import flight_chunks
from flycontrol.jobs.seeded_map import seeded_map

SETTINGS = MarchSettings(chunk=20)
TETHERED = replace(FLY, body=YAW_ONLY)


def draw(generator):
    morphology = replace(MELANOGASTER, mass=1.1e-6 * generator.uniform(0.9, 1.1))
    return FlightPlan(fly=replace(TETHERED, morphology=morphology), stroke=SYMMETRIC)


def peak_of(fly):
    """Most memory that Python and NumPy held at once during a second run, after whatever is kept for good [bytes]."""
    fly(SETTINGS.chunk)
    tracemalloc.start()
    try:
        flown = fly(None)
        return tracemalloc.get_traced_memory()[1], flown
    finally:
        tracemalloc.stop()


def one_fly(wingbeats):
    for piece in flight_chunks(TETHERED, SYMMETRIC, wingbeats, settings=SETTINGS):
        flown = piece.wingbeats
    return flown


def group(wingbeats, flights=LANES):
    work = ensemble_work(draw, flights, wingbeats, seed=1, settings=SETTINGS)
    ends = [end for ends in seeded_map(work, 1) for end in ends]
    assert {end["status"] for end in ends} == {"complete"}
    return ends[-1]["wingbeats"]


@pytest.mark.slow
@pytest.mark.parametrize("fly", [one_fly, group], ids=["one fly", "an ensemble"])
def test_ten_times_as_many_wingbeats_need_no_more_memory(fly):
    """Within 5 %: a single piece kept too long would add a third."""
    short, flown = peak_of(lambda wingbeats: fly(wingbeats or 200))
    long, flown_long = peak_of(lambda wingbeats: fly(wingbeats or 2000))
    assert (flown, flown_long) == (200, 2000)
    assert long < 1.05 * short


@pytest.mark.slow
def test_an_ensemble_ten_times_as_large_needs_what_its_results_need():
    """144 flights more, of which the last state is kept: a few kB each, far less than the 0.3 MB of a piece."""
    small, _ = peak_of(lambda wingbeats: group(wingbeats or 40))
    large, _ = peak_of(lambda wingbeats: group(wingbeats or 40, 10 * LANES))
    assert large - small < 9 * LANES * 8_000
