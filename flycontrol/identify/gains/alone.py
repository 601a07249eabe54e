"""Each fly, or each recording, fitted alone: what pooling can be judged by.

>>> flies = fits_alone(trials, gain_model("PD"))  # doctest: +SKIP
>>> [(fly.name, fly.estimate("kp"), fly.standard_error("kp")) for fly in flies]  # doctest: +SKIP
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, Literal, cast

import numpy as np
from numpy.typing import NDArray

from flycontrol.errors import InvalidInputError, InvalidParameterError
from flycontrol.identify.gains.fit import fit_gains
from flycontrol.identify.gains.labour import HERE, Labour
from flycontrol.identify.gains.least_squares import Loss
from flycontrol.identify.gains.model import GainModel
from flycontrol.identify.gains.noise import Noise
from flycontrol.identify.gains.problem import standard_model
from flycontrol.identify.gains.result import FitResult
from flycontrol.jobs.packed import Result
from flycontrol.jobs.work import Work
from flycontrol.model.trial import Trial

FloatArray = NDArray[np.float64]
By = Literal["fly", "recording"]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LoneFit:
    """One fly, or one recording, fitted without the others."""

    name: str  #: of the fly or the recording
    trials: tuple[str, ...]  #: names of its recordings
    kinds: tuple[str, ...]  #: unknowns that a pooled fit would share: "kp", "kd", "delay", "damping"
    values: FloatArray  #: (k,) their estimates, corrected for bias, in the units of `response.UNITS`
    covariance: FloatArray  #: (k, k)
    freedom: FloatArray  #: (k,) degrees of freedom of each standard error
    cost: float  #: whitened sum of squares at the minimum
    free: int  #: unknowns that the data determine, its own ones included
    minimum: Mapping[str, float]  #: all its unknowns at the minimum, not corrected: "kp", "impulse[trial 3]"
    noise: tuple[tuple[Noise, ...], ...]  #: by recording, by channel
    usable: bool  #: by its status as of any fit, and all shared unknowns determined
    status: str  #: the fit's sentence

    def estimate(self, kind: str) -> float:
        """One of `values`."""
        return float(self.values[self._place(kind)])

    def standard_error(self, kind: str) -> float:
        """Of `estimate`."""
        i = self._place(kind)
        return float(np.sqrt(self.covariance[i, i]))

    def _place(self, kind: str) -> int:
        if kind not in self.kinds:
            raise InvalidParameterError(f"No shared unknown is called {kind!r}; there are {', '.join(self.kinds)}.")
        return self.kinds.index(kind)


def fits_alone(
    trials: Sequence[Trial],
    model: GainModel | None = None,
    *,
    by: By = "fly",
    noise: str | int = "auto",
    loss: Loss = "linear",
    labour: Labour = HERE,
) -> tuple[LoneFit, ...]:
    """Fit each fly, or each recording, alone.

    Parameters
    ----------
    model, noise, loss
        As in `fit_gains`.
    by
        Fit together what one "fly" did, or each "recording".
    labour
        Processes, folder for finished parts, progress.

    Raises
    ------
    InvalidInputError
        If there is no trial.
    """
    if not trials:
        raise InvalidInputError("Fits alone need at least one trial, got none.")
    model = standard_model(trials) if model is None else model
    groups = grouped(trials, by)
    work = Work(
        task=partial(_fitted, model=model, noise=noise, loss=loss), items=list(groups.values()), seed=0, chunk=1,
        name="flies" if by == "fly" else "recordings",
    )  # fmt: skip
    found = labour.done(work)
    return tuple(
        _unpacked(name, group, cast("dict[str, Any]", result))
        for (name, group), result in zip(groups.items(), found, strict=True)
    )


def grouped(trials: Sequence[Trial], by: By) -> dict[str, list[Trial]]:
    """Trials by fly or by recording, in the order of their first appearance."""
    groups: dict[str, list[Trial]] = {}
    for trial in trials:
        groups.setdefault(trial.fly if by == "fly" else trial.name, []).append(trial)
    return groups


def lone_fit(name: str, found: FitResult) -> LoneFit:
    """What the comparison of flies or recordings needs of a fit."""
    return _unpacked(name, found.problem.trials, _packed(found))


def _fitted(
    group: Sequence[Trial], rng: np.random.Generator, *, model: GainModel, noise: str | int, loss: Loss
) -> Result:
    del rng
    return _packed(fit_gains(group, model, noise=noise, loss=loss))


def _packed(found: FitResult) -> dict[str, Any]:
    """A fit as numbers and arrays, which travel between processes and are kept in a folder."""
    shared = [i for i, setting in enumerate(found.problem.settings) if setting.shared == "all"]
    determined = len(found.problem.names) - int(found.minimum.held.sum()) - len(found.uncertainty.unidentifiable)
    return {
        "kinds": [found.problem.kinds[i] for i in shared],
        "values": np.array([found.estimates[i].value for i in shared]),
        "covariance": found.covariance[np.ix_(shared, shared)],
        "freedom": found.uncertainty.freedom[shared],
        "cost": found.minimum.at.cost,
        "free": determined,
        "minimum": dict(zip(found.problem.names, found.minimum.x.tolist(), strict=True)),
        "noise": [
            [{"deviation": n.deviation, "pacf": n.pacf, "uncertainty": n.uncertainty} for n in channels]
            for channels in found.noise
        ],
        "usable": bool(found.usable and all(np.isfinite(found.estimates[i].standard_error) for i in shared)),
        "status": found.status,
    }


def _unpacked(name: str, group: Sequence[Trial], packed: Mapping[str, Any]) -> LoneFit:
    return LoneFit(
        name=name, trials=tuple(trial.name for trial in group), kinds=tuple(packed["kinds"]), values=packed["values"],
        covariance=packed["covariance"], freedom=packed["freedom"], cost=packed["cost"], free=packed["free"],
        minimum=packed["minimum"], noise=tuple(tuple(Noise(**n) for n in channels) for channels in packed["noise"]),
        usable=packed["usable"], status=packed["status"],
    )  # fmt: skip
