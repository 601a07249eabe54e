"""Flies, or recordings, each with gains of its own: a study of each, and what is common to them.

Pooled intervals are true if all flies share one loop. Whether they do is tested first; where they differ by more than
their noise, each fly is studied by itself, and the mean over flies carries the spread between them.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from flycontrol.identify.gains.alone import By, grouped
from flycontrol.identify.gains.model import GainModel
from flycontrol.identify.gains.random_effects import RandomEffects
from flycontrol.identify.gains.stages import Stages
from flycontrol.identify.gains.study import FitOptions, FitStudy, Group, fit_study, group_of
from flycontrol.model.trial import Trial

Shared = Literal["auto", "all", "fly", "trial"]
DIFFERENT = 0.01  #: p of the test of homogeneity under which flies are not pooled


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Member:
    """One fly, or one recording, studied by itself."""

    name: str
    folder: str  #: the name as part of a path, unlike all others
    study: FitStudy


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ApartStudy:
    """Studies of flies, or recordings, that are not pooled."""

    by: By
    members: tuple[Member, ...]
    group: Group  #: the same fits beside each other: whether they differ, their means, who stands out
    asked: bool  #: for by the user; otherwise the flies were found to differ
    level: float
    seed: int

    @property
    def plural(self) -> str:
        """Flies, or recordings."""
        return {"fly": "flies", "recording": "recordings"}[self.by]

    @property
    def effects(self) -> tuple[RandomEffects, ...]:
        """Mean and spread of each unknown."""
        return self.group.effects

    @property
    def usable(self) -> tuple[Member, ...]:
        """Those whose fit converged with everything determined."""
        return tuple(member for member in self.members if member.study.result.usable)

    @property
    def status(self) -> str:
        """Why they stand apart, and how many fits can be used."""
        who, test = self.plural, self.group.homogeneity
        why = f"each of {len(self.members)} {who} has gains of its own, as asked"
        if not self.asked and test is not None:
            why = f"the {len(self.members)} {who} differ (p = {test.p:.2g}), so each has gains of its own"
        bad = [member.name for member in self.members if member not in self.usable]
        rest = f"; see the status of {', '.join(bad[:6])}{' and others' if len(bad) > 6 else ''}" if bad else ""
        return f"{why}; {len(self.usable)} of {len(self.members)} fits are usable{rest}."


def study_of(
    trials: Sequence[Trial],
    model: GainModel,
    options: FitOptions | None = None,
    stages: Stages | None = None,
    shared: Shared = "auto",
) -> FitStudy | ApartStudy:
    """Fit a model to trials of one or more flies, pooled or apart.

    Parameters
    ----------
    trials, model, options, stages
        As of `fit_study`; the model shares its loop among all trials.
    shared
        Among whom: "all"; the recordings of each "fly"; no one ("trial"); or "auto": all, unless the flies differ.

    Raises
    ------
    InvalidInputError, OutputError
        As of `fit_study`.
    """
    options, stages = options or FitOptions(), stages or Stages()
    by: By = "recording" if shared == "trial" else "fly"
    if shared == "all" or len(grouped(trials, by)) < 2:
        return fit_study(trials, model, options, stages)
    group = group_of(trials, model, by, options, stages)
    if shared == "auto" and not differ(group):
        return fit_study(trials, model, options, stages, flies=group)
    return ApartStudy(
        by=by, members=_members(trials, model, by, options, stages), group=group, asked=shared != "auto",
        level=options.level, seed=options.seed,
    )  # fmt: skip


def differ(group: Group) -> bool:
    """Whether fits alone differ by so much that pooled intervals would mislead."""
    return group.homogeneity is not None and group.homogeneity.p < DIFFERENT


def _members(
    trials: Sequence[Trial], model: GainModel, by: By, options: FitOptions, stages: Stages
) -> tuple[Member, ...]:
    found: list[Member] = []
    taken: set[str] = set()
    groups = grouped(trials, by)
    for name, mine in groups.items():
        stages.progress(len(found), len(groups), f"{name}, by itself")
        folder = as_folder(name, taken)
        taken.add(folder.lower())
        found.append(Member(name=name, folder=folder, study=fit_study(mine, model, options, stages.within(folder))))
    return tuple(found)


def as_folder(name: str, taken: set[str]) -> str:
    """A name as a plain part of a path, unlike those taken (in lower case)."""
    plain = re.sub(r"[^A-Za-z0-9_-]+", "_", name)[:60].strip("_") or "fly"
    candidate, count = plain, 1
    while candidate.lower() in taken:
        count += 1
        candidate = f"{plain}_{count}"
    return candidate
