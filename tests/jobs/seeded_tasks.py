"""Tasks that the tests of seeded maps give to worker processes, which must find them in a module."""

import os
import signal
import time
from pathlib import Path

import numpy as np

from flycontrol.errors import InvalidInputError
from flycontrol.jobs.seeded_map import seeded_map
from flycontrol.jobs.work import Work


def draw(item, generator):
    """All kinds of results; least squares because its last bits depend on the order of sums."""
    matrix = generator.standard_normal((300, 40))
    solution = np.linalg.lstsq(matrix, generator.standard_normal(300))[0]
    return {
        "item": item,
        "x": solution,
        "first": solution[0],
        "status": "found",
        "spread": [float(solution.std()), None],
    }


def logged(log, pause, item, generator):
    """Leave a file for every execution, named after item and process."""
    Path(log, f"{item:04d}-{os.getpid()}-{time.monotonic_ns()}").touch()
    time.sleep(pause)
    return generator.standard_normal(3)


def dying(log, times, item, generator):
    """Be killed at item 5, `times` times."""
    result = logged(log, 0, item, generator)
    if item == 5 and len(list(Path(log).glob("0005-*"))) <= times:
        os.kill(os.getpid(), signal.SIGKILL)
    return result


def refusing(log, item, generator):
    if item == 30:
        raise InvalidInputError("fly 30 has no yaw; leave it out.")
    return logged(log, 0, item, generator)


class TalkativeError(Exception):
    """An exception that cannot be unpickled."""

    def __init__(self, one, two):
        super().__init__(f"{one} and {two}")


def talkative(_item, _generator):
    raise TalkativeError("one", "two")


def nested(item, _generator):
    return seeded_map(Work(task=draw, items=range(2), seed=item), workers=2)


def threads(_item, _generator):
    import scipy.linalg  # noqa: F401
    from threadpoolctl import threadpool_info

    return [pool["num_threads"] for pool in threadpool_info()]


def process(_item, _generator):
    return os.getpid()


def slow_start(log, item, generator):
    """Take long over the first item only."""
    return logged(log, 0.5 if item == 0 else 0, item, generator)
