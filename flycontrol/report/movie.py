"""The animation as MP4, where ffmpeg is found; the package brings none along."""

from __future__ import annotations

import shutil
import subprocess
import tempfile
from pathlib import Path

from flycontrol.errors import OutputError
from flycontrol.flight.flight_record import FlightRecord
from flycontrol.report.animation import FRAME_TIME, frames


def ffmpeg() -> str | None:
    """Path of the ffmpeg that the shell would find, if any."""
    return shutil.which("ffmpeg")


def mp4(record: FlightRecord, program: str) -> bytes:
    """The frames of the animation as MP4.

    Raises
    ------
    OutputError
        ffmpeg could not make it: its last words.
    """
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "flight.mp4"
        pictures = list(frames(record))
        width, height = pictures[0].size
        command = [
            program, "-v", "error", "-f", "rawvideo", "-pix_fmt", "rgb24", "-s", f"{width}x{height}",
            "-r", f"{1 / FRAME_TIME:.6g}", "-i", "-", "-pix_fmt", "yuv420p", "-fflags", "+bitexact",
            "-flags:v", "+bitexact", str(path),
        ]  # fmt: skip
        raw = b"".join(picture.tobytes() for picture in pictures)
        done = subprocess.run(command, input=raw, capture_output=True, check=False)
        if done.returncode or not path.exists():
            words = done.stderr.decode("utf-8", "replace").strip().splitlines() or ["it said nothing"]
            raise OutputError(f"ffmpeg could not make flight.mp4: {words[-1]}; leave --mp4 out, the GIF needs none.")
        return path.read_bytes()
