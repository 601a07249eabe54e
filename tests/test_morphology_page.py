import json
import re
import tomllib
from pathlib import Path

import numpy as np
import pytest

from flycontrol.io.morphology_files import read_morphology
from flycontrol.io.stroke_files import read_stroke

PAGE = (Path(__file__).resolve().parents[1] / "docs" / "morphology.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"```toml\n(.*?)```", PAGE, re.DOTALL)
FLIES = [text for text in BLOCKS if "mass" in tomllib.loads(text)]
STROKES = [text for text in BLOCKS if "frequency" in tomllib.loads(text)]


@pytest.mark.parametrize("text", FLIES, ids=["whole", "changed", "outline"])
def test_every_fly_of_the_page_is_read(tmp_path, text):
    (tmp_path / "outline.csv").write_text("x,y\n0.1,0.0\n0.1,1.0\n-0.2,0.9\n-0.2,0.2")
    path = tmp_path / "fly.toml"
    path.write_text(text)
    written = tomllib.loads(text)["mass"]
    assert read_morphology(path).morphology.mass == pytest.approx(float(written.removesuffix(" mg")) * 1e-6, rel=1e-15)


def test_the_python_of_the_page_runs(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    for text in re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL):
        exec(compile(text, "docs/morphology.md", "exec"), {})
    assert "freeflightplots" in capsys.readouterr().out


@pytest.fixture
def measured(tmp_path):
    """Folder with the files that the page's strokes name: a wingbeat of 1 / (189 Hz), and a series."""
    phase = np.arange(50) / 50
    rows = np.stack([phase / 0.189, 70 * np.cos(2 * np.pi * phase), 0 * phase, 90 + 45 * np.sin(2 * np.pi * phase)], 1)
    lines = [",".join(map(repr, row)) for row in rows.tolist()]
    (tmp_path / "wing.csv").write_text("\n".join(["t,stroke,deviation,pitch", *lines]))
    series = {"phi": {"a0": 0.0, "ai": [70.0], "bi": [0.0]}, "alpha": {"bi": [36.0]}}
    (tmp_path / "series.json").write_text(json.dumps(series))
    return tmp_path


@pytest.mark.parametrize("text", STROKES, ids=lambda text: re.search('kind = "(.*)"', text)[1])
def test_every_stroke_of_the_page_is_read_and_starts_at_the_back_with_the_leading_edge_ahead(measured, text):
    path = measured / "stroke.toml"
    path.write_text(text)
    kinematics = read_stroke(path)
    for side in ("left", "right"):
        dorsal, middle = kinematics.wing(side)(np.array([0.0, 0.25])).angles
        assert np.radians(-80) < dorsal[0] < np.radians(-60)
        assert np.radians(30) < middle[2] < np.radians(60)


def test_the_page_shows_flies_and_strokes():
    assert (len(FLIES), len(STROKES)) == (3, 4)
