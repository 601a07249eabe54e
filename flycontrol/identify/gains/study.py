"""Everything that a fit report shows, computed once: the fit, its intervals, flies apart, other controllers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import partial
from typing import Any, cast

import numpy as np

from flycontrol.errors import FlycontrolError
from flycontrol.identify.gains.alone import By, LoneFit, fits_alone
from flycontrol.identify.gains.bootstrap import Bootstrap, Resampling, bootstrap
from flycontrol.identify.gains.consequences import Consequences, consequences
from flycontrol.identify.gains.design import TradeOff, trade_offs
from flycontrol.identify.gains.fit import fit_gains
from flycontrol.identify.gains.homogeneity import Homogeneity, homogeneity
from flycontrol.identify.gains.least_squares import Loss, Minimum, WeightedProblem
from flycontrol.identify.gains.left_out import Prediction, leave_one_out
from flycontrol.identify.gains.model import GainModel
from flycontrol.identify.gains.outliers import Outlier, outliers
from flycontrol.identify.gains.profile import Profile, profile
from flycontrol.identify.gains.random_effects import RandomEffects, random_effects
from flycontrol.identify.gains.recording_fits import RecordingFit, recording_fits
from flycontrol.identify.gains.recovery_band import RecoveryAgainstStrength, recovery_against_strength
from flycontrol.identify.gains.result import FitResult
from flycontrol.identify.gains.ridge import Ridge, blind_pair, ridge
from flycontrol.identify.gains.selection import ControllerComparison, Validation, compare_controllers
from flycontrol.identify.gains.stages import Stages, identity_of
from flycontrol.identify.gains.uncertainty import LocalUncertainty
from flycontrol.jobs.packed import Result
from flycontrol.jobs.work import Work
from flycontrol.model.gain_plane import GainPlane, gain_plane
from flycontrol.model.gains import PulseTask
from flycontrol.model.stability import StabilityResult, assess
from flycontrol.model.trial import Pulse, Trial
from flycontrol.units import deg, ms

_NOMINAL = PulseTask(duration=4.5 * ms, peak=20 * deg, tolerance=2 * deg)
_DRAWS = 400  #: loops from the estimates' distribution
_MOST_FOR_A_RIDGE = 4  #: recordings, since each point of it is a fit to all


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Group:
    """Flies, or recordings, fitted one by one, and how they differ."""

    fits: tuple[LoneFit, ...]
    homogeneity: Homogeneity | None = None  #: None where fewer than two could be fitted
    effects: tuple[RandomEffects, ...] = ()  #: mean and spread of each shared unknown
    outliers: tuple[Outlier, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FitStudy:
    """A `FitResult` and what surrounds it; what cannot be had is None or empty, and `absent` says why."""

    result: FitResult
    recordings: tuple[RecordingFit, ...]
    profiles: Mapping[str, Profile]  #: of the unknowns that all recordings share
    flies: Group | None  #: None for one fly
    single: Group | None  #: recordings one by one; None for one recording
    predictions: tuple[Prediction, ...]  #: each recording from the others
    comparison: ControllerComparison | None
    bootstrap: Bootstrap | None  #: None where none was asked for
    recovery: RecoveryAgainstStrength | None  #: measured beside predicted
    stability: StabilityResult | None  #: of the fitted loop; None where flies differ
    consequences: Consequences | None  #: of the intervals for margins, poles and recovery
    plane: GainPlane | None  #: all gains at the fitted damping and delay
    trade_offs: tuple[TradeOff, ...]  #: strongest first
    ridge: Ridge | None  #: where the data cannot tell two unknowns apart; None where they can
    seed: int
    absent: Mapping[str, str] = field(default_factory=dict[str, str])  #: sentences by part


@dataclass(frozen=True, slots=True, kw_only=True)
class FitOptions:
    """How a study fits, and what it looks at besides."""

    noise: str | int = "auto"
    loss: Loss = "linear"
    level: float = 0.95
    seed: int = 0
    bootstrap: int = 0  #: fits to data drawn anew
    resampling: Resampling = "parametric"
    task: PulseTask = _NOMINAL  #: that recovery is measured by
    compare: bool = True  #: P, PD, PI and PID


def fit_study(
    trials: Sequence[Trial],
    model: GainModel,
    options: FitOptions | None = None,
    stages: Stages | None = None,
    *,
    flies: Group | None = None,
) -> FitStudy:
    """Fit a model to trials and look at the fit from all sides.

    Parameters
    ----------
    trials, model
        As of `fit_gains`.
    options
        How to fit.
    stages
        Workers, folder for finished parts, progress; the result does not depend on them.
    flies
        `group_of` the same trials by fly, if it is known already.

    Raises
    ------
    InvalidInputError
        If the trials and the model do not fit each other.
    OutputError
        If finished parts cannot be kept.
    """
    return _Study(trials, model, options or FitOptions(), stages or Stages(), flies).run()


def group_of(trials: Sequence[Trial], model: GainModel, by: By, options: FitOptions, stages: Stages) -> Group:
    """Each fly, or each recording, fitted alone with the others left out, and how they differ."""
    identity = identity_of(trials, model, options.noise, options.loss, options.level)
    fits = fits_alone(
        trials, model, by=by, noise=options.noise, loss=options.loss, labour=stages.labour(f"fits-by-{by}", identity)
    )
    usable = [fit for fit in fits if fit.usable]
    if len(usable) < 2:
        return Group(fits=fits, outliers=outliers(fits))
    return Group(
        fits=fits,
        homogeneity=homogeneity(trials, model, fits, options.loss),
        effects=tuple(random_effects(fits, kind, options.level) for kind in usable[0].kinds),
        outliers=outliers(fits),
    )


class _Study:
    """The parts in their order, and the sentences of those that could not be had."""

    def __init__(
        self, trials: Sequence[Trial], model: GainModel, options: FitOptions, stages: Stages, flies: Group | None
    ) -> None:
        self.known = {"fly": flies}
        self.trials, self.model, self.options, self.stages = trials, model, options, stages
        self.identity = identity_of(trials, model, options.noise, options.loss, options.level)
        self.absent: dict[str, str] = {}
        self.pooled = all(unknown.shared != "fly" for unknown in model.unknown.values()) and any(
            unknown.shared == "all" for unknown in model.unknown.values()
        )

    def run(self) -> FitStudy:
        options = self.options
        self.stages.progress(0, 1, "fitting all recordings")
        result = fit_gains(self.trials, self.model, noise=options.noise, loss=options.loss, level=options.level)
        self.stages.progress(1, 1, "fitting all recordings")
        return FitStudy(
            result=result,
            recordings=recording_fits(result),
            profiles=self._profiles(result),
            flies=self._group("fly", len({trial.fly for trial in self.trials})),
            single=self._group("recording", len(self.trials)),
            predictions=self._predictions(result),
            comparison=self._comparison(result),
            bootstrap=self._bootstrap(result),
            recovery=self._recovery(result),
            stability=self._stability(result),
            consequences=self._consequences(result),
            plane=self._plane(result),
            trade_offs=() if result.found_nothing else trade_offs(result),
            ridge=self._ridge(result),
            seed=options.seed,
            absent=self.absent,
        )

    def _profiles(self, result: FitResult) -> dict[str, Profile]:
        names = [e.name for e in result.estimates if e.name == e.kind and np.isfinite(e.value)]
        if not result.converged or len(result.uncertainty.unidentifiable):
            self.absent["profiles"] = f"No profiles are drawn, since the fit is {result.status}"
            return {}
        task = partial(
            _profile, weighted=result.weighted, minimum=result.minimum, uncertainty=result.uncertainty,
            level=result.level,
        )  # fmt: skip
        work = Work(task=task, items=names, seed=0, chunk=1, name="profiles")
        found = self.stages.labour("profiles", self.identity).done(work)
        return {name: Profile(**cast("dict[str, Any]", each)) for name, each in zip(names, found, strict=True)}

    def _group(self, by: By, count: int) -> Group | None:
        if count < 2 or not self.pooled:
            return None
        group = self.known.get(by) or group_of(self.trials, self.model, by, self.options, self.stages)
        if group.homogeneity is None:
            usable = sum(fit.usable for fit in group.fits)
            self.absent[by] = f"Only {usable} of {count} could be fitted alone, so they are not compared."
        return group

    def _predictions(self, result: FitResult) -> tuple[Prediction, ...]:
        if len(self.trials) < 2 or not self.pooled or not result.converged:
            return ()
        return leave_one_out(result, labour=self.stages.labour("left-out", self.identity))

    def _comparison(self, result: FitResult) -> ControllerComparison | None:
        if not self.options.compare:
            self.absent["comparison"] = "P, PD, PI and PID were not compared; --compare asks for it."
        if not (self.options.compare and result.converged and self.pooled):
            return None
        validation = Validation() if len(self.trials) == 1 else None  # several: recordings left out say it already
        try:
            return compare_controllers(
                self.trials, self.model, noise=self.options.noise, validation=validation, labour=self.stages.unkept()
            )
        except FlycontrolError as error:
            self.absent["comparison"] = str(error)
            return None

    def _bootstrap(self, result: FitResult) -> Bootstrap | None:
        options = self.options
        if options.bootstrap < 2:
            return None
        if result.found_nothing or not result.converged:
            self.absent["bootstrap"] = "No data were drawn anew, since the fit says nothing of the loop."
            return None
        identity = f"{self.identity} {options.resampling}"
        return bootstrap(
            result, options.bootstrap, kind=options.resampling, seed=options.seed,
            labour=self.stages.labour("bootstrap", identity),
        )  # fmt: skip

    def _recovery(self, result: FitResult) -> RecoveryAgainstStrength | None:
        if not result.usable:
            if any(trial.perturbation is not None for trial in self.trials):
                self.absent["recovery"] = (
                    "Measured recovery times are not set beside a prediction, since the estimates cannot be used."
                )
            return None
        try:
            return recovery_against_strength(result, seed=self.options.seed, level=result.level)
        except FlycontrolError as error:
            self.absent["recovery"] = str(error)
            return None

    def _stability(self, result: FitResult) -> StabilityResult | None:
        if not self.pooled:
            self.absent["stability"] = (
                "Loops were fitted apart, so there is no one loop whose margins could stand here; "
                "fit the recordings of one fly to see its own."
            )
        if not self._has_one_loop(result):
            return None
        try:
            return assess(result.loop(), self._task())
        except FlycontrolError as error:
            self.absent["stability"] = str(error)
            return None

    def _consequences(self, result: FitResult) -> Consequences | None:
        if not self._has_one_loop(result):
            return None
        try:
            return consequences(result, self._task(), _DRAWS, seed=self.options.seed)
        except FlycontrolError as error:
            self.absent["consequences"] = str(error)
            return None

    def _ridge(self, result: FitResult) -> Ridge | None:
        pair = blind_pair(result.weighted, result.minimum)
        if pair is None or not result.status.startswith("not identifiable"):
            return None
        if len(self.trials) > _MOST_FOR_A_RIDGE:
            self.absent["ridge"] = (
                f"What the data cannot tell apart is drawn for at most {_MOST_FOR_A_RIDGE} recordings; fit some alone."
            )
            return None
        one, other = (profile(result.weighted, result.minimum, result.uncertainty, name, result.level) for name in pair)
        return ridge(result.weighted, result.minimum, (one, other), labour=self.stages.labour("ridge", self.identity))

    def _has_one_loop(self, result: FitResult) -> bool:
        if self.pooled and not result.usable:
            self.absent["stability"] = (
                "What these gains mean for margins, modes and recovery is left out, since the estimates cannot be used."
            )
        return self.pooled and result.usable

    def _task(self) -> PulseTask:
        """The nominal recovery, from pulses as long as those of the recordings."""
        pulse = next((trial.perturbation for trial in self.trials if isinstance(trial.perturbation, Pulse)), None)
        return self.options.task if pulse is None else replace(self.options.task, duration=pulse.duration)

    def _plane(self, result: FitResult) -> GainPlane | None:
        if not (self.pooled and result.controller in ("P", "PD") and np.isfinite(result.value("kp"))):
            return None
        try:
            return gain_plane(result.loop())
        except FlycontrolError as error:
            self.absent["plane"] = str(error)
            return None


def _profile(
    name: str,
    rng: np.random.Generator,
    *,
    weighted: WeightedProblem,
    minimum: Minimum,
    uncertainty: LocalUncertainty,
    level: float,
) -> Result:
    """One profile as the fields of a `Profile`."""
    del rng
    found = profile(weighted, minimum, uncertainty, name, level)
    return {each.name: getattr(found, each.name) for each in fields(found)}
