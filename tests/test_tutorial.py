"""The tutorial's code runs as printed, and prints what the tutorial says."""

import contextlib
import io
import re
from pathlib import Path

import matplotlib as mpl
import matplotlib.pyplot as plt
import pytest

mpl.use("Agg")

TUTORIAL = Path(__file__).resolve().parents[1] / "docs" / "tutorial.md"
BLOCKS = re.findall(r"^```python\n(.*?)^```$", TUTORIAL.read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL)


@pytest.fixture(scope="module")
def printed():
    """What each block of the tutorial prints, line by line, run one after the other as a reader would."""
    names, texts = {}, []
    for block in BLOCKS:
        text = io.StringIO()
        with contextlib.redirect_stdout(text):
            exec(compile(block, str(TUTORIAL), "exec"), names)
        texts.append(text.getvalue().splitlines())
    plt.close("all")
    return texts


@pytest.mark.parametrize("number", range(len(BLOCKS)))
def test_a_block_prints_what_the_tutorial_says(printed, number):
    assert printed[number] == re.findall(r"# -> (.*)$", BLOCKS[number], re.MULTILINE)


def test_every_printed_line_of_the_tutorial_is_stated():
    for block in BLOCKS:
        assert len(re.findall(r"print\(", block)) == len(re.findall(r"# -> ", block))
