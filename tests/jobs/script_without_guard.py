"""What a user writes who has not read that processes import their script."""

from seeded_tasks import draw

from flycontrol.jobs.seeded_map import seeded_map
from flycontrol.jobs.work import Work

seeded_map(Work(task=draw, items=range(4), seed=1), workers=2)
