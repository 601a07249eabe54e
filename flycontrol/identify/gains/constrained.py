"""Fits under inequality constraints by IPOPT, the delay exact or approximated.

    minimise |V^(-1/2) (model(x) - measured)|^2   subject to   low <= g(x) <= high

The residuals and their derivatives are those of the unconstrained fit, handed to CasADi as a function; the Lagrangian's
Hessian is 2 J^T V^-1 J (Gauss and Newton) plus the constraints' own.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from flycontrol.errors import InvalidParameterError
from flycontrol.identify.gains.constraints import Constraint, compiled
from flycontrol.identify.gains.fit import fit_gains
from flycontrol.identify.gains.least_squares import Loss, NormalEquations, WeightedProblem
from flycontrol.identify.gains.model import GainModel
from flycontrol.identify.gains.pade_route import with_pade
from flycontrol.identify.gains.result import FitResult
from flycontrol.model.trial import Trial

FloatArray = NDArray[np.float64]
_BINDING = 1e-4  #: multiplier, in units of the residuals' variance per unit of the constraint
_MOST_STEPS = 200


@dataclass(frozen=True, eq=False)
class ConstrainedFit:
    """The best fit among those that keep the constraints, beside the one that is free."""

    free: FitResult  #: exact and unconstrained, whose noise weighs the samples
    route: str  #: "exact delay" or "Padé [4/4]"
    x: FloatArray  #: (k,) least-squares values
    at: NormalEquations
    covariance: FloatArray  #: (k, k) of the values, those along binding constraints held
    binding: tuple[str, ...]  #: names of the constraints that the data push against
    converged: bool
    status: str  #: a sentence

    @property
    def names(self) -> tuple[str, ...]:
        """Of the unknowns."""
        return self.free.problem.names

    @property
    def values(self) -> dict[str, float]:
        """Least-squares values under the constraints, in the units of `response.UNITS`."""
        return dict(zip(self.names, self.x.tolist(), strict=True))

    @property
    def standard_errors(self) -> dict[str, float]:
        """Of the values, as far as the binding constraints leave them free."""
        return dict(zip(self.names, np.sqrt(np.diag(self.covariance)).tolist(), strict=True))

    @property
    def price(self) -> float:
        """Rise of the deviance over the free exact fit: large where the data contradict the constraints."""
        return float(self.at.cost - self.free.minimum.at.cost)


def fit_gains_under(
    constraints: Sequence[Constraint],
    trials: Sequence[Trial],
    model: GainModel | None = None,
    *,
    pade_order: int | None = None,
    noise: str | int = "auto",
    loss: Loss = "linear",
) -> ConstrainedFit:
    """Fit trials under constraints.

    Parameters
    ----------
    constraints
        Such as `modulus_margin_at_least(0.5)`, `stable()`, or a `Constraint` of one's own.
    pade_order
        Of the Pade approximant in place of the delay; None: the delay is exact.

    Raises
    ------
    InvalidInputError, InvalidParameterError
        As `fit_gains`; for no constraint, or one that is not an expression of the unknowns.
    """
    if not constraints:
        raise InvalidParameterError("A constrained fit needs at least one constraint, got none; use fit_gains.")
    return constrained_fit(fit_gains(trials, model, noise=noise, loss=loss), constraints, pade_order)


def constrained_fit(
    free: FitResult, constraints: Sequence[Constraint], pade_order: int | None = None
) -> ConstrainedFit:
    """Repeat a fit under constraints, at the noise that it found; the search begins at its minimum."""
    problem = free.problem if pade_order is None else with_pade(free.problem, pade_order)
    route = "exact delay" if pade_order is None else f"Padé [{pade_order}/{pade_order}]"
    weighted = WeightedProblem(problem, free.weighted.noise, free.weighted.loss)
    functions = [compiled(constraint, problem) for constraint in constraints]
    end = _search(weighted, free.minimum.x, constraints, functions)
    binding = [i for i, pull in enumerate(end.pulls) if np.abs(pull).max() > _BINDING]
    names = tuple(constraints[i].name for i in binding)
    held = np.array([end.pulls[i] @ np.array(functions[i].jacobian()(end.x, 0)) for i in binding])
    return ConstrainedFit(
        free=free, route=route, x=end.x, at=end.at, covariance=_covariance(end.at.matrix, held), binding=names,
        converged=end.ending == "Solve_Succeeded", status=_status(route, end.ending, names),
    )  # fmt: skip


@dataclass(frozen=True, slots=True, eq=False)
class _End:
    """Where IPOPT ended."""

    x: FloatArray
    at: NormalEquations
    pulls: list[FloatArray]  #: multipliers of each constraint's elements
    ending: str  #: IPOPT's own word


class _Products(ca.Callback):
    """x in units of `size` -> cost, gradient / 2 and Gauss-Newton matrix / 2."""

    def __init__(self, weighted: WeightedProblem, size: FloatArray) -> None:
        ca.Callback.__init__(self)
        self.weighted, self.size = weighted, size
        self.construct("products", {})

    def get_n_in(self) -> int:
        return 1

    def get_n_out(self) -> int:
        return 3

    def get_sparsity_in(self, i: int) -> ca.Sparsity:
        return ca.Sparsity.dense(len(self.size), 1)

    def get_sparsity_out(self, i: int) -> ca.Sparsity:
        k = len(self.size)
        return ca.Sparsity.dense(*((1, 1), (k, 1), (k, k))[i])

    def eval(self, arg: Sequence[Any]) -> list[Any]:
        at = self.weighted.normal_equations(np.array(arg[0]).ravel() * self.size)
        return [at.cost, at.gradient * self.size, at.matrix * np.outer(self.size, self.size)]


def _search(
    weighted: WeightedProblem, start: FloatArray, constraints: Sequence[Constraint], functions: Sequence[ca.Function]
) -> _End:
    """IPOPT from the start, unknowns scaled by what moves the prediction by one standard deviation of the noise."""
    curvature = np.diag(weighted.normal_equations(start).matrix)
    size = np.where(curvature > 0, 1.0 / np.sqrt(np.maximum(curvature, 1e-300)), 1.0)
    size = np.minimum(size, np.maximum(np.abs(start), 1e-3))
    products = _Products(weighted, size)
    y = ca.MX.sym("y", len(start))
    g = ca.vertcat(*[function(y * ca.DM(size)) for function in functions])
    solver = ca.nlpsol("fit", "ipopt", {"x": y, "f": products(y)[0], "g": g}, _options(products, y, g))
    found = solver(
        x0=start / size, lbx=weighted.problem.low / size, ubx=weighted.problem.high / size,
        lbg=np.concatenate([np.full(f.numel_out(0), c.low) for c, f in zip(constraints, functions, strict=True)]),
        ubg=np.concatenate([np.full(f.numel_out(0), c.high) for c, f in zip(constraints, functions, strict=True)]),
    )  # fmt: skip
    x = np.clip(np.array(found["x"]).ravel() * size, weighted.problem.low, weighted.problem.high)
    ends = np.cumsum([function.numel_out(0) for function in functions])[:-1]
    pulls = [np.asarray(pull) for pull in np.split(np.array(found["lam_g"]).ravel(), ends)]
    return _End(x, weighted.normal_equations(x), pulls, str(solver.stats()["return_status"]))


def _options(products: _Products, y: ca.MX, g: ca.MX) -> dict[str, Any]:
    """Gradient and Hessian of our own, and silence."""
    nothing, of_cost, of_g = ca.MX.sym("p", 0), ca.MX.sym("lam_f"), ca.MX.sym("lam_g", g.numel())
    cost, gradient, matrix = products(y)
    bent = ca.hessian(ca.dot(of_g, g), y)[0]
    return {
        "grad_f": ca.Function("grad_f", [y, nothing], [cost, 2.0 * gradient]),
        "hess_lag": ca.Function("hess_lag", [y, nothing, of_cost, of_g], [ca.triu(2.0 * of_cost * matrix + bent)]),
        "calc_lam_p": False,
        "no_nlp_grad": True,
        "print_time": False,
        "error_on_fail": False,
        "ipopt": {"print_level": 0, "sb": "yes", "tol": 1e-9, "max_iter": _MOST_STEPS},
    }


def _covariance(matrix: FloatArray, held: FloatArray) -> FloatArray:
    """Z (Z^T H Z)^-1 Z^T, Z the directions (in scaled unknowns) along which no binding constraint moves."""
    size = 1.0 / np.sqrt(np.maximum(np.diag(matrix), 1e-300))
    H = matrix * np.outer(size, size)
    Z = scipy.linalg.null_space(held * size) if len(held) else np.eye(len(H))
    return size[:, None] * (Z @ np.linalg.pinv(Z.T @ H @ Z, hermitian=True) @ Z.T) * size


def _status(route: str, ending: str, binding: Sequence[str]) -> str:
    if ending != "Solve_Succeeded":
        words = ending.replace("_", " ").lower()
        return f"{route}: not converged: IPOPT ended with {words!r}; loosen a constraint or give starting values."
    if binding:
        return f"{route}: converged; {' and '.join(binding)} holds the estimate back."
    return f"{route}: converged; no constraint matters."
