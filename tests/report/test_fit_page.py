"""The report of a fit: one small experiment, fitted once."""

import csv
import io
import math
import re
from dataclasses import replace

import pytest
from outline import Outline, leaves, read_json

from flycontrol.identify.gains.design import Remedy, TradeOff, said_together
from flycontrol.identify.gains.model import gain_model
from flycontrol.identify.gains.ridge import ridge
from flycontrol.identify.gains.study import FitOptions, fit_study
from flycontrol.identify.gains.synthetic import synthetic_experiment
from flycontrol.report.fit.figures import fit_figures
from flycontrol.report.fit.page import FIGURES, fit_page, fit_provenance, fitted_fly
from flycontrol.report.fit.result import COLUMNS, FIELDS, estimates_csv, fit_result_json
from flycontrol.report.fit.words import digits_for, estimate_rows, paper_table
from flycontrol.report.fitted import fitted_from
from flycontrol.report.page import page
from flycontrol.report.provenance import provenance

_VARYING = r"^(fixed|provenance\.versions|recordings_alone|flies\.fits\[\]\.(?:values|standard_errors))\..+$"


@pytest.fixture(scope="module")
def study():
    made = synthetic_experiment(0, 2).trials
    trials = [made[1], made[2], made[5], made[6]]
    model = gain_model(estimate=["paddling_gain"], fixed={"initial_yaw": 0.0, "initial_rate": 0.0})
    found = fit_study(trials, model, FitOptions(bootstrap=20))
    at = found.result
    shown = ridge(at.weighted, at.minimum, (found.profiles["kp"], found.profiles["kd"]), side=3)
    return replace(found, ridge=shown)  # which only a fit that is not identifiable has


@pytest.fixture(scope="module")
def origin(study):
    return fit_provenance(study, "flycontrol fit demo")


def test_every_field_of_the_result_is_documented_and_every_documented_one_is_there(study, origin):
    found = read_json(fit_result_json(study, origin))
    fields = found.pop("fields")
    paths = {re.sub(_VARYING, r"\1.*", path) for path in leaves(found)}
    assert fields == FIELDS
    assert paths | {"absent.*", "ridge.open_ends[]"} == set(FIELDS)  # no such part, no such end


def test_the_table_of_estimates_is_tidy_and_agrees_with_the_fit(study):
    rows = list(csv.DictReader(io.StringIO(estimates_csv(study))))
    assert tuple(rows[0]) == COLUMNS
    for row, e in zip(rows, study.result.estimates, strict=True):
        assert (row["name"], float(row["value"]), float(row["low"])) == (e.name, e.value, e.low)
        assert row["name"] == (f"{row['kind']}[{row['owner']}]" if row["owner"] else row["kind"])
        assert bool(row["bootstrap_low"]) == (not row["owner"])
        if row["bootstrap_low"]:
            assert float(row["bootstrap_low"]) < e.value < float(row["bootstrap_high"])


def test_the_page_is_well_formed_and_says_no_nan(study, origin):
    page = fit_page(study, origin, with_stability=True)
    outline = Outline(page)
    assert not outline.errors
    assert not outline.open
    assert len(outline.ids) == len(set(outline.ids))
    inside = {target[1:] for target in outline.targets if target.startswith("#")}
    assert inside <= set(outline.ids)
    assert {f"figure-{name}" for name in FIGURES} <= set(outline.ids)
    assert not re.search(r"\b(nan|inf|None)\b", outline.text)
    assert "http" not in re.sub(r'xmlns="[^"]*"', "", page)


def test_the_fitted_flys_report_has_the_fits_numbers_sources_status_and_intervals(study, parameters, studied):
    fly = fitted_fly(study, parameters)
    gamma = study.result["paddling_gain"].value * fly.inertia.value
    assert fly.paddling_gain.value == pytest.approx(gamma)
    given = {name: each.certainty for name, each in fly.sourced().items() if each.certainty in ("user", "fit")}
    assert given == dict.fromkeys(("proportional_gain", "derivative_gain", "delay", "damping", "paddling_gain"), "fit")
    origin = provenance(fly, "flycontrol fit", None)
    text = Outline(page(studied(fly), fly, origin, fitted=fitted_from(study))).text
    assert f"The fit: {study.result.status[:30]}" in text
    assert "95 % interval" in text.split("Gain margin")[1].split("Phase margin")[0]
    assert "fitted to the recordings" in text
    assert "this fit" in text.split("Every parameter, with its source")[1].split("Certainty:")[0]
    assert "β ω" not in text  # gamma was measured


def test_numbers_of_the_stability_report_stand_unrounded_in_the_fits_result(study, origin):
    found = read_json(fit_result_json(study, origin))["stability"]
    loop = study.result.loop()
    assert found["margins"]["delay_margin_ms"] == pytest.approx(loop.margins().delay_margin * 1e3, rel=1e-9)
    assert found["modes"][0]["real_per_s"] == pytest.approx(loop.poles(1)[0].real, rel=1e-9)


@pytest.fixture(scope="module")
def unmoved():
    """A fit that says nothing, since nothing perturbed the fly."""
    trial = replace(synthetic_experiment(0, 1).trials[2], perturbation=None, paddling=None)
    trial = replace(trial, time=trial.time[::8], yaw=trial.yaw[::8], rate=trial.rate / 8)
    model = gain_model(fixed={"initial_yaw": 0.0, "initial_rate": 0.0, "damping": 69.0})
    return fit_study([trial], model, FitOptions(bootstrap=20, compare=False))


