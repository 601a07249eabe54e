"""To and from what is no `DelayLTI`: numbers, gain matrices, and systems of python-control."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
import scipy.linalg
from numpy.typing import ArrayLike

from flycontrol.delay.balance import balance
from flycontrol.delay.system import DelayLTI, FloatArray
from flycontrol.errors import InvalidParameterError

if TYPE_CHECKING:
    import control

    #: What operators and connections accept.
    Operand: TypeAlias = DelayLTI | float | FloatArray | control.StateSpace | control.TransferFunction


def as_delay_lti(system: object) -> DelayLTI:
    """A number, a gain matrix (p, m), or a StateSpace or TransferFunction of python-control as a `DelayLTI`.

    Raises
    ------
    InvalidParameterError
        If it is none of these, or improper, in discrete time, complex or not finite.
    """
    if isinstance(system, DelayLTI):
        return system
    if isinstance(system, int | float | complex | np.number | np.ndarray):
        return static_gain(system)
    if "control" in sys.modules:  # nothing can be of python-control's types before its import, which takes a second
        import control

        if isinstance(system, control.InputOutputSystem):
            return from_control(system)
    raise InvalidParameterError(
        "A delay system combines with delay systems, numbers, gain matrices (2-D arrays), and StateSpace or "
        f"TransferFunction of python-control, got {type(system).__name__}."
    )


def static_gain(matrix: ArrayLike) -> DelayLTI:
    """y = D u for a real number or a matrix (p, m), without states or delays.

    Raises
    ------
    InvalidParameterError
        If it is not a number or a 2-D array of finite real numbers.
    """
    gain = np.asarray(matrix)
    if gain.ndim not in (0, 2) or gain.dtype.kind not in "buif":
        raise InvalidParameterError(
            f"A gain must be a real number or a 2-D array of real numbers, got {gain.dtype} of shape {gain.shape}."
        )
    D = np.array(gain, dtype=np.float64, ndmin=2)
    return delay_free(np.zeros((0, 0)), np.zeros((0, D.shape[1])), np.zeros((D.shape[0], 0)), D)


def delay_free(A: FloatArray, B: FloatArray, C: FloatArray, D: FloatArray) -> DelayLTI:
    """x' = A x + B u, y = C x + D u, as a `DelayLTI` without delay channels."""
    n, m, p = A.shape[0], B.shape[1], C.shape[0]
    zero = np.zeros
    return DelayLTI(A, B, zero((n, 0)), C, zero((0, n)), D, zero((p, 0)), zero((0, m)), zero((0, 0)), zero(0))


def from_control(system: control.InputOutputSystem) -> DelayLTI:
    """A delay-free `DelayLTI` from python-control's continuous-time StateSpace or TransferFunction, names included.

    Raises
    ------
    InvalidParameterError
        If the system is in discrete time, improper, or of another kind.
    """
    import control

    if isinstance(system, control.FRD):
        raise InvalidParameterError(
            "Frequency response data hold a system at some frequencies only and cannot be part of a delay system; "
            "combine the numbers instead: evaluate the delay system at 1j * frd.omega."
        )
    if not isinstance(system, control.StateSpace | control.TransferFunction):
        raise InvalidParameterError(
            f"Only StateSpace and TransferFunction can be converted, got {type(system).__name__}; linearise it first."
        )
    if system.dt not in (0, None):
        raise InvalidParameterError(f"Only continuous-time systems can be converted, got dt = {system.dt!r}.")
    if isinstance(system, control.TransferFunction):
        converted = _realised(system)
    else:
        A, B, C, D = (np.array(getattr(system, block), dtype=np.float64) for block in "ABCD")
        converted = delay_free(A, B, C, D)
    return replace(
        converted,
        input_names=_given_names(system.input_labels, "u"),
        output_names=_given_names(system.output_labels, "y"),
        name="" if system.name.startswith("sys[") else system.name,
    )


