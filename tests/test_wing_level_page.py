"""The page on the wing level: its code runs as printed, and prints what the page says."""

import contextlib
import io
import re
from pathlib import Path

PAGE = (Path(__file__).resolve().parents[1] / "docs" / "wing_level.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"^```python\n(.*?)^```$", PAGE, re.MULTILINE | re.DOTALL)


def test_every_block_prints_what_the_page_says():
    names = {}
    for block in BLOCKS:
        printed = io.StringIO()
        with contextlib.redirect_stdout(printed):
            exec(compile(block, "docs/wing_level.md", "exec"), names)
        said = [line for lines in re.findall(r"# -> (.*)$", block, re.MULTILINE) for line in lines.split(" | ")]
        assert printed.getvalue().splitlines() == said
