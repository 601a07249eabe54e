"""Trials and a model as one least-squares problem: a vector of unknowns, residuals and their exact derivatives."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from flycontrol.errors import InvalidInputError
from flycontrol.identify.gains.kernels import normal as kernels
from flycontrol.identify.gains.kernels.march import RULE
from flycontrol.identify.gains.model import GainModel, Prior, Unknown, gain_model
from flycontrol.identify.gains.noise import Noise, whitened
from flycontrol.identify.gains.response import NAMES, Drive, Span, drive_of, evaluate, parameter_vector, span_of
from flycontrol.model.trial import Pulse, TorqueTrace, Trial
from flycontrol.units import ms

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
#: What `response.evaluate` is: (p, active, drive, span, times, torque) -> yaw and N_fly / I, each with derivatives.
Response = Callable[[FloatArray, IntArray, Drive, Span, FloatArray, bool], tuple[FloatArray, FloatArray | None]]
_GAP = 1.5  #: steps of the nominal rate after which samples count as separate stretches
_TENFOLD = 0.1
_DELAY, _HEADING, _PADDLING_GAIN, _IMPULSE = (
    NAMES.index(name) for name in ("delay", "heading", "paddling_gain", "impulse")
)


@dataclass(frozen=True, slots=True, eq=False)
class Channel:
    """Measured samples of one channel of one trial."""

    kind: str  #: "yaw" or "paddling"
    times: FloatArray  #: (n,) [s]
    values: FloatArray  #: (n,) [rad]
    firsts: IntArray  #: indices at which a stretch without gap begins


@dataclass(frozen=True, slots=True, eq=False)
class TrialPart:
    """One trial of a problem: its data, its drive, and where its parameters stand in the vector of unknowns."""

    trial: Trial
    drive: Drive
    span: Span
    channels: tuple[Channel, ...]
    resting: FloatArray  #: values of the parameters that are known (12,)
    active: IntArray  #: (m,) indices of the unknown ones among `NAMES`
    places: IntArray  #: (m,) where they stand in the vector of unknowns
    grid: tuple[NDArray[np.intp], ...]  #: the same for a matrix
    respond: Response = evaluate  #: exact, unless an approximation takes its place

    def products(self, x: FloatArray, noise: Noise) -> FloatArray:
        """R R^T (1 + m, 1 + m) of whitened residuals of yaw and, below, its derivatives."""
        yaw, drive = self.channels[0], self.drive
        if self.respond is not evaluate:
            rows = self.predicted(x)[0]
            rows[0] -= yaw.values
            W = whitened(rows, yaw.firsts, noise)
            return W @ W.T
        return kernels.products(
            self.parameters(x), self.active, self.span, (drive.majors, drive.minors), drive.pieces,
            (yaw.times, yaw.values, yaw.firsts), (noise.pacf, noise.deviation), RULE,
        )  # fmt: skip

    def parameters(self, x: FloatArray) -> FloatArray:
        """The kernel's parameters (12,) for a vector of unknowns."""
        p = self.resting.copy()
        p[self.active] = x[self.places]
        return p

    def predicted_at(self, x: FloatArray, times: FloatArray) -> list[FloatArray]:
        """For each channel the model at times (n,) [s] inside the recording."""
        p = self.parameters(x)
        none = np.zeros(0, dtype=np.int64)
        yaw, fly = evaluate(p, none, self.drive, self.span, times, len(self.channels) > 1)
        return [yaw[0]] if fly is None else [yaw[0], fly[0] / p[_PADDLING_GAIN]]

    def predicted(self, x: FloatArray, derivatives: bool = True) -> list[FloatArray]:
        """For each channel the model's samples and, below, its derivatives: (1 + m, n), or (1, n) without."""
        p = self.parameters(x)
        active = self.active if derivatives else np.zeros(0, dtype=np.int64)
        wants_fly = len(self.channels) > 1
        times = self.channels[0].times
        if wants_fly:
            times = np.union1d(times, self.channels[1].times)
        yaw, fly = self.respond(p, active, self.drive, self.span, times, wants_fly)
        if fly is None:
            return [yaw]
        gain = p[_PADDLING_GAIN]
        paddling = fly / gain
        paddling[1:][active == _PADDLING_GAIN] = -paddling[0] / gain
        rows = {"yaw": yaw, "paddling": paddling}
        return [rows[c.kind][:, np.searchsorted(times, c.times)] for c in self.channels]


