import io
import re
import tomllib
from dataclasses import replace

import numpy as np
import pytest
from outline import Outline
from PIL import Image
from scipy.ndimage import binary_dilation, binary_erosion
from texts import overlapping_texts, texts_outside, unlabelled
from tracked_flights import FREQUENCY, RATE, cameras_around, motion, tracked_flight

from flycontrol.errors import InvalidInputError
from flycontrol.io.mapping import read_mapping
from flycontrol.io.tracked_mapping import tracked_mapping
from flycontrol.model.distortion import Distortion
from flycontrol.model.pose import Pose
from flycontrol.report.figures.track_coordinates import (
    BASES,
    BODY,
    WINGS,
    bands_are_cut,
    coordinates_over_time,
    shown_limits,
)  # fmt: skip
from flycontrol.report.figures.track_hull import hull_from_two_sides
from flycontrol.report.figures.track_overlay import frame_overlay
from flycontrol.report.figures.track_quality import agreement_over_time, uncertainty_over_time
from flycontrol.report.figures.track_rates import body_rates
from flycontrol.report.track.animation import HEAVIEST, gif
from flycontrol.report.track.beats import piece_shown_closely, stroke_reversals
from flycontrol.report.track.chosen import best_frame, chosen_frames, worst_frame
from flycontrol.report.track.curves import curves, true_rates
from flycontrol.report.track.figures import fastest_within, track_figures
from flycontrol.report.track.page import write_track_report
from flycontrol.report.track.result import TrackOrigin, nothing_tracked, tracked_result
from flycontrol.report.track.second_look import second_look
from flycontrol.report.track.spans import spans, tally
from flycontrol.report.track.truth import coordinate_errors
from flycontrol.report.track.views import Window, part_masks, seen_in
from flycontrol.report.track.words import median_overlap, status_rows
from flycontrol.units import deg, ms
from flycontrol.vision.render import render_silhouettes
from flycontrol.vision.smoothing import smoothed

ORIGIN = TrackOrigin(
    command="flycontrol track", films=("view.npz",), images_sha256="a1" * 32, cameras=None, cameras_sha256=None,
    fly="some_fly.toml", fly_sha256="f1" * 32,
)  # fmt: skip
MIXED = ("tracked", "tracked", "bridged", "bridged", "tracked", "partial", "lost", "lost")


@pytest.fixture(scope="module")
def mixed():
    return tracked_flight(8, status=MIXED)


@pytest.fixture(scope="module")
def looked(mixed):
    flight, footage = mixed
    return second_look(flight, footage, stroke_reversals(flight))


@pytest.fixture(scope="module")
def written(tmp_path_factory, mixed):
    """Folder of a report on frames of every status."""
    folder = tmp_path_factory.mktemp("track") / "report"
    page_of(folder, *mixed, **{"result.json": "{}"})
    return folder


def page_of(folder, flight, footage, **beside):
    write_track_report(flight, footage, folder, beside, origin=ORIGIN)
    return (folder / "index.html").read_text()


def well_formed(text):
    outline = Outline(text)
    assert not outline.errors
    assert not outline.open
    assert len(outline.ids) == len(set(outline.ids))
    assert not re.search(r"\b(nan|inf|None)\b", outline.text)
    return outline


def test_every_frame_is_counted_in_some_status(mixed):
    flight, _ = mixed
    assert sum(tally(flight.track).values()) == len(flight.track)
    assert sum(len(span) for span in spans(flight.track)) == len(flight.track)
    *each, total = [int(row.values[0]) for row in status_rows(flight)]
    assert sum(each) == total == len(flight.track)


