"""Where the gains of a yaw loop lie among all gains: regions of stability, decay, robustness, and room for delay."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flycontrol.delay.bracket import bracketed_root
from flycontrol.delay.characteristic import CharacteristicBlocks
from flycontrol.delay.chart import Axis, StabilityChart, stability_chart
from flycontrol.delay.dcurve import PDGains, pd_boundary
from flycontrol.delay.system import FloatArray
from flycontrol.errors import InvalidParameterError
from flycontrol.model.gains import fastest_decay, gain_crossover, largest_stable_delay, modulus_margins
from flycontrol.model.yaw import YawLoop, require_pd

_GRID = 61  # points along each gain
_SLICE = 49  # points along gain factor and delay
_ROOM = 0.13  # of the stable region's extent, left around it
_MOST_TURNS = 15.0  # delay times the loop's fastest rate up to which a slow loop is shown
_FARTHEST = 2.5  # extents of the stable region within which a loop is still shown at its own place


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class GainPlane:
    """The plane (kp, kd) at a loop's own damping and delay."""

    chart: StabilityChart  #: counted unstable roots and certified decay rates over kp [1/s^2] and kd [1/s]
    distance: FloatArray  #: min |1 + L|, the modulus margin where the loop is stable, shape (nkd, nkp)
    boundary: PDGains  #: the D-curve from w = 0 on: a pair of roots lies on the imaginary axis
    edge: PDGains  #: the part of it around the stable gains, up to where it comes back to kp = 0
    edge_omega: FloatArray  #: frequency of the pair on the edge [rad/s]
    fastest: tuple[float, float]  #: kp [1/s^2] and kd [1/s] where three real roots meet and decay is fastest
    fastest_rate: float  #: decay rate there [1/s]
    own: tuple[float, float]  #: kp [1/s^2] and kd [1/s] of the loop
    agreeing: int  #: grid points at which the closed form gives the same verdict on stability as the count


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class DelaySlice:
    """The plane of a common factor on both gains and the delay, at a loop's own damping and ratio of gains."""

    chart: StabilityChart  #: counted unstable roots over the factor [1] and the delay [s]
    factor: FloatArray  #: common factor on both gains, shape (k,)
    largest_stable_delay: FloatArray  #: by the closed form [s], shape (k,)
    next_crossing: FloatArray  #: delay at which a second pair of roots becomes unstable [s], shape (k,)
    agreeing: int  #: grid points at which the closed form gives the same verdict on stability as the count


def gain_plane(loop: YawLoop) -> GainPlane | None:
    """Chart of all PD gains at the loop's damping and delay; None without delay, where no gain is too high."""
    require_pd(loop)
    b, T = loop.plant.damping_rate, loop.delay
    if T == 0:
        return None
    omega, edge = _stable_part(b, T)
    kp, kd, s0 = fastest_decay(b, T)
    x = _axis("K_P/I", "1/s^2", np.append(edge.kp, kp), loop.kp)
    y = _axis("K_D/I", "1/s", np.append(edge.kd, kd), loop.kd)
    chart = stability_chart(lambda p, d: _blocks(b, p, d, T), x, y, ("decay_rate",))
    every_kp, every_kd = (grid.ravel() for grid in np.meshgrid(x.values, y.values))
    expected = np.array([_is_stable(b, p, d, T) for p, d in zip(every_kp, every_kd, strict=True)])
    return GainPlane(
        chart=chart, distance=modulus_margins(b, every_kp, every_kd, T).reshape(chart.stable.shape),
        boundary=pd_boundary(b, T, np.linspace(0.0, 4.0 * np.pi / T, 1600)), edge=edge, edge_omega=omega,
        fastest=(kp, kd), fastest_rate=-s0, own=(loop.kp, loop.kd),
        agreeing=int((expected == chart.stable.ravel()).sum()),
    )  # fmt: skip


def delay_slice(loop: YawLoop) -> DelaySlice | None:
    """Chart over gain and delay; None where no delay is stable (kp <= 0 or b + kd <= 0), or there is none."""
    require_pd(loop)
    b, kp, kd, T = loop.plant.damping_rate, loop.kp, loop.kd, loop.delay
    if T == 0 or not (kp > 0 and b + kd > 0):
        return None
    high = 4.0 if kd >= 0 else min(4.0, 1.0 + 0.9 * (b / -kd - 1.0))  # b + factor kd stays > 0
    rate = b + abs(kd) + np.sqrt(kp)
    longest = 1.35 * max(T, min(largest_stable_delay(b, kp, kd), _MOST_TURNS / rate))
    x = Axis("gain factor", "1", np.linspace(high / _SLICE, high, _SLICE))
    y = Axis("delay", "s", np.linspace(longest / _SLICE, longest, _SLICE))
    chart = stability_chart(lambda factor, delay: _blocks(b, factor * kp, factor * kd, delay), x, y)
    factor = np.linspace(1e-3 * high, high, 400)
    largest = np.array([largest_stable_delay(b, f * kp, f * kd) for f in factor])
    turn = np.array([2 * np.pi / gain_crossover(b, f * kp, f * kd) for f in factor])
    expected = [[_is_stable(b, f * kp, f * kd, delay) for f in x.values] for delay in y.values]
    return DelaySlice(
        chart=chart, factor=factor, largest_stable_delay=largest, next_crossing=largest + turn,
        agreeing=int((np.array(expected) == chart.stable).sum()),
    )  # fmt: skip


def _blocks(b: float, kp: float, kd: float, delay: float) -> CharacteristicBlocks:
    """psi'' = -b psi' - w,  w(t) = (kp psi + kd psi')(t - delay)."""
    return CharacteristicBlocks(
        np.array([[0.0, 1.0], [0.0, -b]]), np.array([[0.0], [-1.0]]), np.array([[kp, kd]]), np.zeros((1, 1)),
        np.array([delay]),
    )  # fmt: skip


def _is_stable(b: float, kp: float, kd: float, delay: float) -> bool:
    """Closed form: kp > 0, b + kd > 0 and a delay below T_max."""
    return kp > 0 and b + kd > 0 and delay < largest_stable_delay(b, kp, kd)


def _stable_part(b: float, T: float) -> tuple[FloatArray, PDGains]:
    """The D-curve around the stable region: from w = 0 to where it comes back to kp = 0, b sin wT = -w cos wT."""
    if not 1 + b * T > 0:
        raise InvalidParameterError(
            f"No PD gains hold a plant that runs away as fast as this one, b T = {b * T:.3g}; b T must be above -1."
        )
    end = bracketed_root(lambda w: w * np.cos(w * T) + b * np.sin(w * T), 1e-3 / T, np.pi / T)
    omega = np.linspace(0.0, end, 400)
    return omega, pd_boundary(b, T, omega)


def _axis(name: str, unit: str, region: FloatArray, own: float) -> Axis:
    """Values over the stable region and the loop itself, if it is not too far off."""
    low, high = float(region.min()), float(region.max())
    extent = high - low
    shown = min(max(own, low - _FARTHEST * extent), high + _FARTHEST * extent)
    low, high = min(low, shown) - _ROOM * extent, max(high, shown) + _ROOM * extent
    return Axis(name, unit, np.linspace(low, high, _GRID))
