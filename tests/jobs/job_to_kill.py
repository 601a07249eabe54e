"""A job for the tests to kill: FOLDER LOG WORKERS PAUSE; its results go to FOLDER.npy at the end."""

import signal
import sys
from functools import partial
from pathlib import Path

import numpy as np
from seeded_tasks import logged

from flycontrol.jobs.checkpoint import Checkpoint
from flycontrol.jobs.seeded_map import seeded_map
from flycontrol.jobs.work import Work

if __name__ == "__main__":
    signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background jobs start with it ignored
    folder, log, workers, pause = sys.argv[1:]
    work = Work(task=partial(logged, log, float(pause)), items=range(60), seed=1, chunk=3)
    results = seeded_map(work, int(workers), Checkpoint(Path(folder), "the job to kill"))
    np.save(f"{folder}.npy", np.array(results))