def test_the_page_tells_the_flights_numbers(written, mixed):
    flight, _ = mixed
    outline = well_formed((written / "index.html").read_text())
    assert "3 of 8 frames are tracked" in outline.text
    assert "1 partial, 2 bridged and 2 lost" in outline.text
    assert f"{100 * median_overlap(flight):.1f}" in outline.text
    assert f"{flight.check.residual:.2f}" in outline.text
    for camera in flight.cameras:
        assert camera.name in outline.text
    for error in coordinate_errors(flight, flight.truth):
        assert error.name in outline.text
    assert "2–3" in outline.text
    assert "the silhouette is empty" in outline.text
    assert "result.json" in outline.text
    assert all(word in outline.text for word in (ORIGIN.command, ORIGIN.images_sha256, ORIGIN.fly_sha256))


def test_every_figure_is_numbered_in_the_order_of_the_page_and_is_read_aloud(written):
    text = (written / "index.html").read_text()
    numbers = [int(number) for number in re.findall(r"<b>Figure (\d+)\.", text)]
    assert numbers == list(range(1, len(numbers) + 1))
    tables = [int(number) for number in re.findall(r"Table (\d+)\.", text)]
    assert tables == list(range(1, len(tables) + 1))
    drawings = re.findall(r"<svg [^>]*>", text)
    assert len(drawings) == len(numbers)
    assert all('role="img"' in drawing and re.search(r'aria-label="[^"]+"', drawing) for drawing in drawings)
    assert all(re.search(r'alt="[^"]+"', image) for image in re.findall(r"<img [^>]*>", text))


def test_the_page_loads_nothing_from_elsewhere(written):
    text = (written / "index.html").read_text()
    assert not re.search(r"https?://|<script|<link", text)
    assert set(re.findall(r'src="([^"]+)"', text)) == {"overlay.gif"}


def test_the_same_flight_gives_the_same_bytes(tmp_path, written, mixed):
    page_of(tmp_path, *mixed, **{"result.json": "{}"})
    for file in ("index.html", "overlay.gif"):
        assert (tmp_path / file).read_bytes() == (written / file).read_bytes()


@pytest.mark.parametrize(
    ("frames", "options"),
    [
        (1, {}),
        (1, {"status": ("bridged",)}),
        (3, {"status": ("lost",) * 3}),
        (3, {"status": ("lost",) * 3, "truth": False, "grey": True}),
        (4, {"truth": False, "cameras": 2}),
        (4, {"cameras": 5, "grey": True}),
        (6, {"damaged": (0, 2, 5), "status": ("tracked", "tracked", "bridged", "tracked", "tracked", "lost")}),
    ],
)
def test_any_flight_gives_a_page(tmp_path, frames, options):
    flight, footage = tracked_flight(frames, **options)
    outline = well_formed(page_of(tmp_path, flight, footage))
    tracked = options.get("status", ("tracked",) * frames).count("tracked")
    assert f"{tracked} of {frames} frame" in outline.text
    assert ("Against the truth" in outline.text) == (tracked > 0 and options.get("truth", True))
    assert (tmp_path / "overlay.gif").exists() == (frames > 1)


def test_a_film_too_short_to_be_smoothed_says_so_and_shows_what_was_read_alone(tmp_path):
    flight, footage = tracked_flight(6, truth=False)
    flight = replace(flight, smoothed=smoothed(flight.track, flight.frame_rate))
    outline = well_formed(page_of(tmp_path, flight, footage))
    assert "at least 8 frames in which the fly is seen are needed, and there are 6." in outline.text
    assert "Rates of the body" not in outline.text
    assert outline.text.count("As read frame by frame alone") == 3
    assert "smoothed</text>" not in (tmp_path / "index.html").read_text()


def test_the_mapping_of_a_film_too_short_refuses_with_its_reason(tmp_path):
    text = tracked_mapping(
        "netcdf", name="a", stroke_plane_angle=1.0, frequency=None, whole=False, empty="There were 6 frames."
    )
    (tmp_path / "mapping.toml").write_text(text)
    with pytest.raises(InvalidInputError, match=r"holds no motion\. There were 6 frames\."):
        read_mapping(tmp_path / "mapping.toml")


