import numpy as np
import pytest
from outline import leaves, read_json

from flycontrol.report.result import FIELDS, result_json
from flycontrol.units import deg, ms


@pytest.fixture(scope="module")
def found(stable, parameters, origin):
    return read_json(result_json(stable, parameters, origin))


@pytest.fixture(scope="module")
def found_unstable(unstable, unstable_parameters, origin):
    return read_json(result_json(unstable, unstable_parameters, origin))


def test_every_field_is_documented_and_every_documented_field_exists(found):
    del found["fields"]
    present = set(leaves(found))
    assert present <= set(FIELDS)
    assert set(FIELDS) - present == {"provenance.defaulted[]"}  # nothing was defaulted here


def test_numbers_are_those_of_the_study_unrounded(found, stable):
    result = stable.result
    assert found["recovery"]["recovery_time_ms"] == result.recovery_time / ms
    assert found["margins"]["phase_margin_deg"] == result.margins.phase_margin / deg
    assert found["margins"]["gain_margin"] == result.margins.gain_margin
    assert found["modes"][0]["real_per_s"] == result.poles[0].real
    assert found["recovery_curve"]["recovery_time_ms"] == list(stable.curve.times / ms)


def test_a_verdict_a_reason_and_nulls_stand_for_an_unstable_loop(found_unstable):
    assert found_unstable["verdict"] == "unstable"
    assert found_unstable["margins"] is None
    assert found_unstable["recovery"]["recovery_time_ms"] is None
    assert found_unstable["recovery_curve"] is None
    assert "unstable" in found_unstable["reason"]
    assert found_unstable["modes"][0]["real_per_s"] > 0
    assert set(leaves({k: v for k, v in found_unstable.items() if k != "fields"})) - set(FIELDS) == {
        "margins",
        "recovery_curve",
    }


def test_the_closed_form_of_the_largest_delay_agrees_with_the_margins(found):
    difference = found["cross_checks"]["largest_stable_delay_difference_ms"]
    assert abs(difference) < 1e-12 * found["margins"]["largest_stable_delay_ms"]


def test_pade_comes_nearer_to_the_exact_pole_with_its_order(found):
    errors = [row["error_per_s"] for row in found["cross_checks"]["pade"]]
    assert [row["order"] for row in found["cross_checks"]["pade"]] == [1, 2, 4]
    assert errors[0] > 10 * errors[1] > 1000 * errors[2] > 0


def test_infinite_margins_become_null(stable, parameters, origin):
    from dataclasses import replace

    margins = replace(stable.result.margins, gain_margin=np.inf, modulus_frequency=np.inf)
    endless = replace(stable, result=replace(stable.result, margins=margins))
    found = read_json(result_json(endless, parameters, origin))
    assert found["margins"]["gain_margin"] is None
    assert found["margins"]["modulus_frequency_rad_per_s"] is None
