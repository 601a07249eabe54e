"""The command of a tracked flight as it stands in the provenance: what was typed, defaults left out."""

from __future__ import annotations

import shlex
from collections.abc import Mapping, Sequence
from pathlib import Path

from flycontrol.cli.track_inputs import DUST, WINGBEATS

#: What options are unless they are typed; those not named here are None or False.
_LEFT_OUT = {"up": "z", "unit": "mm", "dust": DUST, "fly": "drosophila_melanogaster", "format": "netcdf",
             "wingbeats": WINGBEATS}  # fmt: skip
_NEGATIVE = {"silhouettes": "--grey", "fit-sizes": "--no-fit-sizes"}


def typed_track_command(inputs: Sequence[str], options: Mapping[str, object]) -> str:
    """Join films and options; files by name alone: where they lie does not change the result."""
    words = ["flycontrol track", *(shlex.quote(Path(name).name or name) for name in inputs)]
    for name, value in options.items():
        if value is None or value == _LEFT_OUT.get(name) or (value is False and name not in _NEGATIVE):
            continue
        if isinstance(value, bool):
            words.append(f"--{name}" if value else _NEGATIVE[name])
        elif name in ("cameras", "background", "fly"):
            words += [f"--{name}", shlex.quote(Path(str(value)).name)]
        else:
            words += [f"--{name}", shlex.quote(f"{value:g}" if isinstance(value, float) else str(value))]
    return " ".join(words)
