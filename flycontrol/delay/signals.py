"""Names of systems and signals, and the specifications that select signals, as python-control writes them."""

from __future__ import annotations

import re
import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Literal, TypeAlias, cast

from flycontrol.delay.convert import as_delay_lti
from flycontrol.delay.system import DelayLTI
from flycontrol.errors import InvalidParameterError

if TYPE_CHECKING:
    from flycontrol.delay.convert import Operand

#: "sys.sig", "-sys.sig", "sys", 0, (0, 1), ("sys", "sig", gain), (0, [1, 2]); "sig" also stands for "sig[0]",
#: "sig[1]", ... and "sig[1:3]" for some of them.
Spec: TypeAlias = "str | int | tuple[Any, ...]"
#: A signal's number among all those of its kind, and the gain that it is taken with.
Selected: TypeAlias = "tuple[int, float]"


def named(
    system: Operand, *, inputs: str | Sequence[str] = (), outputs: str | Sequence[str] = (), name: str = ""
) -> DelayLTI:
    """The system with new names for its inputs, its outputs and itself; what is left out stays as it was.

    One name for m > 1 signals is their base: "u" names them u[0], u[1], ..., as in python-control.

    Raises
    ------
    InvalidParameterError
        If there are not as many distinct names as signals.
    """
    given = as_delay_lti(system)
    return replace(
        given,
        input_names=_names(inputs, given.n_inputs) or given.input_names,
        output_names=_names(outputs, given.n_outputs) or given.output_names,
        name=name or given.name,
    )


def _names(names: str | Sequence[str], many: int) -> tuple[str, ...]:
    if isinstance(names, str):
        return (names,) if many == 1 else tuple(f"{names}[{i}]" for i in range(many))
    return tuple(names)


@dataclass(frozen=True, slots=True)
class Signals:
    """All inputs, or all outputs, of a list of systems, numbered through."""

    kind: Literal["input", "output"]
    systems: tuple[str, ...]  #: their names, "" for a system without
    labels: tuple[tuple[str, ...], ...]  #: names of the signals of each system

    def __len__(self) -> int:
        return sum(len(labels) for labels in self.labels)

    def flat(self) -> list[str]:
        """Names of all signals, without their systems."""
        return [label for labels in self.labels for label in labels]

    def ports(self, spec: Spec) -> list[list[Selected]]:
        """What a specification selects as ports of a whole; each port is one or several signals. Empty if nothing.

        A name without a system stands for that signal in every system; other specifications for one signal a port.
        """
        if not isinstance(spec, str) or "." in spec:
            return [[selected] for selected in self.find(spec)]
        name, gain = _sign(spec)
        self.refuse_twins(name)
        found: list[list[Selected]] = []
        first = 0
        for labels in self.labels:
            for k, i in enumerate(_matching(name, labels)):
                found[k:k] = [[]] if k == len(found) else []
                found[k].append((first + i, gain))
            first += len(labels)
        if found and name in self.systems:
            raise InvalidParameterError(
                f"{spec!r} is the name of a system and of an {self.kind}; write 'system.{name}'."
            )
        return found or [[selected] for selected in self.find(spec)]

    def refuse_twins(self, name: str) -> None:
        """Refuse a signal's name that several systems of one name bear: taken together they are rarely what was meant.

        Raises
        ------
        InvalidParameterError
            If there are such systems.
        """
        bearers = [system for system, labels in zip(self.systems, self.labels, strict=True) if _matching(name, labels)]
        twins = [system for system in bearers if system and bearers.count(system) > 1]
        if twins:
            raise InvalidParameterError(
                f"{len(twins)} systems called {twins[0]!r} have an {self.kind} {name!r}, and would silently share it; "
                "give them and their signals different names (see `named`), or select by number."
            )

    def find(self, spec: Spec) -> list[Selected]:
        """The signals that a specification with its system selects; empty if there is no such system or signal.

        Raises
        ------
        InvalidParameterError
            If the specification cannot be read, or several systems have that name.
        """
        system, signal, gain = _parsed(spec)
        if system and self.systems.count(system) > 1:
            raise InvalidParameterError(
                f"{spec!r} is ambiguous: {self.systems.count(system)} systems are called {system!r}; give them "
                "different names, or select by number."
            )
        number = self.systems.index(system) if system and system in self.systems else system
        if number not in range(len(self.systems)):
            return []
        labels, first = self.labels[number], sum(len(labels) for labels in self.labels[:number])
        wanted = range(len(labels)) if signal is None else signal if isinstance(signal, list) else [signal]
        groups = [_matching(one, labels) if isinstance(one, str) else [one] for one in wanted]
        if not all(groups) or any(i not in range(len(labels)) for group in groups for i in group):
            return []
        return [(first + i, gain) for group in groups for i in group]

    def full_name(self, signal: int) -> str:
        """'P.u', or "(0, 'u')" where the system has no name or shares it."""
        for k, labels in enumerate(self.labels):
            if signal < len(labels):
                system, label = self.systems[k], labels[signal]
                return f"{system}.{label}" if system and self.systems.count(system) == 1 else f"({k}, {label!r})"
            signal -= len(labels)
        raise IndexError(signal)

    def listed(self) -> str:
        """All full names, for a message."""
        return ", ".join(self.full_name(i) for i in range(len(self))) or "none"


