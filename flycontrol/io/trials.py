"""Trials of an experiment from files, through a mapping: what a fit of the reflex takes."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from flycontrol.errors import InvalidInputError
from flycontrol.io.binary.reader import BinaryReader, shared_reader
from flycontrol.io.channels import RecordingMapping
from flycontrol.io.clock import read_clock_with_gaps
from flycontrol.io.file_lists import expanded
from flycontrol.io.heading import Heading, read_heading, refuse_ambiguous
from flycontrol.io.mapping import read_mapping
from flycontrol.io.perturbations import read_perturbation
from flycontrol.io.scalars import read_label, read_words
from flycontrol.io.table_files import Table, read_tables, trial_contents
from flycontrol.io.variable_table import VariableTable
from flycontrol.io.wing_response import read_paddling
from flycontrol.jobs.progress import Progress, no_progress
from flycontrol.model.trial import Pulse, Trial
from flycontrol.units import ms

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


def read_trials(
    paths: Sequence[Path | str], mapping: RecordingMapping | Path | str, *, progress: Progress = no_progress
) -> tuple[Trial, ...]:
    """Read the trials of an experiment, in SI units.

    Parameters
    ----------
    paths
        Files, or patterns such as "flies/*.csv", in any number.
    mapping
        What they hold: a mapping, a mapping file, or the name of a shipped one.
    progress
        Told after every file.

    Returns
    -------
    tuple of Trial
        In the order of the files, each with a name of its own.

    Raises
    ------
    InvalidInputError
        If a file and the mapping do not fit, a number is unusable, yaw is constant, ambiguous across a gap, or none of
        a fly, a pattern matches nothing, or two trials are the same or have one name.
    """
    known = mapping if isinstance(mapping, RecordingMapping) else read_mapping(mapping)
    if known.yaw is None and known.quaternion is None:
        raise InvalidInputError(f"The mapping {known.name} maps neither yaw nor the quaternion; a trial needs one.")
    files = expanded(paths)
    trials: dict[str, tuple[Trial, Path]] = {}
    hashes: dict[str, Path] = {}
    for done, path in enumerate(files, start=1):
        for trial in read_file(path, known, shared_reader()):
            _refuse_known(trial, path, trials, hashes)
            trials[trial.name] = (trial, path)
        hashes[next(reversed(trials.values()))[0].source_sha256] = path
        progress(done, len(files), "reading")
    return tuple(trial for trial, _ in trials.values())


def read_file(path: Path, mapping: RecordingMapping, reader: BinaryReader) -> Iterator[Trial]:
    """Read the trials of one file one after the other; refused like `read_trials`."""
    tables = read_tables(path, mapping, trial_contents(mapping), reader)
    for table in tables:
        place = mapping.experiment.trial
        if place is None:
            group = table.group if isinstance(table, VariableTable) else ""
            yield _trial(table, mapping, f"{path.stem}:{group}" if group else path.stem)
            continue
        words = np.array(read_words(table, place, "trial", mapping.name))
        _refuse_unnamed_rows(table, words)
        for word in dict.fromkeys(words):  # in the order of the file
            yield _trial(table.subset(np.flatnonzero(words == word)), mapping, f"{path.stem}:{word}")


def _trial(table: Table, mapping: RecordingMapping, name: str) -> Trial:
    experiment = mapping.experiment
    clock = read_clock_with_gaps(table, mapping.clock)
    heading = read_heading(table, mapping, clock.time)
    perturbation = read_perturbation(table, experiment.perturbation, clock.time)
    if not experiment.cut_at_gaps:
        refuse_ambiguous(heading, clock.time)
    name = name if experiment.name is None else read_label(table, experiment.name)
    trial = Trial(
        name=name,
        fly=name if experiment.fly is None else read_label(table, experiment.fly),
        time=clock.time,
        yaw=heading.yaw,
        rate=clock.rate,
        perturbation=perturbation,
        paddling=read_paddling(table, experiment.paddling, clock.time),
        source_sha256=table.file.sha256,
        notes=mapping.notes | {"mapping_sha256": mapping.sha256, "yaw": _angle_meant(mapping)},
    )
    return _cut(trial, heading)


def _angle_meant(mapping: RecordingMapping) -> str:
    return "direction of the nose, from the attitude" if mapping.yaw is None else "as mapped"


def _cut(trial: Trial, heading: Heading) -> Trial:
    """Keep the stretch between ambiguous gaps that holds the onset of the pulse, or else the longest one."""
    if not heading.ambiguous.size:
        return trial
    starts = np.concatenate([[0], heading.ambiguous])
    ends = np.concatenate([heading.ambiguous, [len(trial.time)]])
    if isinstance(trial.perturbation, Pulse):
        kept = int(np.searchsorted(trial.time[heading.ambiguous], trial.perturbation.onset, side="right"))
    else:
        kept = int(
            np.argmax([np.count_nonzero(np.isfinite(trial.yaw[a:b])) for a, b in zip(starts, ends, strict=True)])
        )
    part = slice(int(starts[kept]), int(ends[kept]))
    if np.count_nonzero(np.isfinite(trial.yaw[part])) < 2:
        raise InvalidInputError(
            f"{trial.name}: the gaps of yaw leave less than two samples around the pulse; use another recording."
        )
    first, last = trial.time[part][[0, -1]] / ms
    note = f"{first:.6g} to {last:.6g} ms of {trial.time[0] / ms:.6g} to {trial.time[-1] / ms:.6g} ms"
    return replace(
        trial,
        time=trial.time[part],
        yaw=trial.yaw[part],
        paddling=None if trial.paddling is None else trial.paddling[part],
        notes=dict(trial.notes) | {"cut at gaps": note},
    )


def _refuse_unnamed_rows(table: Table, words: NDArray[np.str_]) -> None:
    empty = np.flatnonzero(words == "")
    if len(words) != len(table.numbers[0]) or empty.size:
        at = f"sample {int(empty[0]) + 1}" if empty.size else f"{len(words)} samples of {len(table.numbers[0])}"
        raise InvalidInputError(f"{table.file.name}: the column that names the trials is wanting at {at}; fill it in.")


def _refuse_known(trial: Trial, path: Path, trials: dict[str, tuple[Trial, Path]], hashes: dict[str, Path]) -> None:
    if trial.source_sha256 in hashes:
        raise InvalidInputError(
            f"{path} holds the same bytes as {hashes[trial.source_sha256]}; a recording counts once: leave one out."
        )
    if trial.name in trials:
        other = trials[trial.name][1]
        where = f"both in {path}" if other == path else f"in {other} and in {path}"
        raise InvalidInputError(
            f"There are two recordings with one name, '{trial.name}', {where}; rename one, or let the mapping tell "
            "them apart, as in trial.name = { path = '(fly[0-9]+/.*)[.]' }."
        )