@dataclass(frozen=True, eq=False)
class FitProblem:
    """Trials, the model, and the vector of unknowns: shared ones first, then those of each trial."""

    trials: tuple[Trial, ...]
    model: GainModel
    names: tuple[str, ...]  #: of the unknowns: "kp", "impulse[trial 3]"
    kinds: tuple[str, ...]  #: of the unknowns, without the trial: "kp", "impulse"
    settings: tuple[Unknown, ...]
    parts: tuple[TrialPart, ...]

    @cached_property
    def low(self) -> FloatArray:
        """Lower bounds (k,)."""
        return np.array([setting.low for setting in self.settings])

    @cached_property
    def high(self) -> FloatArray:
        """Upper bounds (k,)."""
        return np.array([setting.high for setting in self.settings])

    @cached_property
    def divisors(self) -> list[int]:
        """Places of the unknowns that the prediction is divided by, so that it is linear in their reciprocals."""
        return [i for i, kind in enumerate(self.kinds) if kind == "paddling_gain"]

    @cached_property
    def priors(self) -> list[tuple[int, Prior]]:
        """Place and prior of the unknowns that have one."""
        return [(i, setting.prior) for i, setting in enumerate(self.settings) if setting.prior is not None]

    @property
    def samples(self) -> int:
        """Number of measured samples of all channels."""
        return sum(len(channel.values) for part in self.parts for channel in part.channels)


def reciprocal_step(x: float, move: float, *, shut: bool = False) -> float:
    """x / (1 - move / x): where x goes if 1 / x takes the step -move / x^2, which is move to the first order.

    `shut`: it may not pass infinity, and grows tenfold at most.
    """
    left = 1.0 - move / x
    return x / max(left, _TENFOLD) if shut else x / (left or _TENFOLD)


def standard_model(trials: Sequence[Trial]) -> GainModel:
    """PD on the yaw angle, gains, delay and damping unknown; the paddling gain too where paddling was measured."""
    _refuse_others(trials)
    measured = any(trial.paddling is not None for trial in trials)
    return gain_model("PD", estimate=["paddling_gain"] if measured else [])


def _refuse_others(trials: Sequence[Trial]) -> None:
    if not trials:
        raise InvalidInputError("A fit needs at least one trial, got none.")
    other = next((trial for trial in trials if not isinstance(trial, Trial)), None)
    if other is not None:
        raise InvalidInputError(
            f"A fit takes Trials, which say what perturbed the fly, got a {type(other).__name__}; read files by "
            "flycontrol.io.trials.read_trials, or make one of a Recording by "
            "flycontrol.model.recorded_trial.trial_of_recording."
        )


def _refuse_outside(trial: Trial) -> None:
    """Refuse a perturbation that yaw was not measured during or after: its strength would be anything."""
    seen, moved = trial.time[np.isfinite(trial.yaw)], trial.perturbation
    if isinstance(moved, Pulse) and (moved.onset >= seen[-1] or moved.onset + moved.duration <= seen[0]):
        raise InvalidInputError(
            f"{trial.name}: the pulse from {moved.onset / ms:.6g} to {(moved.onset + moved.duration) / ms:.6g} ms lies "
            f"outside the recording from {seen[0] / ms:.6g} to {seen[-1] / ms:.6g} ms; check the units and the start "
            "of the clock."
        )
    if isinstance(moved, TorqueTrace) and (moved.time[-1] <= seen[0] or moved.time[0] >= seen[-1]):
        raise InvalidInputError(
            f"{trial.name}: the trace of the drive and yaw share no time; check the units and the clocks."
        )


