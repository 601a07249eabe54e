"""Block diagrams: systems connected by the names of their signals."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, NoReturn, TypeAlias

import numpy as np

from flycontrol.delay.convert import as_delay_lti, static_gain
from flycontrol.delay.interconnect import append, connect
from flycontrol.delay.signals import Selected, Signals, Spec, inputs_of, named, outputs_of
from flycontrol.delay.system import DelayLTI, FloatArray
from flycontrol.errors import InvalidParameterError

if TYPE_CHECKING:
    from flycontrol.delay.convert import Operand

#: Row, column and value of a matrix entry; entries of one place add up.
_Entry: TypeAlias = "tuple[int, int, float]"
#: What one specification, or a list of them, selects as ports of the whole.
_Ports: TypeAlias = "list[list[Selected]]"


def interconnect(  # noqa: PLR0913 (python-control's arguments)
    syslist: Sequence[Operand],
    connections: list[Any] | None = None,
    inplist: Spec | list[Any] | None = None,
    outlist: Spec | list[Any] | None = None,
    *,
    inputs: str | Sequence[str] | None = None,
    outputs: str | Sequence[str] | None = None,
    check_unused: bool = True,
) -> DelayLTI:
    """Connect systems by the names of their signals, as python-control's `interconnect` does.

    Parameters
    ----------
    syslist
        Delay systems and systems of python-control, with names as given by `named` or there.
    connections
        Lists [input, output, output, ...]: the input becomes the sum of the outputs. Left out, every input takes the
        sum of all outputs of the same name. Several signals at once connect in order.
    inplist, outlist
        Inputs and outputs of the whole, by default the signals called as in `inputs` and `outputs`. A list in the list
        is one port: an input that feeds all of its signals, an output that is their sum. A name without a system means
        every signal of that name. Inputs can be read as outputs.
    inputs, outputs
        Names of the whole's inputs and outputs.
    check_unused
        Refuse inputs that are connected to nothing; otherwise they stay zero. Outputs may remain unused.

    Signals are specified as 'P.u', '-P.u', ('P', 'u', gain), (0, 1), 'P' or 0 (all signals of P) or 'P.u[0:2]'.

    Raises
    ------
    InvalidParameterError
        If a specification selects nothing, numbers of signals differ, or an input is connected to nothing.
    AlgebraicLoopError
        If an undelayed direct path around a loop has no unique solution.
    """
    systems = [as_delay_lti(system) for system in syslist]
    u, y = inputs_of(systems), outputs_of(systems)
    wires = _equal_names(u, y) if connections is None else _wires(u, y, connections)
    entries, input_names = _whole_ports([u], inplist, inputs)
    readings, output_names = _whole_ports([y, u], outlist, outputs)
    fed = [(i, k, gain) for k, port in enumerate(entries) for i, gain in port]
    read = [(k, i, gain) for k, port in enumerate(readings) for i, gain in port]
    if check_unused:
        _check_all_fed(u, {row for row, _, _ in [*wires, *fed]})
    F, G = _matrix(wires, len(u), len(y)), _matrix(fed, len(u), len(entries))
    H, of_inputs = np.split(_matrix(read, len(readings), len(y) + len(u)), [len(y)], axis=1)
    whole = connect(append(*systems), F, G, H + of_inputs @ F)
    direct = whole.D11 + of_inputs @ G  # an input u = F y + G v read as an output
    return replace(whole, D11=direct, input_names=input_names, output_names=output_names)


def summing_junction(
    inputs: str | Sequence[str], output: str = "y", dimension: int | None = None, name: str = ""
) -> DelayLTI:
    """output = sum of the inputs, those with a leading minus subtracted; for a dimension k each is a vector of k.

    Raises
    ------
    InvalidParameterError
        If names are not distinct or the dimension is not an integer >= 1.
    """
    if not (dimension is None or (isinstance(dimension, int) and dimension >= 1)):
        raise InvalidParameterError(f"The dimension of a summing junction must be an integer >= 1, got {dimension!r}.")
    signed = [inputs] if isinstance(inputs, str) else list(inputs)
    signs = [-1.0 if signal.startswith("-") else 1.0 for signal in signed]
    bare = [signal.removeprefix("-") for signal in signed]

    def spread(names: list[str]) -> list[str]:
        return names if dimension is None else [f"{base}[{i}]" for base in names for i in range(dimension)]

    junction = static_gain(np.kron(signs, np.eye(dimension or 1)))
    return named(junction, inputs=spread(bare), outputs=spread([output]), name=name)


def _equal_names(u: Signals, y: Signals) -> list[_Entry]:
    """Every input takes every output of its name."""
    bearers: dict[str, list[int]] = {}
    for o, label in enumerate(y.flat()):
        bearers.setdefault(label, []).append(o)
    wires = [(i, o, 1.0) for i, label in enumerate(u.flat()) for o in bearers.get(label, [])]
    for label in {u.flat()[i] for i, _, _ in wires}:
        y.refuse_twins(label)
    return wires


def _wires(u: Signals, y: Signals, connections: list[Any]) -> list[_Entry]:
    """The connections [input, output, ...], several signals in order."""
    one_alone = bool(connections) and all(isinstance(part, str | tuple | int) for part in connections)
    listed = [connections] if one_alone else connections
    wires: list[_Entry] = []
    for connection in listed:
        if not isinstance(connection, list) or not connection:
            raise InvalidParameterError(f"A connection is a list [input, output, ...], got {connection!r}.")
        target = u.find(connection[0]) or _refuse(connection[0], u)
        for spec in connection[1:]:
            source = y.find(spec) or _refuse(spec, y)
            if len(source) != len(target):
                raise InvalidParameterError(
                    f"{connection[0]!r} selects {len(target)} input(s) and {spec!r} {len(source)} output(s); a "
                    "connection needs equal numbers."
                )
            wires += [(i, o, gain * sign) for (i, gain), (o, sign) in zip(target, source, strict=True)]
    return wires


def _whole_ports(
    where: list[Signals], specs: Spec | list[Any] | None, names: str | Sequence[str] | None
) -> tuple[_Ports, tuple[str, ...]]:
    """Ports of the whole and their names; the names say what the ports are if specifications are left out."""
    listed = [names] if isinstance(names, str) else list(names or [])
    if specs is None:
        groups = [(name, _select(where, name)) for name in listed]
        labels = [label for signals in where for label in signals.flat()]
        found = [(name if len(ports) == 1 else labels[port[0][0]], port) for name, ports in groups for port in ports]
        return [port for _, port in found], tuple(name for name, _ in found)
    every = specs if isinstance(specs, list) else [specs]
    ports = [port for spec in every for port in _select(where, spec)]
    if isinstance(names, str) and len(ports) > 1:
        listed = [f"{names}[{k}]" for k in range(len(ports))]
    if listed and len(listed) != len(ports):
        raise InvalidParameterError(
            f"{specs!r} makes {len(ports)} {where[0].kind}(s), but there are {len(listed)} names."
        )
    return ports, tuple(listed)


def _select(where: list[Signals], spec: Spec | list[Spec]) -> _Ports:
    """Ports by specification among signals of the first kind, else of the next, which are numbered after them."""
    if isinstance(spec, list):
        return [[selected for one in spec for port in _select(where, one) for selected in port]]
    first = 0
    for signals in where:
        found = signals.ports(spec)
        if found:
            return [[(first + i, gain) for i, gain in port] for port in found]
        first += len(signals)
    return _refuse(spec, *where)


def _refuse(spec: Spec, *where: Signals) -> NoReturn:
    there_are = "; ".join(f"the {signals.kind}s are {signals.listed()}" for signals in where)
    raise InvalidParameterError(f"{spec!r} selects no {' or '.join(signals.kind for signals in where)}; {there_are}.")


def _check_all_fed(u: Signals, fed: set[int]) -> None:
    idle = [u.full_name(i) for i in range(len(u)) if i not in fed]
    if idle:
        raise InvalidParameterError(
            f"Input {', '.join(idle)} is connected to nothing; connect it, make it an input of the whole, or hold it "
            "at zero with check_unused=False."
        )


def _matrix(entries: Iterable[_Entry], rows: int, columns: int) -> FloatArray:
    matrix = np.zeros((rows, columns))
    for row, column, value in entries:
        matrix[row, column] += value
    return matrix
