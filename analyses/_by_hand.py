"""How an analysis is started by hand: where its results go, and where real measurements are."""

import argparse
import inspect
import os
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
REPORTS = ROOT / "reports"
DATA = Path(os.environ.get("FLYCONTROL_DATA", ROOT.parent / "shared" / "data"))


def folder_named(file: str, doc: str | None, default: Path) -> Path:
    """Read the one argument that an analysis takes: the folder for its results.

    Parameters
    ----------
    file, doc
        The analysis' own `__file__` and `__doc__`; the latter is its help.
    default
        The folder where none is named.
    """
    folder = _path_named(file, doc, "folder", "where the results go") or default
    if folder.exists() and not folder.is_dir():
        refuse(f"{folder} is a file; name a folder for the results.")
    return folder


def figure_named(file: str, doc: str | None) -> Path | None:
    """Read the one argument of an analysis that prints its numbers: where its figure goes, or None for no figure."""
    figure = _path_named(file, doc, "figure", "the SVG file to draw into")
    if figure is not None and (figure.suffix != ".svg" or not figure.absolute().parent.is_dir()):
        refuse(f"{figure} is no place for a figure; name a file that ends in .svg in a folder that exists.")
    return figure


def nothing_named(file: str, doc: str | None) -> None:
    """Read the arguments of an analysis that takes none: `--help` shows what it does, all else is refused."""
    _parser(file, doc).parse_args()


def _path_named(file: str, doc: str | None, name: str, what: str) -> Path | None:
    parser = _parser(file, doc)
    parser.add_argument(name, type=Path, nargs="?", help=what)
    path: Path | None = getattr(parser.parse_args(), name)
    return path


def _parser(file: str, doc: str | None) -> argparse.ArgumentParser:
    return argparse.ArgumentParser(
        prog=f"python analyses/{Path(file).name}",
        description=inspect.cleandoc(doc or ""),
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )


def measured(data: Path, *needed: str) -> None:
    """End with a sentence and status 2 unless the folder of real measurements holds all that is needed."""
    for name in needed:
        if not (data / name).exists():
            refuse(f"There is no {name} in {data}; set FLYCONTROL_DATA to the folder of measurements that holds it.")


def refuse(sentence: str) -> None:
    """End with a sentence and status 2."""
    print(sentence, file=sys.stderr)
    sys.exit(2)
