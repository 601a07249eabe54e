"""Long work: a seeded map over processes or a Dask cluster, with progress, checkpoint and resume.

>>> work = Work(task=partial(refit, recording), items=range(1000), seed=1, name="bootstrap fits")
>>> with ProcessPool() as pool:
...     fits = seeded_map(work, pool, Checkpoint(folder, identity=recording.sha256), progress)

gives the same bytes for any number of workers, after any interruption; what is written is written whole or not at all.
"""
