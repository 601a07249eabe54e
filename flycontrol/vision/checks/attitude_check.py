"""Whether a fly that was followed flies as flies do: the right way up."""

from __future__ import annotations

import numpy as np

from flycontrol.vision.tracked_frame import Track

_MANY = 0.5  #: of the frames; a fly may turn over for some wingbeats, not for most of a film (C)


def upside_down(track: Track) -> str:
    """Say that the fly is seen on its back in most frames, as one is whose film has another up than was said.

    Parameters
    ----------
    track : N frames, world z up

    Returns
    -------
    a sentence without its full stop, or empty
    """
    seen = track.believed
    if not np.any(seen):
        return ""
    over = track.pose.body_axes_W[seen][:, 2, 2] > 0.0  # the body's z points to its belly
    if np.mean(over) <= _MANY:
        return ""
    return (
        f"the fly is seen on its back in {int(np.sum(over))} of {len(over)} frames, which flies are not: with another "
        "direction of the calibration as up (--up, for example --up=-z) it may be found the right way up, with other "
        "sizes and wings"
    )
