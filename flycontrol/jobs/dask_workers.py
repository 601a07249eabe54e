"""Chunks done by the workers of a Dask cluster, for work beyond one machine."""

from __future__ import annotations

from collections import deque
from collections.abc import Generator, Iterable
from typing import Any, cast

from flycontrol.errors import InvalidParameterError, WorkerLostError
from flycontrol.jobs.work import Work, packed_results


class DaskWorkers:
    """A Dask client as workers of a seeded map; finished chunks are written here, not on the cluster.

    Start the cluster's processes with one thread for linear algebra each (Dask's nannies do) and the same versions as
    here: then the results are the same bytes as those of processes of this machine, if the processors are alike.

    Parameters
    ----------
    client
        A `distributed.Client`, or the address of a scheduler.

    Raises
    ------
    InvalidParameterError
        If `distributed` is not installed or no scheduler answers at the address.
    """

    def __init__(self, client: Any) -> None:
        try:
            from distributed import Client
        except ImportError as error:
            raise InvalidParameterError(
                "work on a Dask cluster needs the package `distributed`; install `flycontrol[dask]`."
            ) from error
        self._owned = not isinstance(client, Client)
        try:
            self._client = Client(client) if self._owned else client
        except (OSError, ValueError) as error:
            raise InvalidParameterError(
                f"no Dask scheduler answers at {client!r} ({error}); check the address."
            ) from error

    def __enter__(self) -> DaskWorkers:
        return self

    def __exit__(self, *exc: object) -> None:
        self.close()

    def close(self) -> None:
        """Close the connection if an address was given; a client given stays open."""
        if self._owned:
            self._client.close()

    @property
    def ahead(self) -> int:
        """Chunks that may run ahead of the oldest unfinished one: eight for each thread of the cluster."""
        return 8 * max(1, sum(cast(dict[str, int], self._client.nthreads()).values()))

    def finished(self, work: Work, wanted: Iterable[int], ahead: int) -> Generator[tuple[int, bytes]]:
        """Yield number and packed results of the wanted chunks as they are finished; as `ProcessPool.finished`."""
        from distributed import KilledWorker, as_completed

        task = self._client.scatter(work.task, broadcast=True, hash=False)
        bound = min(ahead, self.ahead)
        queue, running = deque(sorted(wanted)), dict[Any, int]()
        arrivals = as_completed([], loop=self._client.loop)
        try:
            while queue or running:
                while queue and queue[0] - min(running.values(), default=queue[0]) < bound:
                    chunk = queue.popleft()
                    items, start = work.items_of(chunk), work.start_of(chunk)
                    future = self._client.submit(packed_results, task, items, start, work.seed, pure=False)
                    running[future] = chunk
                    arrivals.add(future)
                future = next(arrivals)
                yield running.pop(future), future.result()
        except KilledWorker as error:
            raise WorkerLostError(
                f"{work.name}: workers of the Dask cluster died over the same chunk ({error})."
            ) from None
        finally:
            self._client.cancel(list(running))
