import json
from pathlib import Path

import numpy as np
import pytest
from lab_note import lab_note

ANALYSES = Path(__file__).resolve().parents[2] / "analyses"

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    """The lab note as a module, its findings, and the folder that it wrote."""
    note = lab_note("flutter_or_tumble")
    folder = tmp_path_factory.mktemp("flutter_or_tumble")
    return note, note.main(folder), folder


def test_the_border_is_the_published_one(results):
    _, found, _ = results
    assert found.critical == pytest.approx(1.2191, abs=5e-5)


def test_near_the_border_the_period_grows_with_twice_the_time_constant_of_the_edgewise_fall(results):
    """T_0 = 4.3629 is published as a fit; from a hundred times nearer the period is longer by (2 / growth) ln 100."""
    note, found, _ = results
    period = dict(zip(np.round(note.NEARNESS, 9), found.periods, strict=True))
    for side in (-1, 1):
        slope = (period[side * 1e-5] - period[side * 1e-3]) / np.log(100)
        assert slope == pytest.approx(2 / found.growth, rel=2e-3)
    assert found.intercept == pytest.approx(4.3629, abs=0.01)


def test_a_thicker_plate_needs_less_inertia_to_tumble_and_so_does_a_less_damped_one(results):
    _, found, _ = results
    assert found.boundary[0] == pytest.approx(found.critical, abs=2e-4)
    assert np.all(np.diff(found.boundary) < 0)
    assert np.all(np.diff(found.by_dissipation) > 0)
    for c in found.crossings:
        assert c.inertia_ratio == pytest.approx(c.density_ratio * c.thickness_ratio)


def test_the_note_states_the_numbers_that_it_finds(results):
    _, found, folder = results
    text = " ".join((ANALYSES / "flutter_or_tumble.py").read_text(encoding="utf-8").replace("\n#", " ").split())
    aluminium, steel = found.crossings
    assert (
        f"thickness of {aluminium.thickness_ratio:.2f} of its width on and steel from {steel.thickness_ratio:.2f}"
        in text
    )
    assert f"moves the border no further than to {found.by_dissipation[0]:.2f}" in text
    assert f"it says {found.critical / 2:.2f}" in text
    numbers = json.loads((folder / "flutter_or_tumble.json").read_text(encoding="utf-8"))
    assert numbers["critical_inertia_ratio"] == pytest.approx(found.critical, rel=1e-6)
    assert (folder / "flutter_or_tumble.svg").stat().st_size < 300_000
    assert sorted(path.suffix for path in folder.iterdir()) == [".json", ".md", ".svg"]
