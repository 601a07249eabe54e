"""What all tests share: the command, where real recordings are, how hypothesis draws, a backend without a screen."""

import os
from pathlib import Path

import pytest
from command_line import exit_status
from hypothesis import settings

os.environ["MPLBACKEND"] = "Agg"
os.environ["NO_COLOR"] = "1"

_REQUIRE_DATA = os.environ.get("FLYCONTROL_REQUIRE_DATA") == "1"

settings.register_profile("default", deadline=None)
settings.register_profile("ci", deadline=None, derandomize=True, print_blob=True)
settings.load_profile("ci" if _REQUIRE_DATA or os.environ.get("CI") else "default")


@pytest.fixture
def command(capsys):
    """Run `flycontrol`: exit status, standard output, standard error."""

    def run(*arguments):
        status = exit_status(*arguments)
        printed = capsys.readouterr()
        return status, printed.out, printed.err

    return run


@pytest.fixture(scope="session")
def real_data() -> Path:
    """Folder of real measurements; without it a test is skipped, or fails where they are required."""
    beside_the_checkout = Path(__file__).resolve().parents[2] / "shared" / "data"
    folder = Path(os.environ.get("FLYCONTROL_DATA", beside_the_checkout))
    if not folder.is_dir():
        sentence = f"The real recordings are not at {folder}; set FLYCONTROL_DATA to the folder that holds them."
        if _REQUIRE_DATA:
            pytest.fail(sentence)
        pytest.skip(sentence)
    return folder
