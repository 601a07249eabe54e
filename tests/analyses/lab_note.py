"""A lab note of analyses/ as a module."""

import importlib.util
import sys
from pathlib import Path

ANALYSES = Path(__file__).resolve().parents[2] / "analyses"


def lab_note(name):
    """Load a script afresh, so that a test may change its constants and leave others' copies alone."""
    spec = importlib.util.spec_from_file_location(name, ANALYSES / f"{name}.py")
    if str(ANALYSES) not in sys.path:
        sys.path.append(str(ANALYSES))  # where notes find what they share
    note = importlib.util.module_from_spec(spec)
    sys.modules[name] = note  # where dataclasses look their annotations up
    spec.loader.exec_module(note)
    return note
