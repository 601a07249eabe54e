import json

import numpy as np
import pytest

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def found(fresh_reports):
    return json.loads((fresh_reports[0] / "result.json").read_text())


def test_the_fly_recovers_from_20_degrees_within_60_ms_and_15_wingbeats(found):
    assert found["recovery"]["peak_deg"] == pytest.approx(20)
    assert found["recovery"]["recovery_time_ms"] < 60
    assert found["recovery"]["recovery_time_wingbeats"] < 15


def test_the_best_proportional_control_at_the_same_damping_and_delay_misses_60_ms(found):
    own = next(row for row in found["damping_table"] if row["damping_per_s"] == found["loop"]["damping_per_s"])
    assert own["proportional"]["recovery_time_ms"] > 60
    assert own["proportional"]["derivative_gain_per_s"] == 0


def test_the_table_shows_from_which_damping_proportional_control_meets_60_ms(found):
    boundary = found["proportional"]["suffices_from_per_s"]
    assert found["proportional"]["deadline_ms"] == 60
    for row in found["damping_table"]:
        meets = row["proportional"]["recovery_time_ms"] <= 60
        assert meets == (row["damping_per_s"] >= boundary)


def test_pd_with_half_a_modulus_margin_meets_60_ms_over_the_whole_range(found):
    rows = found["damping_table"]
    assert rows[-1]["damping_per_s"] == pytest.approx(found["parameters"]["damping_high"]["value"])
    for row in rows:
        assert row["proportional_derivative"]["recovery_time_ms"] < 60
        assert row["proportional_derivative"]["modulus_margin"] > 0.499  # the search ends within 1e-4 of the bound


def test_recovery_time_rises_sharply_and_then_plateaus(found):
    peaks, times = (np.array(found["recovery_curve"][key]) for key in ("peak_deg", "recovery_time_ms"))

    def mean_slope(low, high):
        first, last = np.interp([low, high], peaks, times)
        return (last - first) / (high - low)

    assert 0 < mean_slope(20, 40) <= mean_slope(3, 6) / 5


def test_the_closed_form_confirms_the_largest_stable_delay(found):
    checked = found["cross_checks"]
    assert checked["largest_stable_delay_closed_form_ms"] == pytest.approx(
        found["margins"]["largest_stable_delay_ms"], rel=1e-12
    )
