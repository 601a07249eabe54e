"""Inequalities between the unknowns of a fit: low <= g(unknowns) <= high, written in CasADi.

    modulus margin >= m:   1 - m^2 |s (s + b)|^2 / |s (s + b) + (kp + kd s + ki / s) exp(-s T)|^2 >= 0,   s = j w,

with the delay exact, at each of a grid of frequencies; the form stays bounded where L does not.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np

from flycontrol.errors import InvalidParameterError
from flycontrol.identify.gains.problem import FitProblem

Symbols = Mapping[str, Any]  #: CasADi symbols of the unknowns by name, numbers of what is known; the rest is 0
_FREQUENCIES = np.geomspace(3.0, 3000.0, 300)  #: [rad/s]; 1 % from any minimum, where |1 + L| errs by 1e-4


@dataclass(frozen=True, slots=True, kw_only=True)
class Constraint:
    """low <= expression <= high, element by element.

    >>> damped = Constraint(name="kd below damping", expression=lambda p: p["damping"] - p["kd"])
    """

    name: str
    expression: Callable[[Symbols], Any]  #: of the symbols, in CasADi's functions: a number or a column
    low: float = 0.0
    high: float = np.inf

    def __post_init__(self) -> None:
        if not self.low < self.high:
            raise InvalidParameterError(
                f"Constraint {self.name!r}: low must lie below high, got {self.low!r} and {self.high!r}."
            )


def modulus_margin_at_least(least: float) -> Constraint:
    """min |1 + L| >= least, for the exact delay and small angles. It means robustness only beside `stable`."""
    if not 0 < least < 1:
        raise InvalidParameterError(f"A modulus margin must lie between 0 and 1, got {least!r}.")
    return Constraint(name=f"modulus margin >= {least:g}", expression=lambda p: _margins(p, least))


def _margins(p: Symbols, least: float) -> Any:
    w, T, b = ca.DM(_FREQUENCIES), p["delay"], p["damping"]
    cos, sin, turning = ca.cos(w * T), ca.sin(w * T), p["kd"] * w - p["ki"] / w
    real = -(w**2) + p["kp"] * cos + turning * sin
    imaginary = b * w + turning * cos - p["kp"] * sin
    return 1.0 - least**2 * w**2 * (w**2 + b**2) / (real**2 + imaginary**2)


def stable(room: float = 0.0) -> Constraint:
    """T + room <= (atan(kd wc / kp) + atan(b / wc)) / wc, kp >= 0, b + kd >= 0: P or PD on the yaw angle.

    Parameters
    ----------
    room
        Least delay margin [s].
    """
    if not (room >= 0 and np.isfinite(room)):
        raise InvalidParameterError(f"The room for delay must be >= 0 s, got {room!r}.")
    return Constraint(
        name="stable" if room == 0 else f"delay margin >= {room:g} s", expression=lambda p: _stability(p, room)
    )


def _stability(p: Symbols, room: float) -> Any:
    if isinstance(p["ki"], ca.SX) or p["ki"]:
        raise InvalidParameterError("The closed form of stability is that of P and PD; leave ki out, or bound margins.")
    b, kp, kd, T = p["damping"], p["kp"], p["kd"], p["delay"]
    excess = kd**2 - b**2
    wc = ca.sqrt((excess + ca.sqrt(excess**2 + 4.0 * kp**2 + 1e-12)) / 2.0 + 1e-9)
    longest = (ca.atan2(kd * wc, kp) + ca.atan2(b, wc)) / wc
    return ca.vertcat(longest / (T + room) - 1.0, kp * T**2, (b + kd) * T)


def compiled(constraint: Constraint, problem: FitProblem) -> ca.Function:
    """x (k,) -> the constraint's expression.

    Raises
    ------
    InvalidParameterError
        If the expression does not depend on any unknown, or is no expression.
    """
    x = ca.SX.sym("x", len(problem.names))
    p: dict[str, Any] = dict.fromkeys(("kp", "kd", "ki", "damping"), 0.0)
    p |= {name: float(value) for name, value in problem.model.known.items()}
    p |= {name: x[i] for i, name in enumerate(problem.names)}
    try:
        g = ca.SX(constraint.expression(p))
    except KeyError as missing:
        raise InvalidParameterError(
            f"Constraint {constraint.name!r} asks for {missing.args[0]!r}; there are {', '.join(p)}."
        ) from missing
    except (TypeError, NotImplementedError) as error:
        raise InvalidParameterError(
            f"Constraint {constraint.name!r} must be an expression of CasADi's functions, such as casadi.sqrt: {error}."
        ) from error
    if not ca.depends_on(g, x):
        raise InvalidParameterError(
            f"Constraint {constraint.name!r} does not depend on any unknown; write it in CasADi's functions, since "
            "float() of a symbol is NaN."
        )
    return ca.Function("constraint", [x], [ca.densify(g)])
