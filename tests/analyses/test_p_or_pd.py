import json

import pytest
from lab_note import lab_note

from flycontrol.units import deg, ms

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def note():
    """The lab note with fewer repetitions, at two levels of noise."""
    module = lab_note("p_or_pd")
    module.VARIANTS = tuple((*variant[:3], 6 if variant[1] == 1 else 2) for variant in module.VARIANTS)
    module.NOISES = (0.3 * deg, 4.8 * deg)
    return module


def test_p_needs_a_delay_that_the_fly_has_not_or_misses_by_degrees(note):
    for damping in note.DAMPINGS:
        found = note.best_p(note.pd_fly(damping))
        assert found.recovery < 60 * ms
        assert found.free_delay < 0.6 * note.DELAY
        assert found.known_miss > 1 * deg
        assert found.known_recovery > 60 * ms


def test_low_noise_shows_pd_and_high_noise_does_not(note, tmp_path):
    note.false_alarms = lambda: [note.cell(note.VARIANTS[0], note.p_fly(176.0), 0.3 * deg)]
    cells = note.main(tmp_path)
    known = [c for c in cells if c.variant == "one recording, damping known"]
    low, high = ([c for c in known if c.noise == noise] for noise in note.NOISES)
    assert all(share == 1.0 for c in low for share in c.shares)
    assert sum(c.wins[1] for c in high) < 0.6 * sum(c.repetitions for c in high)
    numbers = json.loads((tmp_path / "p_or_pd.json").read_text(encoding="utf-8"))
    assert len(numbers["cells"]) == len(cells) == 18
    assert sorted(path.suffix for path in tmp_path.iterdir()) == [".json", ".md", ".svg"]
    assert (tmp_path / "p_or_pd.svg").stat().st_size < 300_000
