"""The command line run in the tests' own process, which has loaded the package."""

import sys

import pytest

from flycontrol import cli


def exit_status(*arguments):
    """Run `flycontrol` with these arguments."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sys, "argv", ["flycontrol", *map(str, arguments)])
        with pytest.raises(SystemExit) as done:
            cli.main()
    return done.value.code or 0
