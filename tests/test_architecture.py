"""What import-linter does not say: which rooms know which libraries."""

import ast
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
PACKAGE = ROOT / "flycontrol"
MODULES = sorted(PACKAGE.rglob("*.py"))


def imports_of(path: Path, *, top_level_only: bool = False) -> set[str]:
    """Full names of all modules that a file imports, those for type checking included."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    nodes = tree.body if top_level_only else ast.walk(tree)
    found = set()
    for node in nodes:
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path.name} imports relatively"
            found |= {f"{node.module}.{alias.name}" for alias in node.names}
    return found


def knows(path: Path, library: str) -> bool:
    return any(name.split(".")[0] == library for name in imports_of(path))


def room(path: Path) -> str:
    return path.relative_to(PACKAGE).parts[0]


def is_kernel(path: Path) -> bool:
    return path.stem == "kernels" or path.parent.name == "kernels"


def test_the_theory_of_delay_systems_knows_no_fly():
    allowed = ("flycontrol.delay.", "flycontrol.jobs.", "flycontrol.units.", "flycontrol.errors.")
    for path in (PACKAGE / "delay").rglob("*.py"):
        ours = {name for name in imports_of(path) if name.startswith("flycontrol")}
        assert all(f"{name}.".startswith(allowed) for name in ours), path
        words = set(re.findall(r"[a-z]+", path.read_text(encoding="utf-8").lower()))
        assert not words & {"yaw", "wing", "wingbeat", "haltere", "paddling"}, path


def test_only_model_and_identify_know_casadi():
    assert {room(path) for path in MODULES if knows(path, "casadi")} <= {"model", "identify"}


def test_only_kernels_know_numba():
    assert not [path for path in MODULES if knows(path, "numba") and not is_kernel(path)]


def test_only_jobs_knows_dask():
    assert {room(path) for path in MODULES if knows(path, "distributed") or knows(path, "dask")} <= {"jobs"}


def test_only_the_process_that_opens_binary_files_knows_their_libraries():
    """They crash on damaged files; where they are imported, a crash takes the command with it. New files are whole."""
    for library in ("h5py", "pyarrow", "netCDF4"):
        for path in MODULES:
            assert not knows(path, library) or path.relative_to(PACKAGE).parts[:2] == ("io", "binary"), path


def test_only_the_certificate_and_the_design_know_cvxpy():
    for path in MODULES:
        if knows(path, "cvxpy"):
            assert path.relative_to(PACKAGE).parts[:2] in {
                ("delay", "certificate.py"), ("delay", "certificate"), ("delay", "design.py"), ("delay", "design"),
            }, path  # fmt: skip


def test_libraries_that_are_slow_to_load_are_loaded_when_called():
    """`control` takes a second and a half and matplotlib half a one: no module loads them with itself."""
    for path in MODULES:
        early = {name.split(".")[0] for name in imports_of(path, top_level_only=True)}
        assert not early & {"control", "cvxpy"}, path
        assert "matplotlib" not in early or room(path) == "report", path


def test_the_command_line_loads_nothing_heavy_by_itself():
    for path in (PACKAGE / "cli").rglob("*.py"):
        early = {name.split(".")[0] for name in imports_of(path, top_level_only=True)}
        assert not early & {"numpy", "scipy", "matplotlib", "control", "casadi", "cvxpy", "numba"}, path


def test_the_package_never_looks_for_the_real_data_or_the_analyses():
    for path in MODULES:
        assert "shared/data" not in path.read_text(encoding="utf-8"), path
        assert not knows(path, "analyses"), path


@pytest.mark.parametrize(
    "name", ["Makefile", "pyproject.toml", "constraints.txt", ".ci/run", ".pre-commit-config.yaml"]
)
def test_no_build_file_names_the_host_of_a_package_registry(name):
    text = (ROOT / name).read_text(encoding="utf-8")
    for option in ("index-url", "find-links", "trusted-host", "--proxy"):
        assert option not in text
    hosts = set(re.findall(r"https?://([^/\s\"']+)", text))
    assert hosts <= {"github.com"}  # pre-commit's hooks