def test_nothing_is_drawn_of_a_loop_that_the_data_say_nothing_of(unmoved, parameters):
    text = Outline(fit_page(unmoved, fit_provenance(unmoved, "flycontrol fit"), with_stability=False)).text
    figures = fit_figures(unmoved)
    assert unmoved.result.status.startswith("not identifiable: no perturbation is known")
    assert "cloud" not in figures
    assert "shaded" not in figures["recordings"].caption
    assert "No data were drawn anew, since the fit says nothing of the loop." in text
    assert (unmoved.stability, unmoved.consequences, unmoved.bootstrap) == (None, None, None)
    assert fitted_fly(unmoved, parameters) is None
    for line in paper_table(unmoved).splitlines()[2:5]:
        assert line.split(" | ")[4] == "—"


def test_what_the_data_say_nothing_of_has_no_number_in_the_tables(unmoved):
    """Where a search ended among many values as good is no estimate."""
    of_the_loop = [e for e in unmoved.result.estimates if e.kind in ("kp", "kd", "delay")]
    assert all(e.undetermined for e in of_the_loop)
    assert [row.value for row in estimate_rows(unmoved.result)][:3] == ["—"] * 3
    assert str(unmoved.result).count("of any size") == 3


def with_estimate(study, **changed):
    """The study with another estimate of the paddling gain."""
    estimates = [replace(e, **changed) if e.kind == "paddling_gain" else e for e in study.result.estimates]
    return replace(study, result=replace(study.result, estimates=tuple(estimates)))


@pytest.mark.parametrize("gamma", [3.438e153, -3.438e153])
def test_a_huge_estimate_is_written_with_a_power_of_ten(study, origin, gamma):
    found = with_estimate(study, value=gamma, low=gamma - 1e152, high=gamma + 1e152, standard_error=5e151)
    row = next(row for row in estimate_rows(found.result) if row.plain == "γ/I")
    assert row.value == f"{'−' if gamma < 0 else ''}3.438×10¹⁵⁰"
    assert row.error == "5×10¹⁴⁸"
    assert not re.search(r"\d{12}", Outline(fit_page(found, origin, with_stability=False)).text.split("Provenance")[0])


@pytest.mark.parametrize("changed", [{"value": -4e4, "low": -5e4, "high": -3e4}, {"low": -math.inf, "high": math.inf}])
def test_a_paddling_gain_that_may_be_anything_is_not_that_of_the_fitted_fly(study, parameters, changed):
    fly = fitted_fly(with_estimate(study, **changed), parameters)
    assert fly.paddling_gain == parameters.paddling_gain
    assert fly.delay != parameters.delay


def test_tables_are_numbered_without_a_gap(study, unmoved):
    for each in (study, unmoved):
        text = Outline(fit_page(each, fit_provenance(each, "flycontrol fit"), with_stability=False)).text
        numbers = [int(n) for n in re.findall(r"Table (\d+)\.", text)]
        assert numbers == list(range(1, len(numbers) + 1))


def test_the_table_to_paste_holds_every_shared_estimate_with_its_unit(study):
    lines = paper_table(study).splitlines()
    assert [line.split(" | ")[1] for line in lines[2:7]] == ["K_P/I", "K_D/I", "T", "β/I", "γ/I"]
    assert lines[4].endswith("| ms |")
    kp = study.result["kp"]
    assert f"| {kp.value:.0f} | {kp.low:.0f} to {kp.high:.0f} |" in lines[2]


@pytest.mark.parametrize(("error", "digits"), [(38.0, 0), (3.8, 1), (0.38, 2), (0.0996, 3), (float("inf"), 0)])
def test_two_digits_of_the_error_are_written(error, digits):
    assert digits_for(error, 3050.0) == digits


def test_words_have_the_number_of_their_noun_and_gains_one_name(unmoved, study):
    one = Outline(fit_page(unmoved, fit_provenance(unmoved, "flycontrol fit"), with_stability=False)).text
    assert not re.search(r"\b1 (recordings|flies|fits|estimates)\b|\borders (\d) to \2\b", one)
    assert "1 recording of 1 fly" in paper_table(unmoved)
    assert "N_fly = -(K_P psi + K_D psi')(t - T)" in paper_table(study)
    two = Outline(fit_page(study, fit_provenance(study, "flycontrol fit"), with_stability=False)).text
    prose = two.split("Provenance")[0]
    assert not re.search(r"\b(kp|kd)\b", prose)


def test_trade_offs_that_only_more_recordings_narrow_share_a_sentence(study):
    more = Remedy(what="a second recording like each", correlation=-0.8, errors=(0.71, 0.7))
    other = Remedy(what="damping known from elsewhere", correlation=0.2, errors=(0.4, 0.5))
    pairs = [TradeOff(first="kp", second=second, correlation=-0.8, remedies=(more,)) for second in ("kd", "delay")]
    parted = TradeOff(first="kd", second="delay", correlation=0.9, remedies=(other, more))
    said = said_together([*pairs, parted])
    assert said[0] == parted.sentence
    assert said[1].startswith("Correlated are kp and kd (-0.80), kp and delay (-0.80);")
    assert len(said) == 2
