"""What the lab note on silhouettes films and counts, on a small case of it."""

import json
import re

import numpy as np
import pytest
from lab_note import lab_note

from flycontrol.io.claims import read_claims
from flycontrol.units import deg, mm, um
from flycontrol.vision.stance import step_between

NAME = "how_well_can_silhouettes_tell"


@pytest.fixture(scope="module")
def note():
    return lab_note(NAME)


@pytest.fixture(scope="module")
def small(note, tmp_path_factory):
    """The note as a module, findings of a few frames, and the folder that they were written to."""
    filmings = tuple(each for each in note.FILMINGS if each.name in ("no legs", "body 10 % smaller"))
    plan = note.Plan(stretches=1, warm=1, counted=2, whole=0.1, filmings=(note.REFERENCE, *filmings))
    folder = tmp_path_factory.mktemp(NAME)
    return note, note.main(folder, plan), folder


def looks(camera):
    return camera.rays(np.array([[(n - 1) / 2 for n in camera.shape[::-1]]])).direction[0]


@pytest.mark.parametrize("angle", [30, 60, 90])
def test_three_cameras_stand_the_same_angle_from_one_another_and_a_fourth_in_their_middle(note, angle):
    ways = [looks(camera) for camera in note.cameras_apart(angle * deg, 4, 35 / mm)]
    for k in range(3):
        assert ways[k] @ ways[(k + 1) % 3] == pytest.approx(np.cos(angle * deg), abs=1e-12)
        assert ways[3] @ ways[k] == pytest.approx(ways[3] @ ways[(k + 1) % 3], abs=1e-12)


def test_every_way_to_film_has_a_name_of_its_own_and_sees_the_whole_fly(note):
    assert len({each.name for each in note.FILMINGS}) == len(note.FILMINGS)
    for filming in note.FILMINGS:
        for views in filming.silhouettes(filming.flight()[::90], 1):
            for mask in views:
                assert mask.any()
                border = np.concatenate([mask[0], mask[-1], mask[:, 0], mask[:, -1]])
                assert not border.any()


def test_stretches_together_cover_the_wingbeat_and_stay_within_the_flight(note):
    plan, frames = note.Plan(), len(note.REFERENCE.flight())
    starts = plan.starts(note.REFERENCE, frames)
    seen = np.concatenate([note.phases(first + plan.warm, plan.counted) for first in starts])
    gaps = np.diff(np.sort(np.append(seen, np.min(seen) + 1)))
    assert np.max(gaps) < 1.1 * note.FREQUENCY / note.RATE  # no frame of the wingbeat is left out
    for filming in note.FILMINGS:
        firsts = plan.starts(filming, frames)
        assert min(firsts) >= 1
        assert max(firsts) + plan.warm + plan.counted <= frames


def test_a_misplaced_camera_shifts_its_image_by_that_much(note):
    (filming,) = (each for each in note.FILMINGS if each.misplaced)
    points = np.array([[0.5, -0.3, 0.2], [0.0, 1.0, -1.0]]) * mm
    for camera, moved in zip(filming.cameras, filming.misplaced_cameras, strict=True):
        away = np.linalg.norm(moved.project(points) - camera.project(points), axis=1)
        assert away == pytest.approx(filming.misplaced, abs=1e-9)


def test_a_wrong_start_is_as_wrong_as_said(note):
    (truth,) = note.stances_of(note.REFERENCE.flight()[100])
    steps = np.array([
        step_between(truth, note.disturbed(truth, np.random.default_rng(k))) for k in range(400)
    ])  # fmt: skip
    spread = np.std(steps[:, :12], axis=0)
    said = np.concatenate([np.full(3, 0.02 * mm), note.TURNS_OFF, np.full(6, 5 * deg)])
    np.testing.assert_allclose(spread / said, 1, atol=0.2)  # 4.5 standard errors of a deviation from 400


