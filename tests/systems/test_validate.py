"""`flycontrol validate` as a whole: every analysis, once, and its numbers against truths stated elsewhere."""

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
NUMBER = r"[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?"

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def whole(real_data, tmp_path_factory):
    """The folder of a run from nothing, and what it said."""
    out = tmp_path_factory.mktemp("validation")
    status, said = validated(out, real_data)
    assert status == 0, said
    return out, said


def validated(out, data):
    paths = os.pathsep.join([str(ROOT), os.environ.get("PYTHONPATH", "")])
    done = subprocess.run(
        [sys.executable, "-m", "flycontrol", "validate", "--out", str(out), "--data", str(data)],
        cwd=ROOT, env=os.environ | {"PYTHONPATH": paths}, capture_output=True, text=True, check=False,
    )  # fmt: skip
    return done.returncode, done.stderr


@pytest.fixture(scope="module")
def found(whole):
    return json.loads((whole[0] / "result.json").read_text(encoding="utf-8"))


def numbers(text):
    return [float(number) for number in re.findall(NUMBER, text)]


def row(found, analysis, words):
    (only,) = [c for c in found["claims"] if c["analysis"] == analysis and words in c["claim"]]
    return only


def test_a_second_run_runs_nothing_and_writes_the_same_bytes(whole, real_data):
    out, _ = whole
    before = {path: path.read_bytes() for path in out.rglob("*") if path.is_file()}
    status, said = validated(out, real_data)
    assert status == 0
    assert ", 0 of them run now" in said
    assert {path: path.read_bytes() for path in out.rglob("*") if path.is_file()} == before


def test_every_analysis_ran_and_every_row_leads_to_a_report(whole, found):
    out, _ = whole
    assert all(not analysis["failure"] for analysis in found["analyses"])
    assert all((out / claim["link"]).is_file() for claim in found["claims"])
    stating = {analysis["name"] for analysis in found["analyses"] if analysis["claims"]}
    assert {claim["analysis"] for claim in found["claims"]} == stating


def test_figures_3_to_8_have_claims_and_some_fail(found):
    named = " ".join(f"{claim['where']} {claim['published']}" for claim in found["claims"])
    assert {int(number) for number in re.findall(r"Figs?\. ?(\d)", named)} >= {3, 4, 5, 6, 7, 8}
    assert {claim["section"] for claim in found["claims"]} >= {1, 3, 4, 5, 6, 7}
    assert found["counts"]["fails"] > 0
    assert sum(found["counts"].values()) == len(found["claims"])
    assert {claim["basis"] for claim in found["claims"]} >= {"simulated", "real data"}


def test_a_number_inside_its_published_range_agrees_and_one_outside_fails(found):
    judged = 0
    for claim in found["claims"]:
        ends = re.fullmatch(rf"({NUMBER}) to ({NUMBER})", claim["published"])
        ours = numbers(re.sub(r"\([^)]*\)", "", claim["ours"]))
        if ends and claim["verdict"] in ("agrees", "fails") and " to " not in claim["ours"]:
            inside = all(float(ends[1]) <= number <= float(ends[2]) for number in ours)
            assert (claim["verdict"] == "agrees") == inside, claim
            judged += 1
    assert judged >= 4


def test_falling_plates_tumble_where_it_was_published(found):
    border = numbers(row(found, "flutter_or_tumble", "tumbles")["ours"])
    assert border == pytest.approx([1.2191], abs=5e-5)


def test_recovery_takes_under_60_ms_with_pd_and_more_with_p(found):
    ours = row(found, "late_but_in_time", "under 15 wingbeats")["ours"]
    milliseconds, wingbeats, *_ = numbers(ours)
    assert milliseconds < 60
    assert wingbeats == pytest.approx(0.220 * milliseconds, abs=0.06)  # at 220 Hz, both rounded
    proportional = numbers(row(found, "is_yaw_control_fast_enough", "P control fails")["ours"])[0]
    assert proportional == pytest.approx(99, abs=1)  # the design's figure for beta/I = 69 1/s
    rises = numbers(row(found, "late_but_in_time", "plateaus")["ours"].partition(" ms")[0])
    assert rises == sorted(rises)


def test_the_slope_of_turns_is_that_of_torques_on_a_held_fly(found):
    """Eq. 5 by two ways: turns flown on the tether, and gamma/beta from torques, over the same omega."""
    (turns,) = [claim for claim in found["claims"] if claim["claim"] == "turn angle over paddling parameter"]
    flown = numbers(turns["ours"])[0]
    torques = numbers(row(found, "turn_angle_from_paddling", "gamma/beta over omega")["ours"])[0]
    assert flown == pytest.approx(torques, abs=0.02)


def test_measured_motion_takes_work_from_the_hinge_and_its_spring_transmits_less_than_all(found):
    assert all(work < 0 for work in numbers(row(found, "hinge_as_a_spring", "counter-clockwise")["ours"]))
    for claim in found["claims"]:
        if claim["analysis"] == "hinge_as_a_spring" and claim["claim"] == "mu, simulated hover":
            assert all(0 < mu < 1 for mu in numbers(claim["ours"]))
