"""The report of flies that differ: two flies, fitted once."""

import csv
import io
import re

import pytest
from outline import Outline, read_json

from flycontrol.identify.gains.apart import ApartStudy, study_of
from flycontrol.identify.gains.model import gain_model
from flycontrol.identify.gains.study import FitOptions
from flycontrol.identify.gains.synthetic import synthetic_experiment
from flycontrol.io.parameters import read_parameters
from flycontrol.report.apart.page import apart_page, apart_provenance, write_apart_report
from flycontrol.report.apart.result import apart_estimates_csv, apart_result_json, apart_table


@pytest.fixture(scope="module")
def study():
    made = synthetic_experiment(0, 2).trials
    model = gain_model(fixed={"initial_yaw": 0.0, "initial_rate": 0.0})
    found = study_of([made[1], made[2], made[5], made[6]], model, FitOptions(compare=False), shared="fly")
    assert isinstance(found, ApartStudy)
    return found


@pytest.fixture(scope="module")
def origin(study):
    return apart_provenance(study, "flycontrol fit demo")


def test_the_page_names_every_fly_with_its_margins_and_is_well_formed(study, origin):
    page = apart_page(study, origin)
    outline = Outline(page)
    assert not outline.errors
    assert not outline.open
    assert len(outline.ids) == len(set(outline.ids))
    assert {"margins", "figure-fits", "figure-recoveries"} <= set(outline.ids)
    for member in study.members:
        assert f'<a href="{member.folder}/index.html">{member.name}</a>' in page
    assert not re.search(r"\b(nan|inf|None)\b", outline.text)


def test_the_numbers_of_each_fly_are_those_of_its_own_fit(study, origin):
    found = read_json(apart_result_json(study, origin))
    assert [each["name"] for each in found["members"]] == [member.name for member in study.members]
    kp = {e["name"]: e["value"] for e in found["members"][1]["result"]["estimates"]}["kp"]
    assert kp == study.members[1].study.result["kp"].value
    rows = list(csv.DictReader(io.StringIO(apart_estimates_csv(study))))
    assert {row["member"] for row in rows} == {member.name for member in study.members}
    assert float(next(row for row in rows if row["member"] == "fly2" and row["name"] == "kp")["value"]) == kp
    table = apart_table(study)
    assert "| mean |" in table
    assert "| standard deviation between flies |" in table
    assert all(f"| {member.name} |" in table for member in study.members)


@pytest.mark.slow
def test_each_fly_gets_a_whole_report_in_its_own_folder(study, tmp_path):
    write_apart_report(study, read_parameters(), tmp_path, command="flycontrol fit demo")
    for folder in (tmp_path / "fly1", tmp_path / "fly2"):
        assert {path.name for path in folder.iterdir()} == {
            "index.html", "stability.html", "result.json", "estimates.csv", "table.md",
        }  # fmt: skip
    links = re.findall(r'href="([^"#]+)"', (tmp_path / "index.html").read_text())
    assert links
    assert all((tmp_path / link).is_file() for link in links)