def test_figures_have_units_and_no_text_overlaps(mixed, looked):
    flight, _ = mixed
    found, drawn = spans(flight.track), curves(flight)
    figures = [
        *(coordinates_over_time(drawn, panels, ("one", "other"), found) for panels in (BODY, WINGS, BASES)),
        body_rates(flight, found),
        agreement_over_time(flight, looked.survey, found),
        uncertainty_over_time(flight, found),
        *(hull_from_two_sides(hull) for hull in looked.hulls),
    ]
    assert len(looked.hulls) == 2
    for figure in figures:
        assert not unlabelled(figure)
        assert not texts_outside(figure)
        assert not overlapping_texts(figure)
    for _, overlay in looked.overlays:
        assert not texts_outside(frame_overlay(overlay))


def test_a_long_flight_is_looked_through_in_part_and_drawn_whole():
    flight, footage = tracked_flight(150)
    looked = second_look(flight, footage, stroke_reversals(flight))
    assert len(looked.survey.frames) == len(looked.pictures) == 120
    assert (looked.survey.frames[0], looked.survey.frames[-1]) == (0, 149)
    strip, overlap, _, covered = agreement_over_time(flight, looked.survey, spans(flight.track)).axes
    assert strip.get_xlim()[1] > flight.time[-1] / ms
    assert [len(line.get_xdata()) for line in overlap.lines] == [150] * 3
    assert [len(line.get_xdata()) for line in covered.lines] == [120] * 3


def test_frames_looked_at_are_those_of_their_rules(mixed):
    flight, _ = mixed
    chosen = {rule: each.frame for each in chosen_frames(flight, stroke_reversals(flight)) for rule in each.rules}
    overlap = np.where(flight.track.believed, flight.track.overlap.mean(axis=1), np.nan)
    assert best_frame(flight) == np.nanargmax(overlap)
    assert worst_frame(flight) == np.nanargmin(overlap)
    assert chosen["the first in which the fly was seen"] == 0
    assert chosen["the middle of the longest bridge"] in (2, 3)
    assert chosen["the middle of the longest loss"] in (6, 7)
    assert chosen["the first that is partial"] == 5


def test_a_heading_goes_on_through_half_a_turn():
    flight, _ = tracked_flight(60)
    drawn = curves(flight)
    wrapped = (flight.track.pose.yaw + np.pi) % (2 * np.pi) - np.pi
    assert np.ptp(wrapped) > np.pi
    for curve in (drawn.smooth, drawn.raw, drawn.truth):
        assert np.max(np.abs(np.diff(curve[:, 3]))) < 1.0
    assert drawn.smooth[:, 3] - drawn.truth[:, 3] == pytest.approx(np.full(60, 0.1), abs=1e-9)


def test_that_no_frame_was_tracked_is_said_with_the_reason_that_most_frames_have():
    def said_of(*status):
        return nothing_tracked(tracked_flight(4, status=status)[0].track)

    words = "No frame was tracked; most often, in 3 of 4: view 0: the silhouette is empty."
    assert said_of("partial", "bridged", "bridged", "lost") == words
    assert said_of(*["partial"] * 4) == said_of("tracked", *["lost"] * 3) == ""


def test_the_frame_of_which_the_hull_covers_least_is_named_and_among_those_looked_at():
    flight, footage = tracked_flight(8)
    frames = list(footage.films[0].frames)
    frames[4] = frames[4] & (np.arange(160) < 80)  # half of the fly is missing
    film = replace(footage.films[0], frames=tuple(frames))
    looked = second_look(flight, replace(footage, films=(film, *footage.films[1:])), stroke_reversals(flight))
    row, view = looked.survey.least_covered
    assert (row, view) in ((4, 1), (4, 2))
    assert looked.survey.uncovered[row, view] == np.nanmax(looked.survey.uncovered) > 100
    chosen = {each.frame: each.rules for each, _ in looked.overlays}
    assert "the most pixels of a silhouette that the hull leaves uncovered" in chosen[4]
    figures = track_figures(flight, stroke_reversals(flight), looked.survey, looked.overlays, looked.hulls)
    assert f"% of the silhouette “view {view}”, in frame 4 at 1.00" in figures["agreement"].caption


