"""Ensembles over drawn flies, strokes and perturbations, as work for `flycontrol.jobs`: all cores, resumable.

work = ensemble_work(draw, flights=10_000, wingbeats=50, seed=1)
ends = [end for group in seeded_map(work, checkpoint=Checkpoint(folder, identity), progress=bar) for end in group]
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np

from flycontrol.errors import InvalidParameterError
from flycontrol.flight.ensemble import FlightPlan, ensemble_chunks
from flycontrol.flight.kernels.lanes import LANES
from flycontrol.flight.settings import MarchSettings
from flycontrol.jobs.packed import Result
from flycontrol.jobs.work import Work
from flycontrol.model.trajectory import Trajectory

Draw = Callable[[np.random.Generator], FlightPlan]
Fold = Callable[[Result, Trajectory], Result]


def end_of_flight(before: Result, piece: Trajectory) -> Result:
    """Keep the last state: position [m], attitude, velocity [m/s], angular velocity [rad/s]; wingbeats and status."""
    if isinstance(before, dict) and before["status"] != "complete":
        return before
    status, wingbeats = piece.status, piece.wingbeats
    if not len(piece.time):
        return {**before, "status": status} if isinstance(before, dict) else {"status": status, "wingbeats": wingbeats}
    return {  # copies: a view would keep the whole piece
        "position_W": piece.position_W[-1].copy(),
        "q_WS": piece.q_WS[-1].copy(),
        "velocity_S": piece.velocity_S[-1].copy(),
        "angular_velocity_S": piece.angular_velocity_S[-1].copy(),
        "wingbeats": wingbeats,
        "status": status,
    }


def ensemble_work(
    draw: Draw,
    flights: int,
    wingbeats: int,
    seed: int,
    *,
    fold: Fold = end_of_flight,
    settings: MarchSettings | None = None,
) -> Work:
    """Flights of drawn plans, in groups of LANES; the result of an item is the list of its flights' results.

    Memory does not grow with the length of the flights: they pass in pieces of `settings.chunk` wingbeats.

    Parameters
    ----------
    draw
        Plan of one flight from a generator; a function at the top level of a module, or a partial of one.
    flights, wingbeats
        How many flights, and how long each.
    seed
        Of all of them; results depend on it and on a flight's place alone.
    fold
        Result so far (None at first) and the flight's next piece -> result; at the top level of a module too.
    settings
        Steps, samples and wingbeats of a piece.

    Raises
    ------
    InvalidParameterError
        Fewer than one flight or wingbeat.
    """
    if flights < 1 or wingbeats < 1:
        raise InvalidParameterError(f"An ensemble needs a flight and a wingbeat, got {flights!r} and {wingbeats!r}.")
    groups = [min(LANES, flights - first) for first in range(0, flights, LANES)]
    task = partial(_fly_group, draw=draw, wingbeats=wingbeats, fold=fold, settings=settings)
    return Work(task=task, items=groups, seed=seed, chunk=1, name="groups of flights")


def _fly_group(
    size: int,
    generator: np.random.Generator,
    *,
    draw: Draw,
    wingbeats: int,
    fold: Fold,
    settings: MarchSettings | None,
) -> Result:
    results: list[Result] = [None] * size
    for pieces in ensemble_chunks([draw(generator) for _ in range(size)], wingbeats, settings=settings):
        results = [fold(before, piece) for before, piece in zip(results, pieces, strict=True)]
    return results
