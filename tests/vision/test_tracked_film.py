from dataclasses import replace

import numpy as np
import pytest
from filmed_flights import BARE, CAMERAS, RATE, SCALE, STROKE_PLANE, apart, turning_flight

from flycontrol.errors import InvalidInputError, OutputError
from flycontrol.jobs.checkpoint import Checkpoint
from flycontrol.jobs.packed import Packing, unpacked
from flycontrol.model.camera_forms import orthogonal_cameras
from flycontrol.model.film_part import FilmPart
from flycontrol.units import deg, mm
from flycontrol.vision import tracked_film as module
from flycontrol.vision.checks.footage_check import checked_footage
from flycontrol.vision.drawn_film import DrawnFilm
from flycontrol.vision.fit_shape import fit_shape
from flycontrol.vision.follower import Fly, Follower
from flycontrol.vision.footage import Footage
from flycontrol.vision.kept_state import kept, memory_of, remind, restored
from flycontrol.vision.sighting import of_the_expected, sighting_of
from flycontrol.vision.stance import stances_of
from flycontrol.vision.track import Pursuit, track
from flycontrol.vision.tracked_film import Asked, tracked_film

FLY = Fly(shape=BARE, stroke_plane_angle=STROKE_PLANE)
POSE = turning_flight(1)[:14]
WIDE = orthogonal_cameras(scale=SCALE, shape=(512, 512), distance=120 * mm)
AS_GIVEN = Asked(fly=FLY, fit_sizes=False)


class Edited:
    """A film some of whose frames are other than they were."""

    def __init__(self, film, edit):
        self._film, self._edit = film, edit
        self.name, self.shape, self.binary = film.name, film.shape, True

    def __len__(self):
        return len(self._film)

    def image(self, k):
        return self._edit(k, self._film.image(k) < 120)


def filmed(edit=lambda k, mask: mask, pose=POSE, cameras=CAMERAS):
    drawn = [DrawnFilm(shape_of_fly=BARE, pose=pose, camera=camera) for camera in cameras]
    films = tuple(Edited(film, edit) for film in drawn)
    return Footage(films=films, frame_rate=RATE, backgrounds=(None,) * len(films))


def test_a_run_that_was_interrupted_goes_on_to_the_same_bits(tmp_path, monkeypatch):
    monkeypatch.setattr(module, "_PIECE", 6)
    checkpoint, frames_again = Checkpoint(tmp_path / "unfinished", "this job"), []

    def interrupted(done, total, what):
        if done == 9:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        tracked_film(filmed(), CAMERAS, AS_GIVEN, checkpoint, interrupted)
    found = tracked_film(filmed(), CAMERAS, AS_GIVEN, checkpoint, lambda done, *_: frames_again.append(done)).track
    whole = tracked_film(filmed(), CAMERAS, AS_GIVEN).track
    assert min(frames_again) == 6
    assert found.pose.coordinates.tobytes() == whole.pose.coordinates.tobytes()
    assert found.uncertainty.tobytes() == whole.uncertainty.tobytes()
    assert found.status == whole.status
    with pytest.raises(OutputError, match="another job"):
        tracked_film(filmed(), CAMERAS, AS_GIVEN, Checkpoint(tmp_path / "unfinished", "other options"))


def test_a_follower_remembers_everything_through_a_file():
    pursuit = Pursuit(cameras=CAMERAS, fly=FLY, refine=True)
    sightings = [sighting_of(frame, CAMERAS) for frame in filmed()]
    pursuit.begun(sightings[:5])
    packing = Packing()
    packing.add(memory_of(pursuit.follower), "memory")
    other = Follower(cameras=CAMERAS, fly=FLY, refine=True, start=None)
    remind(other, unpacked(packing.to_bytes())[0])
    one, two = pursuit.followed(sightings[5]), other.follow(sightings[5].masks)
    assert one.covariance.tobytes() == two.covariance.tobytes()
    assert one.stance.position_W.tobytes() == two.stance.position_W.tobytes()
    again = restored(kept(one))
    assert again.agreement.cost == one.agreement.cost


def test_a_frame_that_cannot_be_read_is_bridged_with_its_reason():
    def edit(k, mask):
        if k == 7:
            raise InvalidInputError("film.tif, frame 7: damaged")
        return mask

    found = tracked_film(filmed(edit), CAMERAS, AS_GIVEN).track
    assert found.status == tuple("bridged" if k == 7 else "tracked" for k in range(len(POSE)))
    assert found.reasons[7] == "film.tif, frame 7: damaged"
    assert np.max(np.abs(apart(found.pose, POSE)[7, 3:6])) < 3 * deg


def test_a_full_silhouette_is_bridged_and_says_so():
    found = tracked_film(filmed(lambda k, mask: mask | (k == 8)), CAMERAS, AS_GIVEN).track
    assert found.status[8] == "bridged"
    assert "fills 100 % of the image" in found.reasons[8]
    assert found.status[9] == "tracked"