def test_a_band_that_is_wide_in_two_frames_is_cut_and_hides_no_curve():
    flight, _ = tracked_flight(200)
    drawn, whole = curves(flight), slice(None)
    before = shown_limits(drawn, 10, whole)
    half = drawn.half_band.copy()
    half[[50, 120], 10] = 1e3
    spiked = replace(drawn, half_band=half)
    assert shown_limits(spiked, 10, whole) == pytest.approx(before, abs=0.5)
    assert bands_are_cut(spiked, WINGS, whole)
    low, high = shown_limits(spiked, 10, whole)
    for curve in (drawn.raw, drawn.smooth, drawn.truth):
        assert low < np.nanmin(curve[:, 10]) <= np.nanmax(curve[:, 10]) < high


def test_errors_against_the_truth_are_those_that_were_made(mixed):
    flight, _ = mixed
    for error in coordinate_errors(flight, flight.truth):
        assert error.raw == pytest.approx(0.1 if error.unit == "deg" else 0.0, abs=1e-12)
        assert error.in_band == 1.0  # 0.1 deg within 1.96 times a quarter


def test_the_numbers_beside_the_page_are_those_of_the_page(mixed):
    """A wing that is not believed counts in neither, where its coordinates are off by 40 deg."""
    flight, _ = mixed
    doubts = tuple(("", "", "it is hidden" if k == 1 else "") for k in range(len(flight.track)))
    off = flight.track.pose.coordinates.copy()
    off[1, 9:12] += 40 * deg
    astray = replace(flight, track=replace(
        flight.track, doubts=doubts, pose=Pose(coordinates=off, stroke_plane_angle=flight.track.pose.stroke_plane_angle)
    ))  # fmt: skip
    beside = tracked_result(astray, ORIGIN, {})["error"]
    on_page = coordinate_errors(astray, astray.truth)
    for kind in ("raw", "smoothed"):
        told = [getattr(each, kind) * (1.0 if each.unit == "deg" else 1000.0) for each in on_page]
        assert list(beside[kind].values()) == pytest.approx(told, abs=1e-9)
        assert max(told) == pytest.approx(0.1, abs=1e-9)


def test_a_wing_that_is_not_believed_is_not_drawn_as_seen(mixed):
    flight, _ = mixed
    nobody, doubted = ("", "", ""), ("", "the left wing is hidden", "")
    doubts = tuple(doubted if status == "partial" else nobody for status in flight.track.status)
    raw = curves(replace(flight, track=replace(flight.track, doubts=doubts))).raw
    assert np.flatnonzero(np.isnan(raw[MIXED.index("partial")])).tolist() == [6, 7, 8, 12, 13, 14]


def test_true_rates_are_those_of_a_steady_turn():
    time = np.arange(9) / RATE
    X = np.zeros((9, 18))
    X[:, 0], X[:, 3] = 0.2 * time, 30.0 * time
    velocity, turning = true_rates(Pose(coordinates=X, stroke_plane_angle=0.0), time)
    assert velocity == pytest.approx(np.tile([0.2, 0, 0], (9, 1)), abs=1e-12)
    assert turning[1:-1] == pytest.approx(np.tile([0, 0, 30.0], (7, 1)), abs=1e-9)


def test_the_fastest_turn_is_not_told_at_the_end_of_a_spline():
    rate = np.concatenate([np.full(5, np.nan), [90, 40, 3, 2], np.linspace(1, -9, 20), [5, 5, -80], np.full(4, np.nan)])
    assert rate[fastest_within(rate)] == -9  # 27 frames are known, of which 3 are left out at either end
    assert fastest_within(rate[:10]) is None
    assert fastest_within(np.full(40, np.nan)) is None


