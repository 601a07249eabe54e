import json

import pytest
import scipy.stats
from lab_note import lab_note

RECORDINGS = 120

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    """The accounts, and the folder that the lab note wrote."""
    note = lab_note("interval_coverage")
    folder = tmp_path_factory.mktemp("coverage")
    return note.main(folder, RECORDINGS, 1), folder


def test_every_unknown_is_covered_as_promised(results):
    found, _ = results
    assert len(found) == 14
    for account in found:
        assert account.recordings == RECORDINGS
        assert account.inside >= scipy.stats.binom.ppf(0.0005, RECORDINGS, 0.95), account


def test_the_correction_takes_the_bias_off_kd(results):
    found, _ = results
    kd = next(a for a in found if (a.noise, a.damping, a.name) == ("coloured", "free", "kd"))
    assert kd.bias_of_least_squares - kd.bias > 0.15
    assert abs(kd.bias) < 0.1 + 3 * kd.bias_error


def test_the_coverage_is_written_as_page_numbers_and_figure(results):
    found, folder = results
    numbers = json.loads((folder / "coverage.json").read_text(encoding="utf-8"))
    assert [row["inside"] for row in numbers] == [account.inside for account in found]
    assert sorted(path.name for path in folder.iterdir()) == ["coverage.json", "coverage.md", "coverage.svg"]