def to_statespace(system: Operand, order: int | None = None) -> control.StateSpace:
    """As `control.StateSpace`, names included; delays need a Pade order.

    Raises
    ------
    InvalidParameterError
        If the system has delays and no order is given.
    """
    import control

    from flycontrol.delay.pade import pade

    exact = as_delay_lti(system)
    if exact.n_delays and order is None:
        raise InvalidParameterError(
            f"The system has {exact.n_delays} delay(s), which a StateSpace cannot hold; give the order of a Pade "
            "approximation."
        )
    rational = pade(exact, order) if order is not None else exact
    names = {"name": exact.name, "inputs": list(exact.input_names), "outputs": list(exact.output_names)}
    given = {field: value for field, value in names.items() if value}
    return control.StateSpace(rational.A, rational.B1, rational.C1, rational.D11, **given)


def _given_names(labels: list[str], prefix: str) -> tuple[str, ...]:
    """The labels, unless python-control made them up."""
    made_up = [f"{prefix}[{i}]" for i in range(len(labels))]
    return () if list(labels) == made_up else tuple(labels)


def _realised(system: control.TransferFunction) -> DelayLTI:
    """State space column by column or row by row, whichever needs fewer states, balanced.

    Entries of a column (row) with equal denominators share their states; poles common to different denominators are
    realised once each.
    """
    numerators = [[np.trim_zeros(num, "f") for num in row] for row in system.num_list]
    denominators = [[np.trim_zeros(den, "f") for den in row] for row in system.den_list]
    for i, (nums, dens) in enumerate(zip(numerators, denominators, strict=True)):
        for j, (num, den) in enumerate(zip(nums, dens, strict=True)):
            if len(num) > len(den):
                raise InvalidParameterError(
                    f"The transfer function from input {j} to output {i} is improper (numerator of degree "
                    f"{len(num) - 1}, denominator of degree {len(den) - 1}) and has no state space: feed back the "
                    "plant's derivative output instead, or multiply by the plant first, so that the product is proper."
                )
    columns = _by_columns(numerators, denominators)
    rows = _by_columns(_transposed(numerators), _transposed(denominators))
    if columns.n_states <= rows.n_states:
        return balance(columns)
    return balance(delay_free(rows.A.T.copy(), rows.C1.T.copy(), rows.B1.T.copy(), rows.D11.T.copy()))


def _transposed(table: list[list[FloatArray]]) -> list[list[FloatArray]]:
    return [list(column) for column in zip(*table, strict=True)]


def _by_columns(numerators: list[list[FloatArray]], denominators: list[list[FloatArray]]) -> DelayLTI:
    """The columns of a transfer matrix side by side, each input with states of its own."""
    columns = [
        _one_column([row[j] for row in numerators], [row[j] for row in denominators]) for j in range(len(numerators[0]))
    ]
    A, B, C, D = zip(*columns, strict=True)
    return delay_free(_block_diag(A), _block_diag(B), np.hstack(C), np.hstack(D))


def _one_column(numerators: list[FloatArray], denominators: list[FloatArray]) -> tuple[FloatArray, ...]:
    """A, B, C, D of transfer functions from one input: a controllable canonical form for each denominator."""
    alike: dict[bytes, list[int]] = {}
    for i, den in enumerate(denominators):
        alike.setdefault((den / den[0]).tobytes(), []).append(i)
    p = len(numerators)
    A, B, C, D = [np.zeros((0, 0))], [np.zeros((0, 1))], [np.zeros((p, 0))], np.zeros((p, 1))
    for outputs in alike.values():
        den = denominators[outputs[0]] / denominators[outputs[0]][0]
        n = len(den) - 1
        num = np.array([np.pad(numerators[i], (n + 1 - len(numerators[i]), 0)) / denominators[i][0] for i in outputs])
        D[outputs, 0] = num[:, 0]
        reading = np.zeros((p, n))
        reading[outputs] = num[:, 1:] - np.outer(num[:, 0], den[1:])
        if reading.any():
            companion = np.eye(n, k=-1)
            companion[0] = -den[1:]
            A, B, C = [*A, companion], [*B, np.eye(n, 1)], [*C, reading]
    return _block_diag(A), np.vstack(B), np.hstack(C), D


def _block_diag(blocks: Sequence[FloatArray]) -> FloatArray:
    return np.asarray(scipy.linalg.block_diag(*blocks), dtype=np.float64)
