"""The verdict in words: stable or not, how far from not, how fast, and what proportional control alone would need."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flycontrol.delay.margins import Margins
from flycontrol.model.parameters import Parameters
from flycontrol.model.stability import Mode
from flycontrol.model.study import DampingRow, StabilityStudy
from flycontrol.report.numbers import brief, degrees, fixed, milliseconds, root

_DB = 20.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Finding:
    """One line of the verdict's table."""

    quantity: str
    value: str  #: with its unit
    meaning: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Verdict:
    """What the report says first."""

    word: str  #: "stable" or "unstable"
    sentences: tuple[str, ...]
    findings: tuple[Finding, ...]


def verdict(study: StabilityStudy, parameters: Parameters) -> Verdict:
    """Say what the study found."""
    result = study.result
    frequency = parameters.wingbeat_frequency.value
    findings = [
        *_margin_findings(result.margins, result.loop.delay, frequency),
        *_mode_findings(result.modes),
        _recovery_finding(study, frequency),
        _proportional_finding(study, parameters),
    ]
    return Verdict(
        word="stable" if result.stable else "unstable",
        sentences=_sentences(study, parameters),
        findings=tuple(findings),
    )


def own_row(study: StabilityStudy) -> DampingRow | None:
    """Best P and PD at the loop's own damping."""
    own = study.result.loop.plant.damping_rate
    rows = [row for row in study.damping_table if abs(row.b - own) <= 0.02 * own]
    return min(rows, key=lambda row: abs(row.b - own)) if rows else None


def _sentences(study: StabilityStudy, parameters: Parameters) -> tuple[str, ...]:
    result, margins = study.result, study.result.margins
    if margins is None:
        growth = result.poles[0]
        if abs(growth.real) < 1e-9 * max(1.0, abs(growth)):
            return (
                f"The yaw loop of {parameters.name} is not asymptotically stable.",
                f"Its rightmost pole, {root(complex(growth))} 1/s, lies on the imaginary axis: a deflection neither "
                "grows nor dies away; margins and a recovery time do not exist.",
            )
        return (
            f"The yaw loop of {parameters.name} is unstable.",
            f"Its rightmost pole, {root(complex(growth))} 1/s, makes any deflection grow by a factor e every "
            f"{milliseconds(1 / growth.real)}; margins and a recovery time do not exist.",
        )
    wingbeats = parameters.wingbeat_frequency.value
    first = f"The yaw loop of {parameters.name} is stable."
    second = (
        f"It stays so up to gains {fixed(margins.gain_margin, 2)} times as high, up to a reaction "
        f"{milliseconds(margins.delay_margin)} later, or up to {degrees(margins.phase_margin)} more phase lag at its "
        f"crossover of {fixed(float(margins.gain_crossovers[-1]), 1)} rad/s."
        if len(margins.gain_crossovers)
        else "Its loop gain never reaches 1, so no added lag or delay makes it unstable."
    )
    if result.recovery_time is None:
        return first, second, result.reason or ""
    third = (
        f"After a pulse of {milliseconds(result.task.duration)} that turns it by {degrees(result.task.peak, 0)} it is "
        f"back within ±{degrees(result.task.tolerance, 0)} in {milliseconds(result.recovery_time)}, "
        f"{fixed(result.recovery_time * wingbeats, 1)} wingbeats after pulse onset."
    )
    return first, second, third


