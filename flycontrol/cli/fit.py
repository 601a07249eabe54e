"""`flycontrol fit`: recordings of perturbed flies in, gains with intervals and a report out."""

from __future__ import annotations

import time
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from flycontrol.cli.fit_command import typed_command
from flycontrol.cli.fit_options import FitRequest, requested_model, requested_sharing
from flycontrol.cli.fit_reporting import listed, report_of
from flycontrol.cli.terminal import kept_when_interrupted, progress_bar, refusal_with_a_mapping_to_edit, say
from flycontrol.errors import InvalidInputError

if TYPE_CHECKING:
    from flycontrol.identify.gains.study import FitOptions
    from flycontrol.model.trial import Trial

_COMPARED = 8  #: recordings, of which four controllers are fitted within a minute
_FEW = 4  #: recordings that are done before other processes have started
_OUT = Path("reports/fit")
#: What options are unless they are typed; those not named here are None.
_LEFT_OUT = {"controller": "PD", "shared": "auto", "noise": "auto", "loss": "linear", "level": 0.95, "seed": 0,
             "bootstrap": 200, "spontaneous": False}  # fmt: skip
_OF_A_PULSE = ("impulse", "onset_shift")


def fit(
    files: Annotated[
        list[str], typer.Argument(metavar="FILE...", help="Recordings of perturbed flies, or patterns as flies/*.csv.")
    ],
    mapping: Annotated[
        str | None,
        typer.Option(
            metavar="FILE",
            help="What the files hold, in TOML; left out: what the first one holds is printed, with a mapping to edit.",
        ),
    ] = None,
    controller: Annotated[str, typer.Option(metavar="P|PD|PI|PID", help="On the yaw angle.")] = "PD",
    fix: Annotated[
        list[str] | None, typer.Option(metavar="NAME=VALUE", help='Take for known, as damping="69 1/s"; repeat.')
    ] = None,
    estimate: Annotated[
        list[str] | None, typer.Option(metavar="NAME", help="Estimate too: onset_shift, limit, ki; repeat.")
    ] = None,
    prior: Annotated[
        list[str] | None, typer.Option(metavar="NAME=VALUE", help='Known roughly, as damping="69 +- 5 1/s"; repeat.')
    ] = None,
    bound: Annotated[
        list[str] | None, typer.Option(metavar="NAME=ENDS", help='Search inside, as delay="5 ms .. 30 ms"; repeat.')
    ] = None,
    shared: Annotated[
        str,
        typer.Option(
            metavar="auto|all|fly|trial",
            help="Whose gains, delay and damping are the same; auto: those of all, unless the flies differ.",
        ),
    ] = "auto",
    noise: Annotated[
        str, typer.Option(metavar="auto|white|ORDER", help="Autoregressive order of the residuals.")
    ] = "auto",
    loss: Annotated[
        str, typer.Option(metavar="linear|huber", help="huber where single samples may be far off.")
    ] = "linear",
    level: Annotated[float, typer.Option(metavar="NUMBER", help="Of the intervals.")] = 0.95,
    seed: Annotated[int, typer.Option(min=0, help="Of everything drawn at random.")] = 0,
    bootstrap: Annotated[
        int, typer.Option(min=0, metavar="NUMBER", help="Fits to data drawn anew, for the fly's cloud; 0: none.")
    ] = 200,
    compare: Annotated[
        bool | None,
        typer.Option(
            "--compare/--no-compare",
            help=f"Fit P, PD, PI and PID and compare; left out: for up to {_COMPARED} recordings.",
        ),
    ] = None,
    spontaneous: Annotated[
        bool, typer.Option("--spontaneous", help="Nothing perturbed the fly; otherwise an unknown pulse is sought.")
    ] = False,
    workers: Annotated[
        int | None, typer.Option(min=1, metavar="NUMBER", help="Processes; left out: one on every core.")
    ] = None,
    parameters: Annotated[
        str | None,
        typer.Option(
            metavar="FILE", help="Inertia and wingbeat of the fly, in TOML, or a shipped name, for the report."
        ),
    ] = None,
    out: Annotated[
        Path | None, typer.Option(metavar="DIR", help=f"Folder for the report; {_OUT} unless --json is given.")
    ] = None,
    json: Annotated[bool, typer.Option("--json", help="Print result.json on standard output.")] = False,
) -> None:
    """Fit gains and delay of the yaw reflex to recordings of perturbed flies, with intervals, and write a report.

    Parameters are kp, kd, ki (gains over inertia), delay, damping, limit, impulse, onset_shift, initial_yaw,
    initial_rate, heading and paddling_gain.

    Example: flycontrol fit demo/*.csv --mapping demo/mapping.toml
    """
    from flycontrol.io.parameters import read_parameters
    from flycontrol.jobs.files import require_writable_folder

    started = time.perf_counter()
    folder = _OUT if out is None and not json else out
    if folder is not None:
        require_writable_folder(folder)
    if mapping is None:
        raise refusal_with_a_mapping_to_edit(Path(files[0]))
    asked = {
        "mapping": mapping, "controller": controller, "fix": fix, "estimate": estimate, "prior": prior, "bound": bound,
        "shared": shared, "noise": noise, "loss": loss, "level": level, "seed": seed, "bootstrap": bootstrap,
        "compare": compare, "spontaneous": spontaneous, "parameters": parameters,
    }  # fmt: skip
    command = typed_command(files, asked, _LEFT_OUT)
    options = replace(_options(noise, loss, level, seed), bootstrap=bootstrap)
    request = FitRequest(
        controller=controller, fix=fix or (), estimate=estimate or (), prior=prior or (), bound=bound or (),
    )  # fmt: skip
    if spontaneous:
        _refuse_options_of_a_pulse(request)
    sharing = requested_sharing(shared)
    requested_model(request, paddling=False)  # refuse before hundreds of files are read
    fly = read_parameters(parameters)
    from flycontrol.identify.gains.apart import study_of
    from flycontrol.identify.gains.stages import Stages
    from flycontrol.io.trials import read_trials
    from flycontrol.jobs.processes import ProcessPool

    with progress_bar() as progress, ExitStack() as stack:
        trials = read_trials(files, mapping, progress=progress)
        trials, request = _with_pulses(trials, request, spontaneous=spontaneous)
        model = requested_model(request, paddling=any(trial.paddling is not None for trial in trials))
        options = replace(options, compare=len(trials) <= _COMPARED if compare is None else compare)
        pool = ProcessPool(workers)
        crew = 1 if pool.count == 1 or len(trials) < _FEW else stack.enter_context(pool)
        kept = None if folder is None else folder / "unfinished"
        stages = Stages(workers=crew, folder=kept, progress=progress)
        with kept_when_interrupted(kept):
            found = study_of(trials, model, options, stages, sharing)
            report = report_of(found, command)
            where = "done"
            if folder is not None:
                where = f"wrote {listed(report, report.write(fly, folder, progress))}"
                stages.clear()
    if json:
        typer.echo(report.json(), nl=False)
    say(f"{report.status} {where} in {time.perf_counter() - started:.1f} s")
    if report.summary:
        say(report.summary)


