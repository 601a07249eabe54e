"""The visual hull of one frame on 192^3 voxels, three cameras, against the same carving in NumPy; whole frames."""

import base64
import time

import numpy as np
import pytest
from scoreboard import Row
from test_speed import US, run_peer

from flycontrol.model.camera_forms import orthogonal_cameras
from flycontrol.model.flapping_pose import flapping_pose
from flycontrol.model.planform import Planform
from flycontrol.model.stroke_kinematics import hover_stroke
from flycontrol.units import deg, mm
from flycontrol.vision.box import Box
from flycontrol.vision.fly_shape import fly_shape
from flycontrol.vision.hull import EXACT, carve, lattice_matrix, visual_hull
from flycontrol.vision.render import render_silhouettes
from flycontrol.vision.views import views_of

EDGE, SCALE = 192, 35 / mm
SIZE = 1 / SCALE
BOX = Box(low=(0, 0, 0), high=(EDGE, EDGE, EDGE))
MIDDLE = (EDGE / 2 * SIZE,) * 3
FLY = fly_shape(Planform(length=2.4 * mm, mean_chord=0.7 * mm, second_moment_radius=0.58), legs=True)


def packed(image):
    return base64.b64encode(np.packbits(image)).decode()


def scene(distance):
    """A fly in mid-stroke, 2.4 mm long, in the middle of the lattice; no voxel projects half-way between pixels."""
    target = np.array(MIDDLE) + np.array([0.13, 0.29, 0.41]) * SIZE
    cameras = orthogonal_cameras(scale=SCALE, shape=(EDGE, EDGE), target=target, distance=distance)
    pose = flapping_pose(
        hover_stroke(), [1 / 880], right_base_B=FLY.right_base_B, stroke_plane_angle=50 * deg,
        position_W=MIDDLE, attitude=np.array([20, 45, 10]) * deg,
    )  # fmt: skip
    return cameras, next(render_silhouettes(FLY, pose, cameras))


def reference(cameras, masks):
    """(192, 192, 192) by a test of every voxel on every view, plane by plane."""
    volume = np.ones((EDGE,) * 3, bool)
    y, z = (axis.ravel() for axis in np.indices((EDGE, EDGE)))
    for x in range(EDGE):
        points = (np.stack([np.full(EDGE**2, x), y, z], 1) + 0.5) * SIZE
        for camera, mask in zip(cameras, masks, strict=True):
            pixels = camera.project(points)
            seen = camera.sees(pixels)
            u, v = np.floor(np.where(seen[:, None], pixels, 0) + 0.5).astype(int).T
            volume[x] &= (seen & mask[v, u]).reshape(EDGE, EDGE)
    return volume


def planes(cameras, masks):
    """What each orthographic view says of the lattice's planes xy, xz, yz, for peers that cannot look it up."""
    along = (np.arange(EDGE) + 0.5) * SIZE
    found = []
    for a, b in ((0, 1), (0, 2), (1, 2)):
        points = np.zeros((EDGE, EDGE, 3))
        points[:, :, a], points[:, :, b] = along[:, None], along[None, :]
        k = 3 - a - b  # the camera that looks along the third axis
        u, v = np.floor(cameras[k].project(points.reshape(-1, 3)) + 0.5).astype(int).T
        inside = (u >= 0) & (v >= 0) & (u < EDGE) & (v < EDGE)
        found.append((inside & masks[k][np.clip(v, 0, EDGE - 1), np.clip(u, 0, EDGE - 1)]).reshape(EDGE, EDGE))
    return found


@pytest.mark.benchmark(disable_gc=True, warmup=True, timer=time.process_time)
@pytest.mark.parametrize("distance", [None, 120 * mm], ids=["orthographic", "projective"])
def test_the_hull_of_a_fly_is_that_of_every_voxel_looked_at(benchmark, rows, tmp_path, distance):
    cameras, masks = scene(distance)
    truth = reference(cameras, masks)
    found = benchmark(lambda: carve(views_of(masks, cameras), SIZE, EXACT, BOX))
    dense = np.zeros_like(truth)
    dense[tuple(found.T)] = True
    wrong = int(np.count_nonzero(dense != truth))
    ours = Row(
        job=f"hull on 192^3 voxels, {'orthographic' if distance is None else 'projective'} cameras", tool=US,
        setting="list of voxels", run_s=benchmark.stats.stats.median, best_s=benchmark.stats.stats.min,
        error=float(wrong), unit="wrong voxels",
    )  # fmt: skip
    rows.append(ours)
    problem = {"edge": EDGE, "reference": packed(truth)}
    if distance is None:
        problem["planes"] = [packed(plane) for plane in planes(cameras, masks)]
    else:
        problem["matrices"] = [lattice_matrix(camera, SIZE).tolist() for camera in cameras]
        problem["masks"], problem["shapes"] = [packed(mask) for mask in masks], [mask.shape for mask in masks]
    rows.extend(run_peer("numpy_hull", problem, ours, tmp_path))
    assert wrong == 0


@pytest.mark.benchmark(disable_gc=True, warmup=True, timer=time.process_time)
def test_a_frame_from_silhouettes_to_hull_with_its_consistency(benchmark, rows):
    cameras, masks = scene(120 * mm)
    hull = benchmark(visual_hull, masks, cameras, SIZE)
    rows.append(
        Row(
            job="hull of a frame, box found, consistency included", tool=US, setting=f"{len(hull)} voxels",
            run_s=benchmark.stats.stats.median, best_s=benchmark.stats.stats.min,
        )
    )  # fmt: skip
    assert all(view.coverage > 0.98 for view in hull.views)


@pytest.mark.benchmark(disable_gc=True, warmup=True, timer=time.process_time)
def test_a_frame_of_three_silhouettes_drawn(benchmark, rows):
    cameras, _ = scene(120 * mm)
    pose = flapping_pose(
        hover_stroke(), np.arange(64) / 8000, right_base_B=FLY.right_base_B, stroke_plane_angle=50 * deg,
        position_W=MIDDLE,
    )  # fmt: skip
    drawn = benchmark(lambda: list(render_silhouettes(FLY, pose, cameras)))
    rows.append(
        Row(
            job="three silhouettes of a fly drawn, 64 frames", tool=US, setting="with legs",
            run_s=benchmark.stats.stats.median, best_s=benchmark.stats.stats.min,
        )
    )  # fmt: skip
    assert len(drawn) == 64