def fit_problem(trials: Sequence[Trial], model: GainModel) -> FitProblem:
    """Lay out the unknowns of a model for trials.

    Raises
    ------
    InvalidInputError
        If there is no trial or something else, two have one name, a perturbation lies outside its recording, or
        paddling was not measured where its gain is asked for.
    """
    _refuse_others(trials)
    for trial in trials:
        _refuse_outside(trial)
    names = [trial.name for trial in trials]
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        raise InvalidInputError(f"Two trials are named {twice!r}; give each recording a name of its own.")
    if "paddling_gain" in model.unknown and all(trial.paddling is None for trial in trials):
        raise InvalidInputError("paddling_gain is to be estimated, but no trial has paddling angles; map them.")
    layout: dict[tuple[str, str], int] = {}
    settings: list[Unknown] = []
    parts: list[TrialPart] = []
    order = sorted(model.unknown, key=lambda name: (model.unknown[name].shared == "trial", NAMES.index(name)))
    for trial in trials:
        mine = [name for name in order if _applies(name, trial)]
        places: list[int] = []
        for name in mine:
            key = (name, {"all": "", "fly": trial.fly, "trial": trial.name}[model.unknown[name].shared])
            if key not in layout:
                layout[key] = len(settings)
                settings.append(model.unknown[name])
            places.append(layout[key])
        parts.append(_part(trial, model, mine, places))
    return FitProblem(
        trials=tuple(trials),
        model=model,
        names=tuple(f"{name}[{owner}]" if owner else name for name, owner in layout),
        kinds=tuple(name for name, _ in layout),
        settings=tuple(settings),
        parts=tuple(parts),
    )


def _applies(name: str, trial: Trial) -> bool:
    """Whether a trial says anything of a parameter; a calibrated impulse needs no estimate."""
    if name == "paddling_gain":
        return trial.paddling is not None
    if name == "impulse":
        return trial.perturbation is not None and _calibrated(trial.perturbation) is None
    return name != "onset_shift" or trial.perturbation is not None


def _calibrated(perturbation: Pulse | TorqueTrace) -> float | None:
    if isinstance(perturbation, Pulse):
        return perturbation.angular_impulse
    return perturbation.angular_acceleration_per_unit


def _part(trial: Trial, model: GainModel, mine: Sequence[str], places: Sequence[int]) -> TrialPart:
    drive = drive_of(trial.perturbation)
    resting = parameter_vector({"delay": 1.0} | dict(model.known))
    if trial.perturbation is not None and "impulse" not in model.known:
        resting[_IMPULSE] = (_calibrated(trial.perturbation) or 0.0) * drive.size
    channels = [_channel("yaw", trial, trial.yaw)]
    if trial.paddling is not None and ("paddling_gain" in model.unknown or "paddling_gain" in model.known):
        channels.append(_channel("paddling", trial, trial.paddling))
    ends = np.concatenate([c.times[[0, -1]] for c in channels])
    return TrialPart(
        trial=trial, drive=drive, span=span_of(np.array([ends.min(), ends.max()]), drive),
        channels=tuple(channels), resting=resting,
        active=np.array([NAMES.index(name) for name in mine], dtype=np.int64),
        places=np.array(places, dtype=np.int64), grid=np.ix_(places, places),
    )  # fmt: skip


def _channel(kind: str, trial: Trial, values: FloatArray) -> Channel:
    there = np.isfinite(values)
    times = np.ascontiguousarray(trial.time[there])
    gaps = np.flatnonzero(np.diff(times) * trial.rate > _GAP) + 1
    return Channel(kind, times, np.ascontiguousarray(values[there]), np.concatenate([[0], gaps]).astype(np.int64))
