import re
import tomllib
from pathlib import Path

import pytest

from flycontrol.io.morphology_files import read_morphology

PAGE = (Path(__file__).resolve().parents[1] / "docs" / "morphology.md").read_text(encoding="utf-8")
FLIES = [text for text in re.findall(r"```toml\n(.*?)```", PAGE, re.DOTALL) if "mass" in tomllib.loads(text)]


@pytest.mark.parametrize("text", FLIES, ids=lambda text: next(iter(tomllib.loads(text))))
def test_every_fly_of_the_page_is_read(tmp_path, text):
    path = tmp_path / "fly.toml"
    path.write_text(text)
    written = tomllib.loads(text)["mass"]
    assert read_morphology(path).morphology.mass == pytest.approx(float(written.removesuffix(" mg")) * 1e-6, rel=1e-15)


def test_the_python_of_the_page_runs(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    for text in re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL):
        exec(compile(text, "docs/morphology.md", "exec"), {})
    assert "freeflightplots" in capsys.readouterr().out


def test_the_page_shows_flies():
    assert len(FLIES) == 2
