"""Frames of a track in a row that share a status and the reason for it."""

from __future__ import annotations

from dataclasses import dataclass

from flycontrol.vision.tracked_frame import STATUSES, Status, Track


@dataclass(frozen=True, slots=True, kw_only=True)
class Span:
    """Frames `first` to `last`, counted from 0, both included."""

    status: Status
    reason: str
    first: int
    last: int

    @property
    def middle(self) -> int:
        """The frame in the middle."""
        return (self.first + self.last) // 2

    def __len__(self) -> int:
        return self.last - self.first + 1


def spans(track: Track) -> list[Span]:
    """All frames, neighbours of one status and reason together."""
    found: list[Span] = []
    for k, (status, reason) in enumerate(zip(track.status, track.reasons, strict=True)):
        if found and (found[-1].status, found[-1].reason) == (status, reason):
            found[-1] = Span(status=status, reason=reason, first=found[-1].first, last=k)
        else:
            found.append(Span(status=status, reason=reason, first=k, last=k))
    return found


def unseen(track: Track) -> list[Span]:
    """Spans without coordinates that were seen, whatever the reasons: bridged ones and lost ones."""
    found: list[Span] = []
    for span in spans(track):
        if span.status not in ("bridged", "lost"):
            continue
        goes_on = found and found[-1].status == span.status and found[-1].last + 1 == span.first
        first = found.pop().first if goes_on else span.first
        found.append(Span(status=span.status, reason=span.reason, first=first, last=span.last))
    return found


def tally(track: Track) -> dict[Status, int]:
    """Number of frames by status; together they are all frames."""
    return {status: track.status.count(status) for status in STATUSES}
