"""Peak memory of following a drawn fly, frames drawn one by one: number of frames and whether to refine from stdin."""

import json
import resource
import sys

import filmed_fly

from flycontrol.vision.track import tracked_frames

wanted = json.load(sys.stdin)
found = 0
for frame in tracked_frames(
    filmed_fly.silhouettes(wanted["frames"]), filmed_fly.CAMERAS, filmed_fly.FLY, refine=wanted["refine"]
):
    found += frame.status == "tracked"
peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * (1 if sys.platform == "darwin" else 1024)
json.dump({"tracked": found, "peak_bytes": peak}, sys.stdout)
