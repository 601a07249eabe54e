"""Gain, phase, delay and modulus margins of a loop with delay, each crossover bracketed and solved for."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flycontrol.delay.asymptote import Asymptote
from flycontrol.delay.count import count_right_of
from flycontrol.delay.crossovers import gain_crossovers, nearest_to_minus_one, phase_crossovers
from flycontrol.delay.frequency import require_siso
from flycontrol.delay.frequency_domain import FrequencyDomain, frequency_domain
from flycontrol.delay.interconnect import feedback
from flycontrol.delay.nyquist import nyquist_response
from flycontrol.delay.real import real_number
from flycontrol.delay.system import FloatArray, is_retarded
from flycontrol.errors import AlgebraicLoopError, InvalidParameterError, NeutralSystemError

if TYPE_CHECKING:
    from flycontrol.delay.convert import Operand

_LEAST = 1e-9  # size of L down to which a margin is looked for that does not show above the floor


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Margins:
    """Margins of a negative unit feedback around L. They mean robustness only if that loop is `stable`.

    A margin that does not exist is infinite (nothing of that kind brings the loop to the boundary). Angles are in
    radians; python-control has degrees.
    """

    gain_margin: float  #: smallest factor > 1 on the gain that reaches the boundary
    gain_reduction_margin: float  #: largest factor < 1 that does; 0 when none
    phase_margin: float  #: smallest phase lag at a gain crossover that reaches the boundary [rad]
    delay_margin: float  #: smallest further delay that reaches the boundary [s]
    modulus_margin: float  #: distance of L(jw) from -1, min |1 + L| = 1 / Ms
    gain_crossovers: FloatArray  #: every frequency with |L| = 1 [rad/s]
    phase_crossovers: FloatArray  #: every frequency with L real and negative and |L| above the floor [rad/s]
    modulus_frequency: float  #: where |1 + L| is smallest [rad/s]; inf when only approached
    floor: float  #: |L| under which phase crossovers are left out
    unstable: (
        int | None
    )  #: closed-loop poles with Re s > 0; None if a pole is too near the axis or nothing was certified
    #: up to where phase crossovers are complete [rad/s]: inf, unless a delayed direct path makes them go on for ever
    complete_to: float

    @property
    def stable(self) -> bool:
        """Whether the closed loop is known to have all poles left of the imaginary axis."""
        return self.unstable == 0

    @property
    def status(self) -> str:
        """Whether the closed loop is stable, or how many poles it has in the right half plane, in words."""
        if self.unstable is None:
            return "closed loop on the boundary of stability, or too near it to tell"
        poles = f"{self.unstable} pole" + "s" * (self.unstable > 1)
        return f"closed loop unstable: {poles} right of the imaginary axis" if self.unstable else "closed loop stable"

    @property
    def remark(self) -> str:
        """What is not complete; empty if nothing."""
        if self.complete_to == np.inf:
            return ""
        return (
            f"phase crossovers with |L| above {self.floor:g} may go on for ever, since L has a direct path through a "
            f"delay; those up to {self.complete_to:.4g} rad/s are given"
        )

    def __repr__(self) -> str:
        many = len(self.gain_crossovers), len(self.phase_crossovers)
        return (
            f"<Margins, {self.status}: gain {self.gain_margin:.4g} and {self.gain_reduction_margin:.4g}, phase "
            f"{self.phase_margin:.4g} rad, delay {self.delay_margin:.4g} s, modulus {self.modulus_margin:.4g}; "
            f"{many[0]} gain and {many[1]} phase crossovers above |L| = {self.floor:g}>"
        )


def margins(loop: Operand, floor: float = 0.01) -> Margins:
    """Margins of the loop that negative unit feedback closes around `loop`.

    L is a polynomial with a proven error on each of the panels that cover all frequencies from 0 (or from far below
    every crossover, where L has an integrator) to where a bound keeps L within `floor` of its limit. Crossovers are
    those of the polynomials, isolated by Descartes' rule of signs so that none is missed, then refined by Newton's
    method on L itself; two within 1e-8 of a panel count as one touch. If no phase crossover above the floor has
    |L| < 1, the gain margin is looked for below it, down to |L| = 1e-9. Closed-loop poles right of the imaginary axis
    are counted (`count_right_of`): the margins of an unstable loop say nothing of robustness.

    Raises
    ------
    InvalidParameterError
        If the loop has more than one input or output, the floor is not in (0, 1), or |L| = 1 on a band of frequencies.
    NeutralSystemError
        If the direct path through a delay has so much gain that crossovers have no end.
    """
    floor = real_number(floor, "The floor of phase crossovers")
    if not 0 < floor < 1:
        raise InvalidParameterError(f"The floor of phase crossovers must lie between 0 and 1, got {floor!r}.")
    it = frequency_domain(loop)
    require_siso(it.system)
    low = it.lowest()
    top = max(it.far.beyond(floor), it.far.beyond(_room_beside_one(it.far)), 10.0 * low)
    pieces = it.panels(low, top)
    gain = gain_crossovers(it.blocks, pieces)
    phase = phase_crossovers(it.blocks, pieces, floor)
    factors = _gain_factors(it, top, phase, floor)
    lags = (np.angle(it.values(gain)[:, 0, 0]) + np.pi) % (2 * np.pi)  # still to spend until -1
    modulus, where = _modulus_margin(it, top, nearest_to_minus_one(it.blocks, pieces))
    return Margins(
        gain_margin=float(factors[factors > 1].min(initial=np.inf)),
        gain_reduction_margin=float(factors[factors < 1].max(initial=0.0)),
        phase_margin=float(lags.min(initial=np.inf)),
        delay_margin=float((lags / gain).min(initial=np.inf)),
        modulus_margin=modulus,
        gain_crossovers=gain,
        phase_crossovers=phase,
        modulus_frequency=where,
        floor=floor,
        unstable=_unstable(it),
        complete_to=top if _goes_on(it.far, floor) else np.inf,
    )


def _unstable(it: FrequencyDomain) -> int | None:
    """Closed-loop poles right of the axis, counted; by Nyquist's criterion where the closed loop is of neutral type."""
    try:
        closed = feedback(it.system)
    except AlgebraicLoopError:
        return None
    return (
        count_right_of(closed, 0.0).roots if is_retarded(closed) else nyquist_response(it.system).closed_loop_unstable
    )


