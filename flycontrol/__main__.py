"""The entry point: as small as can be, so that Ctrl-C while the command line is still loading is no traceback."""

from __future__ import annotations

import sys

_INTERRUPTED = 130


def main() -> None:
    """Load and run the command line."""
    try:
        from flycontrol.cli import main as run

        run()
    except KeyboardInterrupt:
        sys.stderr.write("flycontrol: interrupted; nothing was written.\n")
        sys.exit(_INTERRUPTED)


if __name__ == "__main__":
    main()