def inputs_of(systems: Sequence[DelayLTI]) -> Signals:
    """All inputs; a system without names has u[0], u[1], ..."""
    labels = tuple(s.input_names or tuple(f"u[{i}]" for i in range(s.n_inputs)) for s in systems)
    return Signals("input", tuple(s.name for s in systems), labels)


def outputs_of(systems: Sequence[DelayLTI]) -> Signals:
    """All outputs; a system without names has y[0], y[1], ..."""
    labels = tuple(s.output_names or tuple(f"y[{i}]" for i in range(s.n_outputs)) for s in systems)
    return Signals("output", tuple(s.name for s in systems), labels)


def _parsed(spec: Spec) -> tuple[Any, Any, float]:
    """System, signal (None for all of them) and gain of a specification."""
    parts = tuple(spec.split(".")) if isinstance(spec, str) else spec if isinstance(spec, tuple) else (spec,)
    system, signal, gain = cast("tuple[Any, Any, Any]", (*parts, None, None, None)[:3])
    readable = (
        1 <= len(parts) <= (2 if isinstance(spec, str) else 3)
        and isinstance(system, str | int)
        and isinstance(signal, str | int | list | None)
        and isinstance(gain, int | float | None)
    )
    if not readable:
        raise InvalidParameterError(
            f"{spec!r} is no signal specification; write 'system.signal', '-system.signal', (system, signal) or "
            "(system, signal, gain), with names or numbers from 0."
        )
    system, sign = _sign(system)
    signal, other_sign = _sign(signal)
    return system, signal, sign * other_sign * (1.0 if gain is None else gain)


def _sign(name: Any) -> tuple[Any, float]:
    return (name[1:], -1.0) if isinstance(name, str) and name.startswith("-") else (name, 1.0)


def _matching(name: str, labels: Sequence[str]) -> list[int]:
    """Positions of the label `name`, or else of name[0], name[1], ..., or of name[i:j]."""
    if name in labels:
        return [labels.index(name)]
    parts = re.fullmatch(r"(.+?)(?:\[(\d*):(\d*)\])?", name)
    if parts is None:
        return []
    base, low, high = parts.groups()
    numbered = [(i, re.fullmatch(re.escape(base) + r"\[(\d+)\]", label)) for i, label in enumerate(labels)]
    wanted = range(int(low or 0), int(high) if high else sys.maxsize)
    return [i for i, number in numbered if number and int(number[1]) in wanted]
