"""The four lab notes on replayed flights, with few draws of the noise."""

import importlib
import json
import sys
from pathlib import Path

import numpy as np
import pytest

ANALYSES = Path(__file__).resolve().parents[2] / "analyses"
NOTES = (
    "replayed_flights",
    "why_crude_replays_miss_yaw",
    "noise_ceiling_of_a_replay",
    "mass_seen_by_the_wings",
)

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def notes(real_data):
    """All four by name; they import one another as scripts in one folder do."""
    sys.path.insert(0, str(ANALYSES))
    found = {name: importlib.import_module(name) for name in NOTES}
    found["replayed_flights"].DATA = real_data
    found["noise_ceiling_of_a_replay"].DRAWS = 6
    found["mass_seen_by_the_wings"].DRAWS = 6
    yield found
    sys.path.remove(str(ANALYSES))
    for name in NOTES:
        del sys.modules[name]


def written(folder: Path, name: str) -> object:
    """Figure, page and numbers are there; the numbers."""
    assert sorted(path.suffix for path in folder.iterdir()) == [".json", ".md", ".svg"]
    assert (folder / f"{name}.svg").stat().st_size < 300_000
    return json.loads((folder / f"{name}.json").read_text(encoding="utf-8"))


def test_torques_of_all_flights_are_right_in_size_and_forces_fall_short(notes, tmp_path):
    *singles, together = notes["replayed_flights"].main(tmp_path)
    assert all(a.slope.low < 1 < a.slope.high for a in together.torques)
    assert all(a.correlation.low > 0 for a in together.torques)
    assert all(2 / 3 < flight.lift_over_need < 1 for flight in singles)
    assert len(written(tmp_path, "replayed_flights")["flights"]) == 4


def test_no_single_suspect_but_inertia_counter_torque_and_signs_takes_the_yaw_away(notes, tmp_path):
    rows = notes["why_crude_replays_miss_yaw"].main(tmp_path)
    lost = {row.change for row in rows if row.axes[2].correlation.value < 0.4}
    assert lost == {
        "crude: translation alone against I_kk w_k'",
        "product of inertia times 0",
        "left and right exchanged",
        "pitch turned round",
        "deviation turned round",
        "wings do not feel the body turn",
        "without the last ten wingbeats",
    }
    assert len(written(tmp_path, "why_crude_replays_miss_yaw")["rows"]) == len(rows)


def test_a_perfect_model_loses_correlation_with_jitter_and_keeps_its_slope(notes, tmp_path):
    """Slopes within what smoothing the body costs a clean twin, a third at most."""
    for none, half, whole in notes["noise_ceiling_of_a_replay"].main(tmp_path):
        means = [c.correlation.mean(axis=0) for c in (none, half, whole)]
        assert np.all(means[0] >= means[1])
        assert np.all(means[1] > means[2])
        assert np.all(np.abs(none.slope - 1) < 1 / 3)
    assert len(written(tmp_path, "noise_ceiling_of_a_replay")) == 9


def test_twins_give_back_their_inertia_and_real_flights_the_yaw_row(notes, tmp_path):
    rows, points = notes["mass_seen_by_the_wings"].main(tmp_path)
    moments = [row for row in rows if row.quantity.startswith("I_")]
    assert all(abs(row.twins - row.expected) < 3 * row.twins_spread for row in moments)
    assert all(row.low < row.expected < row.high for row in moments if row.row.startswith("yaw"))
    for point in points:
        assert np.hypot(*point.twins.mean(axis=0)) < 0.2 * np.hypot(*point.own_offset)
    written(tmp_path, "mass_seen_by_the_wings")