def _margin_findings(margins: Margins | None, delay: float, frequency: float) -> list[Finding]:
    if margins is None:
        names = ("Gain margin", "Phase margin", "Delay margin", "Modulus margin")
        return [Finding(quantity=name, value=fixed(None), meaning="none: the loop is unstable") for name in names]
    peak = 1.0 / margins.modulus_margin
    return [
        Finding(
            quantity="Gain margin",
            value=f"{fixed(margins.gain_margin, 2)} ({fixed(_DB * float(np.log10(margins.gain_margin)), 1, 'dB')})",
            meaning="both gains may grow by this factor",
        ),
        Finding(
            quantity="Phase margin", value=degrees(margins.phase_margin),
            meaning=f"lag left at the gain crossover, {_frequencies(margins)}",
        ),
        Finding(
            quantity="Delay margin", value=milliseconds(margins.delay_margin),
            meaning=f"{fixed(margins.delay_margin * frequency, 1)} wingbeats more; the largest stable delay is "
            f"{milliseconds(delay + margins.delay_margin)}",
        ),
        Finding(
            quantity="Modulus margin", value=fixed(margins.modulus_margin, 3),
            meaning=f"distance of L(jω) from −1, at {fixed(margins.modulus_frequency, 0, 'rad/s')}; "
            f"disturbances are amplified at most {fixed(peak, 2)} times (Ms)",
        ),
    ]  # fmt: skip


def _frequencies(margins: Margins) -> str:
    return ", ".join(fixed(float(w), 1, "rad/s") for w in margins.gain_crossovers) or "which does not exist"


def _mode_findings(modes: list[Mode]) -> list[Finding]:
    slowest, fastest = modes[0], modes[-1]
    return [
        _mode_finding("Growing mode" if slowest.root.real > 0 else "Slowest mode", slowest),
        _mode_finding(f"Fastest of the {len(modes)} listed modes", fastest),
    ]


def _mode_finding(name: str, mode: Mode) -> Finding:
    turns = (
        f"{fixed(mode.frequency, 1, 'Hz')}, damping ratio {fixed(mode.damping_ratio, 2)}" if mode.frequency else "real"
    )
    if np.isinf(mode.time_constant):
        return Finding(
            quantity=name, value=root(mode.root) + "\N{NO-BREAK SPACE}1/s", meaning="neither grows nor decays"
        )
    time = f"time constant {milliseconds(mode.time_constant)}" if mode.root.real < 0 else (
        f"grows by a factor e in {milliseconds(-mode.time_constant)}"
    )  # fmt: skip
    return Finding(quantity=name, value=root(mode.root) + "\N{NO-BREAK SPACE}1/s", meaning=f"{time}, {turns}")


def _recovery_finding(study: StabilityStudy, frequency: float) -> Finding:
    result = study.result
    name = f"Recovery from {degrees(result.task.peak, 0)} to ±{degrees(result.task.tolerance, 0)}"
    if result.recovery_time is None:
        return Finding(quantity=name, value=fixed(None), meaning=result.reason or "")
    kept = "within" if result.recovery_time < study.deadline else "later than"
    return Finding(
        quantity=name, value=milliseconds(result.recovery_time),
        meaning=f"{fixed(result.recovery_time * frequency, 1)} wingbeats; {kept} the {brief(study.deadline)} that it "
        "is held against",
    )  # fmt: skip


def _proportional_finding(study: StabilityStudy, parameters: Parameters) -> Finding:
    name, row = "Best proportional control alone", own_row(study)
    value = milliseconds(row.proportional.recovery_time) if row else fixed(None)
    return Finding(quantity=name, value=value, meaning=proportional_sentence(study, parameters))


def proportional_sentence(study: StabilityStudy, parameters: Parameters) -> str:
    """What proportional control alone does and would need, after the words "P alone"."""
    deadline, need = brief(study.deadline), study.proportional_suffices_from
    low, high = parameters.damping_low.value, parameters.damping_high.value
    row = own_row(study)
    met = ""
    if row is not None:
        met = f"{'meets' if row.proportional.recovery_time <= study.deadline else 'misses'} {deadline}; "
    if need is None:
        return f"{met}no damping that was searched makes it just meet {deadline}"
    if need > high:
        where = f"above the range of {low:.0f} to {high:.0f} 1/s"
    elif need < low:
        where = f"below the range of {low:.0f} to {high:.0f} 1/s"
    else:
        where = f"inside the range of {low:.0f} to {high:.0f} 1/s"
    return f"{met}to meet it takes a yaw damping β/I of at least {need:.0f} 1/s, {where}"