def _with_pulses(
    trials: tuple[Trial, ...], request: FitRequest, *, spontaneous: bool
) -> tuple[tuple[Trial, ...], FitRequest]:
    """Seek the pulse where the mapping names no perturbation; its onset is then estimated too."""
    from flycontrol.identify.gains.onset import with_located_pulses

    if spontaneous:
        _refuse_pulses(trials)
    if spontaneous or all(trial.perturbation is not None for trial in trials):
        return trials, request
    asked = request.estimate
    if "onset_shift" not in (*asked, *(text.partition("=")[0] for text in request.fix)):
        asked = (*asked, "onset_shift")
    return with_located_pulses(trials), replace(request, estimate=asked)


def _refuse_pulses(trials: tuple[Trial, ...]) -> None:
    moved = next((trial for trial in trials if trial.perturbation is not None), None)
    if moved is not None:
        raise InvalidInputError(
            f"--spontaneous says that nothing perturbed the fly, but the mapping gives {moved.name} a perturbation; "
            "leave --spontaneous out, or take [perturbation] out of the mapping."
        )


def _refuse_options_of_a_pulse(request: FitRequest) -> None:
    """Nothing that describes a pulse means anything where there is none."""
    for option in ("fix", "estimate", "prior", "bound"):
        for text in getattr(request, option):
            name = text.partition("=")[0].strip()
            if name in _OF_A_PULSE:
                raise InvalidInputError(
                    f"--spontaneous says that nothing perturbed the fly, but --{option} names the {name} of a pulse; "
                    "leave one of them out."
                )


def _options(noise: str, loss: str, level: float, seed: int) -> FitOptions:
    from flycontrol.identify.gains.study import FitOptions

    if not (noise in ("auto", "white") or (noise.isdecimal() and int(noise) <= 12)):
        raise InvalidInputError(f"--noise must be auto, white or an order from 0 to 12, got '{noise}'.")
    if not 0 < level < 1:
        raise InvalidInputError(f"--level must lie between 0 and 1, got {level:g}.")
    kind = int(noise) if noise.isdecimal() else noise
    for known in ("linear", "huber"):
        if loss == known:
            return FitOptions(noise=kind, loss=known, level=level, seed=seed)
    raise InvalidInputError(f"--loss must be linear or huber, got '{loss}'.")
