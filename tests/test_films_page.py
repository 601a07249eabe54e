import contextlib
import io
import re
from pathlib import Path

from flycontrol.io.movies.inputs import READ_HERE

PAGE = (Path(__file__).resolve().parents[1] / "docs" / "films.md").read_text(encoding="utf-8")


def test_the_example_of_the_page_prints_what_it_wrote(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (code,) = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        exec(code, {})
    assert printed.getvalue().splitlines() == ["8000.0 ['camera 1', 'camera 2', 'camera 3']", "100 True"]


def test_the_page_names_every_ending_that_a_refusal_offers():
    assert all(ending.lower() in PAGE.lower() for ending in re.findall(r"\.(\w{3})\b", READ_HERE))
