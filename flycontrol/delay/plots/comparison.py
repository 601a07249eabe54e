"""What a plot draws side by side: exact results, and beside each its approximation."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Generic, TypeVar, cast

from flycontrol.delay.convert import as_delay_lti
from flycontrol.delay.pade import pade as pade_of
from flycontrol.delay.system import DelayLTI
from flycontrol.errors import InvalidParameterError

R = TypeVar("R")


@dataclass(frozen=True, slots=True, eq=False)
class Curve(Generic[R]):
    """A result to draw."""

    result: R
    label: str  #: "" to leave it out of the legend
    exact: bool
    series: int  #: number of the system in the plot
    alone: bool  #: whether it is the only one
    system: DelayLTI | None = None  #: what the result was computed from, if a system was given


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Beside:
    """What is drawn beside each exact result."""

    pade: int | None  #: order n of the [n/n] approximation of every delay
    approximation: Any  #: a system or a result, or a list with one for each
    label: str | Sequence[str] | None  #: of the exact results


def listed(data: Any) -> list[Any]:
    """Several systems or results, or one."""
    several = [*data] if isinstance(data, list | tuple) else [data]
    if not several:
        raise InvalidParameterError("There is nothing to draw: give a system or a result, or a list of these.")
    return several


def curves(data: Any, kind: type[R], compute: Callable[[DelayLTI], R], beside: Beside) -> list[Curve[R]]:
    """The result of every system in `data`, results taken as they are, each followed by its approximations.

    Raises
    ------
    InvalidParameterError
        If something is neither a system nor a result of this kind, or lists do not fit each other.
    """
    items, found = listed(data), list[Curve[R]]()
    labels = _labels(items, beside.label)
    approximations = [None] * len(items) if beside.approximation is None else listed(beside.approximation)
    if len(approximations) != len(items):
        raise InvalidParameterError(
            f"{len(items)} exact result(s) need as many approximations, got {len(approximations)}."
        )
    compared = beside.pade is not None or beside.approximation is not None
    alone = len(items) == 1
    for k, (item, label, other) in enumerate(zip(items, labels, approximations, strict=True)):
        result, system = _result(item, kind, compute)
        name = ", ".join(part for part in (label, "exact" if compared else "") if part)
        found.append(Curve(result, name, exact=True, series=k, alone=alone, system=system))
        for kept, words in _approximated(system, kind, beside.pade, other):
            near, source = _result(kept, kind, compute)
            name = ", ".join(part for part in (label, words) if part)
            found.append(Curve(near, name, exact=False, series=k, alone=alone, system=source))
    return found


def _labels(items: list[Any], label: str | Sequence[str] | None) -> list[str]:
    if label is None:
        names = [str(getattr(item, "name", "")) if isinstance(item, DelayLTI) else "" for item in items]
        return [name or ("" if len(items) == 1 else f"system {k + 1}") for k, name in enumerate(names)]
    labels = [label] if isinstance(label, str) else [*label]
    if len(labels) != len(items):
        raise InvalidParameterError(f"{len(items)} system(s) need as many labels, got {len(labels)}.")
    return labels


def _result(item: Any, kind: type[R], compute: Callable[[DelayLTI], R]) -> tuple[R, DelayLTI | None]:
    if isinstance(item, kind):
        return item, None
    system = as_delay_lti(item)
    return compute(system), system


def _approximated(system: DelayLTI | None, kind: type[Any], order: int | None, given: Any) -> list[tuple[Any, str]]:
    """Approximations, systems or results, and what they are called."""
    found: list[tuple[Any, str]] = []
    if order is not None:
        if system is None:
            raise InvalidParameterError(
                f"A {kind.__name__} holds no system that could be approximated: plot the system itself, or give the "
                "approximate result as `approximation`."
            )
        found.append((pade_of(system, order), pade_label(order)))
    if given is not None:
        found.append((given, str(getattr(given, "name", "")) if _named(given) else "approximation"))
    return found


def pade_label(order: int) -> str:
    """What a legend calls the [n/n] approximation."""
    return f"Padé [{order}/{order}]"


def _named(system: Any) -> bool:
    name = cast("object", getattr(system, "name", ""))
    return isinstance(name, str) and bool(name) and not name.startswith("sys[")