def test_errors_of_known_size_are_counted_as_such(note):
    error, spread = np.zeros((4, 18)), np.full((4, 18), deg)
    error[:, 5] = np.array([1, -1, 3, np.nan]) * deg
    error[:, :3] = np.array([2.0, 1.0, 2.0]) * um
    error[3] = np.nan
    found = note.Found(error=error, spread=spread, phase=np.zeros(4))
    centre, roll = note.QUANTITIES[0], note.QUANTITIES[3]
    assert note.rms(found, centre) == pytest.approx(3)
    assert note.rms(found, roll) == pytest.approx(np.sqrt(11 / 3))
    assert note.middle(found, roll) == pytest.approx(1)
    assert note.held_by_band(found, roll) == pytest.approx(2 / 3)
    assert note.stated(found, centre) == pytest.approx(np.sqrt(3) * deg / um)
    assert found.missed == 0.25


def test_a_doubted_wing_counts_as_not_told_and_a_believed_wrong_one_as_wrong(note):
    error = np.zeros((2, 18))
    error[0, 8], error[1, 10] = 44 * deg, -46 * deg
    found = note.Found(error=error, spread=error, phase=np.zeros(2))
    assert found.wings_wrong == 0.25
    nothing = (np.full((2, 3), np.nan),) * 2
    track = note.Track(
        pose=note.Pose(coordinates=error, stroke_plane_angle=0.0), uncertainty=error, status=("partial", "bridged"),
        reasons=("", ""), overlap=nothing[0], precision=nothing[1], doubts=(("", "", "hidden"), ("", "", "")),
    )  # fmt: skip
    told = note.believed(track)
    names = [name for name, known in zip(note.COORDINATES, told[0], strict=True) if not known]
    assert all(name.startswith("right") for name in names)
    assert len(names) == 6
    assert not told[1].any()


def test_angles_differ_the_short_way_round(note):
    X = np.zeros((1, 18))
    one, other = (note.Pose(coordinates=X + x * deg, stroke_plane_angle=0.0) for x in (179, -179))
    assert note.errors(one, other)[0, 3:12] == pytest.approx(np.full(9, -2 * deg))


def test_a_fit_tells_the_small_case_better_than_its_hull_and_a_wrong_body_costs(small):
    note, found, _ = small
    centre, yaw = note.QUANTITIES[0], note.ANGLES[0]
    for each in (found.reference, found.named("no legs")):
        assert note.rms(each.fit, centre) < note.rms(each.hull, centre)
        assert note.rms(each.fit, yaw) < 1
    assert note.rms(found.named("body 10 % smaller").fit, centre) > note.rms(found.reference.fit, centre)


def test_note_numbers_and_claims_say_the_same(small):
    note, found, folder = small
    files = sorted(path.name for path in folder.iterdir())
    assert files == sorted([f"{NAME}.md", f"{NAME}.json", *note._TITLES])
    numbers = json.loads((folder / f"{NAME}.json").read_text(encoding="utf-8"))
    text = (folder / f"{NAME}.md").read_text(encoding="utf-8")
    assert set(numbers["filmed"]) == {each.filming.name for each in found.tried}
    for each in found.tried:
        for way in ("fit", "hull"):
            told = numbers["filmed"][each.filming.name][way]["median"]["roll [deg]"]
            assert told == pytest.approx(note.middle(getattr(each, way), note.QUANTITIES[3]), rel=5e-3)
    (row,) = re.findall(r"^\| roll \[deg\] \| ([\d.e+]+) \|", text, re.MULTILINE)
    assert float(row) == pytest.approx(numbers["whole_flight"]["rms"]["roll [deg]"], rel=5e-3)
    claims = read_claims(folder / f"{NAME}.json")
    assert claims is not None
    assert [claim.verdict for claim in claims][-1] == "shown here"
    assert "NaN" not in (folder / f"{NAME}.json").read_text(encoding="utf-8")