def test_the_page_and_the_mapping_bear_the_films_name_as_it_is(written, mixed):
    flight, _ = mixed
    assert f"<h1>{flight.name}</h1>" in (written / "index.html").read_text()
    for name in ("exp095_first47", 'a "quoted" \\ name', "m" * 300):
        text = tracked_mapping("csv", name=name, stroke_plane_angle=1.0, frequency=200.0, whole=True)
        assert tomllib.loads(text)["name"] == name[:100]


def test_the_wingbeat_frequency_is_told_where_a_wingbeat_was_seen():
    flight, _ = tracked_flight(60)  # three wingbeats
    assert stroke_reversals(flight).frequency == pytest.approx(FREQUENCY, rel=0.01)
    short, _ = tracked_flight(12)
    assert stroke_reversals(short).frequency is None


def test_the_piece_shown_closely_is_where_the_heading_changes_most():
    time, pose = motion(400)
    X = pose.coordinates.copy()
    X[:, 3] = 60 * deg / (1 + np.exp(-(time - time[300]) / 2e-3))
    flight, _ = tracked_flight(4)
    smoothed = replace(flight.smoothed, pose=Pose(coordinates=X, stroke_plane_angle=pose.stroke_plane_angle))
    flight = replace(flight, time=time, smoothed=smoothed)
    first, last = piece_shown_closely(flight, stroke_reversals(flight))
    assert last - first == pytest.approx(4 * RATE / FREQUENCY, abs=2)
    assert (first + last) / 2 == pytest.approx(300, abs=2)


def test_a_fly_that_is_thought_to_be_beside_or_behind_a_camera_gives_windows_of_the_films_size():
    flight, footage = tracked_flight(2)
    X = flight.track.pose.coordinates.copy()
    X[0, 0], X[1, 0] = 0.118, 0.3  # a camera is at x = 0.12 m
    away = replace(flight.track, pose=Pose(coordinates=X, stroke_plane_angle=flight.track.pose.stroke_plane_angle))
    flight = replace(flight, track=away)
    looked = second_look(flight, footage, stroke_reversals(flight))
    assert all(view.window.width <= 2 * 160 for _, overlay in looked.overlays for view in overlay.views)


def test_the_drawn_fly_is_the_silhouette_pixel_by_pixel():
    flight, _ = tracked_flight(1)
    camera = flight.cameras[0]
    (whole,) = next(iter(render_silhouettes(flight.fly.shape, flight.truth, [camera])))
    window = Window(20, 30, 100, 90)
    masks = part_masks(flight.fly.shape, flight.truth, camera, window, 1.0)
    assert np.array_equal(np.any(list(masks.values()), axis=0), whole[30:120, 20:120])


def test_what_is_drawn_goes_through_the_lens_as_the_image_does():
    camera = cameras_around(1)[0]
    lens = Distortion(centre=(20.0, 20.0), focal=(100.0, 100.0), radial=(0.1, 0.0, 0.0))
    bent = replace(camera, distortion=lens)
    flight, _ = tracked_flight(1)
    window = Window(0, 0, 160, 160)
    through = np.any(list(part_masks(flight.fly.shape, flight.truth, bent, window, 1.0).values()), axis=0)
    (image,) = next(iter(render_silhouettes(flight.fly.shape, flight.truth, [bent])))
    plain = seen_in(
        camera, window, 1.0, lambda at: next(iter(render_silhouettes(flight.fly.shape, flight.truth, [at])))[0]
    )
    assert np.count_nonzero(plain ^ image) > 100
    assert not np.any(
        through & ~binary_dilation(image, np.ones((3, 3)))
    )  # both take pixels' centres: borders differ by one at most
    assert not np.any(binary_erosion(image, np.ones((3, 3))) & ~through)


def test_an_animation_stays_light_whatever_was_filmed(mixed):
    rng = np.random.default_rng(1)
    noise = [Image.fromarray(rng.integers(0, 255, (330, 864), dtype=np.uint8)) for _ in range(12)]
    made = gif(noise)
    assert len(made) <= HEAVIEST
    assert 1 < Image.open(io.BytesIO(made)).n_frames < 12
