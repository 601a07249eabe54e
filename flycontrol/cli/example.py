"""`flycontrol example DIR`: a synthetic experiment to try `flycontrol fit` on."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from flycontrol.cli.terminal import say


def example(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="New folder for the recordings, mapping and truth.")],
    seed: Annotated[int, typer.Option(min=0, help="Of everything drawn at random.")] = 0,
    flies: Annotated[int, typer.Option(min=1, max=99, help="How many; each is turned by four pulses.")] = 5,
) -> None:
    """Write a synthetic experiment: perturbed flies with realistic noise, the mapping that reads them, the truth apart.

    Example: flycontrol example demo && flycontrol fit demo/*.csv --mapping demo/mapping.toml
    """
    from flycontrol.io.example_files import example_files, refuse_other_files
    from flycontrol.jobs.files import require_writable_folder, write_files_atomically

    require_writable_folder(folder)
    from flycontrol.identify.gains.synthetic import synthetic_experiment

    made = synthetic_experiment(seed, flies)
    files = example_files(made.trials, made.flies, made.impulses, seed)
    refuse_other_files(folder, files)
    write_files_atomically(folder, files)
    say(
        f"wrote {len(made.trials)} synthetic recordings, mapping.toml, truth.toml and README.txt into {folder}; next: "
        f"flycontrol fit {folder}/*.csv --mapping {folder}/mapping.toml"
    )