def _goes_on(far: Asymptote, floor: float) -> bool:
    """Whether L may be real and below -floor at frequencies without end."""
    return bool(far.delayed[0, 0] > 0 and far.undelayed[0, 0] - far.delayed[0, 0] < -floor)


def _room_beside_one(far: Asymptote) -> float:
    """How far L's limit at high frequencies stays from |L| = 1."""
    direct, delayed = abs(far.undelayed[0, 0]), far.delayed[0, 0]
    room = max(direct - delayed - 1.0, 1.0 - direct - delayed)
    if delayed > 0 and not room > 0:
        raise NeutralSystemError(
            f"The loop's direct path passes gains up to {direct + delayed:.3g} through a delay: with 1 or more, "
            "closing it makes a neutral system without a stability margin. Put a lag into that path."
        )
    return max(room, _LEAST)


def _sizes(it: FrequencyDomain, omega: FloatArray) -> FloatArray:
    return np.abs(it.values(omega)[:, 0, 0])


def _gain_factors(it: FrequencyDomain, top: float, phase: FloatArray, floor: float) -> FloatArray:
    """Factors on the gain that put L through -1: at phase crossovers, and at infinite frequency.

    While none of them exceeds 1, crossovers are looked for at higher frequencies, where |L| is below the floor.
    """
    direct = it.far.undelayed[0, 0] - it.far.delayed[0, 0]
    factors = np.append(1.0 / _sizes(it, phase), [-1.0 / direct] if direct < 0 else [])
    level = floor
    while not (factors > 1).any() and level > _LEAST:
        level, low = max(level / 10, _LEAST), top
        top = it.far.beyond(level)
        if not it.affordable(top):
            break
        if top > low:
            pieces = it.panels(low, top)
            further = _sizes(it, phase_crossovers(it.blocks, pieces, level))
            factors = np.append(factors, 1.0 / further[further < 1])
    return factors


def _modulus_margin(it: FrequencyDomain, top: float, found: tuple[float, float]) -> tuple[float, float]:
    """The smallest |1 + L|, sought up to where L is nearer to its limit than the best found, or that limit."""
    limit = float(abs(1.0 + it.far.undelayed[0, 0]) - it.far.delayed[0, 0])
    while it.far.rest(top) > max(limit - found[0], _LEAST):
        low, top = top, it.far.beyond(max(0.9 * (limit - found[0]), _LEAST))
        if not (top > low and it.affordable(top)):
            break
        pieces = it.panels(low, top)
        found = min(found, nearest_to_minus_one(it.blocks, pieces))
    return found if found[0] < limit else (limit, np.inf)
