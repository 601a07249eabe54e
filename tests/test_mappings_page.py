import re
import tomllib
from pathlib import Path

import pytest

from flycontrol.io.mapping import read_mapping

PAGE = (Path(__file__).resolve().parents[1] / "docs" / "mappings.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"```toml\n(.*?)```", PAGE, re.DOTALL)


@pytest.mark.parametrize("text", BLOCKS, ids=lambda text: tomllib.loads(text)["name"])
def test_every_mapping_of_the_page_is_read(tmp_path, text):
    path = tmp_path / "map.toml"
    path.write_text(text)
    assert read_mapping(path).name == tomllib.loads(text)["name"]


def test_the_page_shows_mappings():
    assert len(BLOCKS) == 5
