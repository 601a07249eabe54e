"""What recordings cannot say whatever is fitted to them: too short for a reflex, or moved by nobody knows what.

A reflex must act and its effect must be felt and answered again: three reaction delays after the onset. Yaw that only
unknown torques moved does not tell a loop from its disturbance: any gains explain it with a disturbance to suit them.
"""

from __future__ import annotations

from flycontrol.identify.gains.problem import FitProblem, TrialPart
from flycontrol.units import ms

_DELAYS = 3.0  #: that a recording must show after the onset
_PUBLISHED_DELAY = 3 / 220.0  #: three wingbeats at 220 Hz (review, section 6) [s]


def what_the_data_cannot_say(problem: FitProblem) -> str:
    """A sentence if no fit of the loop to these trials could mean anything; otherwise empty."""
    longest = max(_shown(part) for part in problem.parts)
    delay = _delay(problem)
    short = longest < _DELAYS * delay
    unmoved = all(part.trial.perturbation is None for part in problem.parts)
    reasons: list[str] = []
    if unmoved:
        reasons.append(
            "no perturbation is known, and yaw that unknown torques moved does not tell a loop from its disturbance"
        )
    if short:
        since = "" if unmoved else " after the onset"
        reasons.append(
            f"the longest recording shows {longest / ms:.3g} ms{since}, too short for a reflex to act and be answered "
            f"(three reaction delays of {delay / ms:.3g} ms)"
        )
    if not reasons:
        return ""
    return f"not identifiable: {'; and '.join(reasons)}; record perturbed flies for longer."


def _shown(part: TrialPart) -> float:
    """How long a trial lasts after its perturbation begins, or in all [s]."""
    begin = part.drive.majors[0] if len(part.drive.majors) else part.channels[0].times[0]
    return float(part.channels[0].times[-1] - max(begin, part.channels[0].times[0]))


def _delay(problem: FitProblem) -> float:
    """The reaction delay if it is known, otherwise the published one unless the bounds allow no more [s].

    Not the estimate: where recordings are too short it is whatever the noise makes of it.
    """
    if "delay" in problem.model.known:
        return problem.model.known["delay"]
    return min(_PUBLISHED_DELAY, problem.model.unknown["delay"].high)
