"""Flies pooled where they agree, apart where they differ."""

import numpy as np
import pytest
from perturbed_fly import AT_REST, TRUTH, recording

from flycontrol.identify.gains import study
from flycontrol.identify.gains.alone import fits_alone
from flycontrol.identify.gains.apart import ApartStudy, as_folder, study_of
from flycontrol.identify.gains.model import gain_model
from flycontrol.identify.gains.stages import Stages
from flycontrol.identify.gains.study import FitOptions, FitStudy
from flycontrol.model.trial import Trial

MODEL = gain_model(fixed=AT_REST | {"damping": 69.0})
OPTIONS = FitOptions(compare=False)
FLIES = {"a": 1.0, "b": 1.0, "c": 1.0}


def experiment(factors, two=2):
    """Recordings of flies whose proportional gains differ by factors."""
    trials = []
    for fly, factor in factors.items():
        for k in range(two):
            one = recording(len(trials), truth=TRUTH | {"kp": TRUTH["kp"] * factor, "damping": 69.0})
            trials.append(
                Trial(
                    name=f"{fly}{k}", fly=fly, time=one.time, yaw=one.yaw, rate=one.rate, perturbation=one.perturbation
                )
            )
    return trials


@pytest.fixture(scope="module")
def differing():
    return study_of(experiment({"a": 0.8, "b": 1.0, "c": 1.25}), MODEL, OPTIONS)


def test_flies_that_agree_are_pooled_unless_asked_otherwise():
    trials = experiment(FLIES)
    assert isinstance(study_of(trials, MODEL, OPTIONS), FitStudy)
    assert isinstance(study_of(trials, MODEL, OPTIONS, shared="fly"), ApartStudy)
    assert isinstance(study_of(trials[:2], MODEL, OPTIONS, shared="fly"), FitStudy)  # of one fly


def test_flies_that_differ_are_not_pooled_unless_asked_to(differing):
    assert isinstance(differing, ApartStudy)
    assert differing.group.homogeneity.p < 1e-6
    assert not differing.asked
    assert "the 3 flies differ" in differing.status
    pooled = study_of(experiment({"a": 0.8, "b": 1.25}, 1), MODEL, OPTIONS, shared="all")
    assert isinstance(pooled, FitStudy)


def test_each_fly_has_its_own_truth_inside_its_intervals_and_the_mean_carries_the_spread(differing):
    for member, factor in zip(differing.members, (0.8, 1.0, 1.25), strict=True):
        kp = member.study.result["kp"]
        truth = TRUTH["kp"] * factor
        assert abs(kp.value - truth) < 4 * kp.standard_error, member.name
    kp = next(effect for effect in differing.effects if effect.kind == "kp")
    assert kp.mean_low < TRUTH["kp"] * np.mean([0.8, 1.0, 1.25]) < kp.mean_high
    assert kp.mean_high - kp.mean_low > 5 * (differing.members[0].study.result["kp"].standard_error)


def test_recordings_can_stand_apart_too():
    found = study_of(experiment({"a": 1.0}), MODEL, OPTIONS, shared="trial")
    assert isinstance(found, ApartStudy)
    assert [member.name for member in found.members] == ["a0", "a1"]
    assert "as asked" in found.status


def test_a_study_apart_keeps_and_clears_its_parts(tmp_path):
    stages = Stages(folder=tmp_path / "unfinished")
    again = study_of(experiment({"a": 0.8, "b": 1.25}), MODEL, OPTIONS, stages, shared="fly")
    assert {path.name for path in (tmp_path / "unfinished").iterdir()} >= {member.folder for member in again.members}
    stages.clear()
    assert not (tmp_path / "unfinished").exists()


def test_names_become_plain_and_different_folders():
    taken = set()
    for name, folder in (("fly 1", "fly_1"), ("fly/1", "fly_1_2"), ("../FLY_1", "FLY_1_3"), ("蝿", "fly")):
        found = as_folder(name, taken)
        assert found == folder
        taken.add(found.lower())


def test_flies_that_agree_are_fitted_alone_once(monkeypatch):
    calls = []
    monkeypatch.setattr(study, "fits_alone", lambda *a, **k: calls.append(k["by"]) or fits_alone(*a, **k))
    study_of(experiment(FLIES), MODEL, OPTIONS)
    assert sorted(calls) == ["fly", "recording"]
