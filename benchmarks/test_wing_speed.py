"""The wing level against MuJoCo and against the same equations by hand in C; every time is that of one wingbeat."""

import time
from dataclasses import replace

import numpy as np
import pytest
import wing_loops
from scoreboard import Row
from test_speed import US, run_peer, stopwatch

from flycontrol.flight.ensemble import FlightPlan, simulate_flights
from flycontrol.flight.kernels.lanes import LANES
from flycontrol.flight.simulate import simulate_flight

ONE, MANY = "a wingbeat of one fly, 200 steps", f"a wingbeat of one of {LANES} flies"


def row(job, setting, timing, beats, **more):
    run_s, best_s = timing["run_s"] / beats, timing["best_s"] / beats
    return Row(
        job=job, tool=US, setting=f"{setting}; {1 / best_s:,.0f} a second", run_s=run_s, best_s=best_s,
        unit="apart", **more,
    )  # fmt: skip


def beside(ours, other):
    return replace(other, ratio=other.run_s / ours.run_s, ratio_of_best=other.best_s / ours.best_s)


def timing_of(benchmark):
    return {"run_s": benchmark.stats.stats.median, "best_s": benchmark.stats.stats.min}


@pytest.mark.benchmark(disable_gc=True, warmup=True, timer=time.process_time)
def test_one_fly_flies_as_the_same_equations_do_by_hand_in_c(benchmark, rows, tmp_path):
    fly, stroke, beats = wing_loops.fly(), wing_loops.stroke(), wing_loops.WINGBEATS
    flight = benchmark(simulate_flight, fly, stroke, beats, settings=wing_loops.SETTINGS)
    blades = f"{fly.air.nodes} blades a wing"
    ours = row(ONE, f"whole call of {beats} wingbeats, both errors estimated, {blades}", timing_of(benchmark), beats)
    rows.append(ours)
    for setting, own in (("prescribed wings", fly), ("six wing joints free, on springs", wing_loops.fly_on_springs())):
        march = wing_loops.kernel_march(own)
        rows.append(beside(ours, row(ONE, f"compiled march alone, {setting}", stopwatch.timed(march), beats)))
    plain = wing_loops.as_plain_numbers([FlightPlan(fly=fly, stroke=stroke)], [flight])
    rows.extend(run_peer("c_wing", plain, ours, tmp_path))
    rows.extend(run_peer("mujoco_wing", wing_loops.as_ellipsoids(), ours, tmp_path))
    assert flight.complete
    assert flight.step_error is not None
    assert flight.step_error.attitude < 1e-6


@pytest.mark.benchmark(disable_gc=True, warmup=True, timer=time.process_time)
def test_flies_in_lanes_fly_as_they_do_by_hand_in_c(benchmark, rows, tmp_path):
    plans, beats = wing_loops.plans(), wing_loops.WINGBEATS
    flights = benchmark(simulate_flights, plans, beats, settings=wing_loops.SETTINGS)
    ours = row(MANY, f"whole call of {beats} wingbeats, both errors estimated", timing_of(benchmark), beats * LANES)
    rows.append(ours)
    march = wing_loops.kernel_march_in_lanes(plans)
    rows.append(beside(ours, row(MANY, "compiled march alone", stopwatch.timed(march), beats * LANES)))
    rows.extend(run_peer("c_wing", wing_loops.as_plain_numbers(plans, flights), ours, tmp_path))
    alone = simulate_flight(plans[3].fly, plans[3].stroke, beats, settings=wing_loops.SETTINGS)
    np.testing.assert_allclose(flights[3].q_WS[-1], alone.q_WS[-1], atol=1e-9)