def test_a_second_fly_in_view_is_left_out_and_the_frame_marked():
    def crowded(k, mask):
        return mask | np.roll(mask, (170, 170), (0, 1)) if k in (3, 4) else mask

    alone, found = (
        tracked_film(filmed(edit, POSE[:6], WIDE), WIDE, AS_GIVEN).track for edit in (lambda k, mask: mask, crowded)
    )
    assert found.status == ("tracked", "tracked", "tracked", "partial", "partial", "tracked")
    assert "more than one animal before" in found.reasons[3]
    assert np.array_equal(found.pose.coordinates, alone.pose.coordinates)


def test_of_two_flies_from_the_first_frame_on_one_is_followed_and_no_mixture_of_both():
    def crowded(k, mask):
        return mask | np.roll(mask, (170, 170), (0, 1))

    found = tracked_film(filmed(crowded, POSE[:4], WIDE), WIDE, AS_GIVEN).track
    assert found.status == ("partial",) * 4
    assert np.max(np.abs(apart(found.pose, POSE[:4])[:, 3:6])) < 3 * deg


def test_what_lies_off_the_expected_fly_is_no_part_of_it():
    stance = stances_of(POSE[2])[0]
    masks = [silhouette.mask for silhouette in filmed(cameras=WIDE).frame(3).silhouettes]
    crowd = [mask | np.roll(mask, (170, 170), (0, 1)) for mask in masks]
    for mask, left in zip(masks, of_the_expected(crowd, WIDE, fit_shape(BARE), stance), strict=True):
        assert np.array_equal(mask, left)


def test_a_film_that_begins_without_a_fly_is_lost_until_it_comes(monkeypatch):
    late = [tuple(np.zeros(camera.shape, dtype=bool) for camera in CAMERAS)] * 48
    frames = [tuple(s.mask for s in frame.silhouettes) for frame in filmed(pose=POSE[:5])]
    found = track([*late, *frames], CAMERAS, FLY)
    assert found.status == ("lost",) * 48 + ("tracked",) * 5


def test_films_of_another_scale_other_cameras_or_without_a_fly_are_refused():
    wing = 2.4 * mm
    checked = checked_footage(filmed(), CAMERAS, wing)
    assert checked.calibration.residual < 0.5
    assert not checked.doubt
    slow = checked_footage(replace(filmed(), frame_rate=2000.0), CAMERAS, wing)
    assert slow.doubt.startswith("2000 frames a second show too little of a wingbeat")
    far = tuple(replace(camera, matrix=camera.matrix * [1e-3, 1e-3, 1e-3, 1]) for camera in CAMERAS)
    with pytest.raises(InvalidInputError, match=r"would be 5\.\d+ m across"):
        checked_footage(filmed(), far, wing)
    with pytest.raises(InvalidInputError, match="do not fit the images"):
        checked_footage(filmed(lambda k, mask: np.roll(mask, 40, axis=1)), CAMERAS, wing)
    with pytest.raises(InvalidInputError, match="shows none in any of them"):
        checked_footage(filmed(lambda k, mask: mask & False), CAMERAS, wing)
    with pytest.raises(InvalidInputError, match="fills 100 % of the image"):
        checked_footage(filmed(lambda k, mask: mask | True), CAMERAS, wing)


def test_a_part_of_a_film_holds_the_frames_that_were_asked_for():
    film = filmed().films[0]
    part = FilmPart(film, range(2, 12, 3))
    assert (len(part), part.shape, part.binary, part.name) == (4, film.shape, True, film.name)
    assert np.array_equal(part.image(2), film.image(8))


@pytest.mark.slow
def test_a_fly_that_leaves_the_view_is_lost_and_found_again_and_never_told_wrong():
    made, k = turning_flight(4)[:130], np.arange(130)
    X = made.coordinates.copy()
    X[:, 0] += -1 * mm + 8 * mm * np.exp(-(((k - 55) / 30) ** 2))  # out of two views and back
    pose = replace(made, coordinates=X)
    found = tracked_film(filmed(pose=pose), CAMERAS, AS_GIVEN).track
    away = np.abs(apart(found.pose, pose))[:, 3:12]
    assert {"partial", "bridged", "lost"} <= set(found.status)
    back = np.flatnonzero((X[:, 0] < 1 * mm) & (k > 55))[0]  # well inside
    assert found.status[back + 10 :] == ("tracked",) * (130 - back - 10)
    assert np.max(away[found.believed]) < 10 * deg  # a wing beats by up to 15 deg a frame
    bridged = np.array(found.status) == "bridged"
    assert np.mean(away[bridged] < 2 * found.uncertainty[bridged, 3:12]) > 0.9
