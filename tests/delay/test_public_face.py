import ast
import importlib
from pathlib import Path

import pytest

from flycontrol import delay


def declared():
    """Module and name of every import that type checkers see in the package's first file."""
    tree = ast.parse(Path(delay.__file__).read_text(encoding="utf-8"))
    imports = [
        node for node in ast.walk(tree) if isinstance(node, ast.ImportFrom) and node.module.startswith("flycontrol")
    ]
    return [(node.module, alias.name) for node in imports for alias in node.names]


def test_what_type_checkers_see_is_what_the_package_offers():
    assert sorted(name for _, name in declared()) == dir(delay)


@pytest.mark.parametrize(("module", "name"), declared())
def test_a_name_means_the_same_in_the_package_as_in_its_module(module, name):
    """Also where a module bears the name of its function, and has been imported first."""
    assert getattr(delay, name) is getattr(importlib.import_module(module), name)


def test_a_name_that_is_not_offered_is_refused():
    with pytest.raises(AttributeError, match="no attribute 'smith_predictor'"):
        _ = delay.smith_predictor
