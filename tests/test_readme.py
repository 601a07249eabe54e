"""What the README shows works as printed."""

import contextlib
import io
import re
from pathlib import Path

from typer.testing import CliRunner

from flycontrol.cli import app
from flycontrol.identify.gains.synthetic import synthetic_experiment
from flycontrol.io.example_files import example_files

ROOT = Path(__file__).resolve().parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")


def test_a_fit_from_python_takes_five_lines_and_holds_the_truth(tmp_path, monkeypatch):
    (block,) = [b for b in re.findall(r"^```python\n(.*?)^```$", README, re.MULTILINE | re.DOTALL) if "fit_gains" in b]
    assert len([line for line in block.splitlines() if line]) <= 5
    made = synthetic_experiment(0, 1)
    (tmp_path / "demo").mkdir()
    for name, text in example_files(made.trials, made.flies, made.impulses, 0).items():
        (tmp_path / "demo" / name).write_text(text)
    monkeypatch.chdir(tmp_path)
    names, printed = {}, io.StringIO()
    with contextlib.redirect_stdout(printed):
        exec(compile(block, "README.md", "exec"), names)
    assert printed.getvalue().startswith("converged")
    delay = names["found"]["delay"]
    assert abs(delay.value - made.flies["fly1"]["delay"]) < 4 * delay.standard_error


def test_the_commands_of_the_readme_have_only_options_that_exist():
    lines = re.findall(r"^flycontrol (\w+)(.*)$", README, re.MULTILINE)
    assert {name for name, _ in lines} >= {"report", "example", "fit", "experiment", "simulate", "validate", "track"}
    for name, rest in lines:
        shown = CliRunner().invoke(app, [name, "--help"])
        assert shown.exit_code == 0, name
        assert all(option in shown.output for option in re.findall(r"--[a-z-]+", rest)), name


def test_every_file_that_the_readme_links_exists():
    links = [link for link in re.findall(r"\]\(([^)#]+)", README) if "://" not in link]
    assert links
    assert [link for link in links if not (ROOT / link).exists()] == []


def test_a_fly_is_tracked_from_python_as_printed():
    (block,) = [b for b in re.findall(r"^```python\n(.*?)^```$", README, re.MULTILINE | re.DOTALL) if "track(" in b]
    names, printed = {}, io.StringIO()
    with contextlib.redirect_stdout(printed):
        exec(compile(block, "README.md", "exec"), names)
    away = names["motion"].pose.yaw - names["filmed"].truth.yaw
    assert names["found"].believed.all()
    assert abs(away).max() < 0.05
