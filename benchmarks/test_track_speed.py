"""The whole tracker on a simulated flight, by the hull alone and with the parametric fly; its memory."""

import json
import subprocess
import sys
import time
from pathlib import Path

import filmed_fly
import numpy as np
import pytest
from scoreboard import Row
from test_speed import US

from flycontrol.units import deg
from flycontrol.vision.stance import pose_of
from flycontrol.vision.track import FIRST, tracked_frames

FRAMES = 110  #: three wingbeats
MB = 1e6


def followed(refine):
    """The frames, and the CPU time at which each was done."""
    frames, done = [], []
    began = time.process_time()
    images = list(filmed_fly.silhouettes(FRAMES))
    drawing = time.process_time() - began
    began += drawing
    for frame in tracked_frames(images, filmed_fly.CAMERAS, filmed_fly.FLY, refine=refine):
        frames.append(frame)
        done.append(time.process_time() - began)
    return frames, np.array(done)


def worst_turn(frames):
    """RMS over believed frames, the largest of yaw and pitch [rad]."""
    seen = np.array([frame.status == "tracked" for frame in frames])
    found = pose_of([frame.stance for frame, ok in zip(frames, seen, strict=True) if ok], 50 * deg).coordinates[:, 3:5]
    away = found - filmed_fly.pose(FRAMES).coordinates[seen, 3:5]
    return float(np.sqrt(np.mean(((away + np.pi) % (2 * np.pi) - np.pi) ** 2, axis=0)).max())


@pytest.mark.benchmark(disable_gc=True, timer=time.process_time)
@pytest.mark.parametrize("refine", [False, True], ids=["hull alone", "refined"])
def test_a_flight_is_tracked(benchmark, rows, refine):
    frames, done = benchmark.pedantic(followed, args=(refine,), rounds=1, warmup_rounds=0)
    each = np.diff(done[FIRST - 1 :])  # those before come together, once the first pose is found
    tracked = sum(frame.status == "tracked" for frame in frames)
    rows.append(
        Row(
            job="a frame tracked, three views", tool=US, use="refined" if refine else "hull alone",
            setting=f"{1 / np.mean(each):.3g} a second; {FRAMES / done[-1]:.3g} with the first pose looked for; "
                    f"{tracked} of {FRAMES} tracked",
            run_s=float(np.median(each)), best_s=float(each.min()),
            error=worst_turn(frames) / deg, unit="deg",
        )
    )  # fmt: skip
    assert len(frames) == FRAMES
    assert not refine or tracked == FRAMES


def peak_of(frames, refine):
    done = subprocess.run(
        [sys.executable, Path(__file__).with_name("track_memory.py")], check=True, capture_output=True, text=True,
        input=json.dumps({"frames": frames, "refine": refine}),
    )  # fmt: skip
    return json.loads(done.stdout)["peak_bytes"]


@pytest.mark.benchmark(disable_gc=True, timer=time.process_time)
def test_memory_does_not_grow_with_the_length_of_a_flight(benchmark, rows):
    """A frame of three boolean views is 0.2 MB: kept, 300 more of them would be 59 MB."""
    short = peak_of(100, refine=False)
    long = benchmark.pedantic(peak_of, args=(400, False), rounds=1, warmup_rounds=0)
    rows.append(
        Row(
            job="peak memory of a track, frames streamed", tool=US, use="hull alone",
            setting=f"{short / MB:.0f} MB for 100 frames, {long / MB:.0f} MB for 400",
        )
    )  # fmt: skip
    assert long - short < 10 * MB
