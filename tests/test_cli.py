import os
import subprocess
import sys
from importlib.metadata import version

import pytest

from flycontrol.errors import OutputError
from flycontrol.io.fly_files import parameter_text
from flycontrol.io.parameters import read_parameters

HEAVY = (
    *("numpy", "scipy", "matplotlib", "control", "casadi", "cvxpy", "numba"),
    *("pint", "pydantic", "jinja2", "dask", "pandas"),
)


@pytest.fixture
def refused(command):
    """Run what must be refused: status 2 and one sentence; return the sentence."""

    def run(*arguments):
        status, _, sentence = command(*arguments)
        assert status == 2
        assert "Traceback" not in sentence
        assert sentence.count("\n") == 1
        assert sentence.startswith("flycontrol: ")
        return sentence

    return run


def in_a_new_process(code, *arguments):
    return subprocess.run([sys.executable, "-c", code, *arguments], capture_output=True, text=True, check=False)


@pytest.mark.parametrize(
    ("arguments", "allowed"),
    [(["--help"], []), (["--version"], []), (["parameters", "--help"], ["pydantic"])],  # Typer's own, for options
)
def test_help_imports_nothing_heavy(arguments, allowed):
    code = (
        "import atexit, sys\nfrom flycontrol.cli import main\n"
        f"atexit.register(lambda: print('HEAVY', [m for m in {HEAVY} if m in sys.modules]))\nmain()"
    )
    done = in_a_new_process(code, *arguments)
    assert done.returncode == 0
    assert done.stdout.splitlines()[-1] in {"HEAVY []", f"HEAVY {allowed}"}


def test_help_takes_less_than_300_ms_of_processor_time():
    code = (
        "import atexit, time\nfrom flycontrol.cli import main\n"
        "atexit.register(lambda: print('CPU', time.process_time()))\nmain()"
    )
    times = [float(in_a_new_process(code, "--help").stdout.split()[-1]) for _ in range(3)]
    assert min(times) < 0.3


def test_help_names_the_commands(command):
    status, printed, _ = command("--help")
    assert status == 0
    assert "parameters" in printed


def test_the_version_is_that_of_the_package(command):
    assert command("--version") == (0, f"flycontrol {version('flycontrol')}\n", "")


def test_parameters_prints_the_default_file(command):
    assert command("parameters") == (0, parameter_text(), "")


def test_what_parameters_prints_can_be_read_again(command, tmp_path):
    _, printed, _ = command("parameters", "--species", "drosophila_hydei")
    (tmp_path / "fly.toml").write_text(printed)
    assert read_parameters(tmp_path / "fly.toml").sourced() == read_parameters("drosophila_hydei").sourced()


def test_an_unknown_fly_is_refused_with_the_known_ones(refused):
    assert "there are fly, drosophila_hydei" in refused("parameters", "--species", "bee")


@pytest.mark.parametrize("arguments", [["--nonsense"], ["nonsense"], ["parameters", "--speces", "x"], []])
def test_a_wrong_option_ends_with_status_2(command, arguments):
    status, out, err = command(*arguments)
    assert status == 2
    assert "Traceback" not in out + err


def failing(error):
    def fail(_name):
        raise error

    return fail


def test_ctrl_c_ends_with_status_130(command, monkeypatch):
    monkeypatch.setattr("flycontrol.io.fly_files.parameter_text", failing(KeyboardInterrupt()))
    status, _, err = command("parameters")
    assert status == 130
    assert err.strip() == "flycontrol: interrupted; nothing was written."


def test_ctrl_c_while_the_command_line_loads_is_the_same_sentence():
    code = (
        "import sys\n"
        "class Interrupt:\n"
        "    def find_spec(self, name, path=None, target=None):\n"
        "        if name == 'typer':\n"
        "            raise KeyboardInterrupt\n"
        "sys.meta_path.insert(0, Interrupt())\n"
        "from flycontrol.__main__ import main\nmain()"
    )
    done = in_a_new_process(code)
    assert (done.returncode, done.stdout) == (130, "")
    assert done.stderr == "flycontrol: interrupted; nothing was written.\n"


@pytest.mark.parametrize(
    ("error", "said"),
    [
        (OutputError("the disk is full."), "flycontrol: the disk is full."),
        (OSError(28, "No space left on device", "x.json"), "x.json: No space left on device."),
        (MemoryError(), "the memory is full"),
    ],
)
def test_what_fails_on_the_machine_is_said_in_one_line(refused, monkeypatch, error, said):
    monkeypatch.setattr("flycontrol.io.fly_files.parameter_text", failing(error))
    assert said in refused("parameters")


def test_a_reader_that_stops_reading_is_no_traceback():
    code = "from flycontrol.cli import main; main()"
    read, write = os.pipe()
    os.close(read)
    done = subprocess.run(
        [sys.executable, "-c", code, "parameters"], stdout=write, stderr=subprocess.PIPE, text=True, check=False
    )
    os.close(write)
    assert "Traceback" not in done.stderr
