"""Linear systems with constant delays, as a linear fractional transformation with respect to the delays."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from flycontrol.errors import InvalidParameterError, NeutralSystemError, UnstableSystemError

if TYPE_CHECKING:
    from flycontrol.delay.convert import Operand

FloatArray = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

_BLOCKS = ("A", "B1", "B2", "C1", "C2", "D11", "D12", "D21", "D22", "tau")


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class DelayLTI:
    """x' = A x + B1 u + B2 w,  y = C1 x + D11 u + D12 w,  z = C2 x + D21 u + D22 w,  w_i(t) = z_i(t - tau_i).

    With n states, m inputs, p outputs and q delay channels: A (n, n), B1 (n, m), B2 (n, q), C1 (p, n), C2 (q, n),
    D11 (p, m), D12 (p, q), D21 (q, m), D22 (q, q), tau (q,) in seconds, each > 0. `delay_lti` fills blocks left out.

    G + H, G - H, G * H (y = G(H u)), G / H (y = G(H^-1 u)) and -G are those of transfer matrices. Either side may be a
    number, a gain matrix, or python-control's StateSpace or TransferFunction (save `TransferFunction / DelayLTI`, which
    python-control refuses by itself: write `ss(G) / H`). As there, a number or a system with one input and one output
    is added to every entry and multiplies every entry. Names do not survive arithmetic: see `named`. G[i, j] is the
    part from input j to output i.

    What takes systems here takes those of python-control too. Python-control's own functions do not take a `DelayLTI`:
    for control.feedback, series, bode_plot, step_response and the like take the ones of this package by the same name,
    or hand over `to_statespace(G, order)`, a Pade approximation. Angles are in radians here, phase margins included.

    Raises
    ------
    InvalidParameterError
        If a block does not fit the others, an entry is not finite, a delay is not > 0, or names do not fit.
    """

    __array_ufunc__ = None  # a NumPy number or matrix on the left hands the operation over

    A: FloatArray
    B1: FloatArray
    B2: FloatArray
    C1: FloatArray
    C2: FloatArray
    D11: FloatArray
    D12: FloatArray
    D21: FloatArray
    D22: FloatArray
    tau: FloatArray  #: delays [s]
    input_names: tuple[str, ...] = ()  #: m names, or none
    output_names: tuple[str, ...] = ()  #: p names, or none
    name: str = ""

    def __post_init__(self) -> None:
        blocks = (
            self.A, self.B1, self.B2, self.C1, self.C2, self.D11, self.D12, self.D21, self.D22, self.tau
        )  # fmt: skip
        self._refuse_misfits([block.shape for block in blocks])
        for block in blocks:
            block.setflags(write=False)
        if not np.isfinite(np.concatenate(blocks, axis=None)).all():  # one test for all: ten take longer than the rest
            name = next(name for name, block in zip(_BLOCKS, blocks, strict=True) if not np.isfinite(block).all())
            raise InvalidParameterError(f"DelayLTI.{name} must be finite, got {getattr(self, name).tolist()!r}.")
        if not all(t > 0 for t in self.tau.tolist()):
            raise InvalidParameterError(f"DelayLTI.tau must be > 0 s, got {self.tau.tolist()!r}.")
        _check_names("input_names", self.input_names, self.n_inputs)
        _check_names("output_names", self.output_names, self.n_outputs)

    def _refuse_misfits(self, given: list[tuple[int, ...]]) -> None:
        n, m, p, q = len(self.A), self.B1.shape[-1], len(self.C1), len(self.tau)
        wanted = [(n, n), (n, m), (n, q), (p, n), (q, n), (p, m), (p, q), (q, m), (q, q), (q,)]
        if given != wanted:
            i = next(i for i in range(len(wanted)) if given[i] != wanted[i])
            raise InvalidParameterError(
                f"DelayLTI.{_BLOCKS[i]} must have shape {wanted[i]} to fit A (n = {n}), B1 (m = {m}), C1 (p = {p}) "
                f"and tau (q = {q}), got {given[i]}."
            )

    @property
    def n_states(self) -> int:
        """Number of states n."""
        return self.A.shape[0]

    @property
    def n_inputs(self) -> int:
        """Number of inputs m."""
        return self.B1.shape[1]

    @property
    def n_outputs(self) -> int:
        """Number of outputs p."""
        return self.C1.shape[0]

    @property
    def n_delays(self) -> int:
        """Number of delay channels q."""
        return len(self.tau)

    def __call__(self, s: ArrayLike) -> ComplexArray:
        """Transfer matrix at the complex frequencies s [1/s]; shape s.shape + (p, m).

        Raises
        ------
        InvalidParameterError
            If s holds a root of the system.
        """
        try:
            points = np.asarray(s, dtype=np.complex128)
        except (TypeError, ValueError) as refusal:
            raise InvalidParameterError(f"A complex frequency s [1/s] must be a number, got {s!r}.") from refusal
        inner = characteristic_matrix(self, points)
        n = self.n_states
        factor = _delay_factor(self, points)
        forcing = np.empty((*points.shape, n + self.n_delays, self.n_inputs), dtype=np.complex128)
        forcing[..., :n, :] = self.B1
        forcing[..., n:, :] = factor[..., None] * self.D21
        try:
            states = np.linalg.solve(inner, forcing)
        except np.linalg.LinAlgError as singular:
            raise InvalidParameterError(
                "The transfer matrix is infinite at a root of the system, and s holds one; leave it out."
            ) from singular
        return self.C1 @ states[..., :n, :] + self.D12 @ states[..., n:, :] + self.D11

    def dcgain(self) -> FloatArray:
        """G(0), shape (p, m): the outputs at rest for constant unit inputs, if the system is stable.

        Raises
        ------
        UnstableSystemError
            If the system has a root at s = 0.
        """
        try:
            return self(0.0).real
        except InvalidParameterError as infinite:
            raise UnstableSystemError(
                "A system with a root at s = 0 (an integrator) comes to no rest, so it has no DC gain; close a loop "
                "around it first."
            ) from infinite

    def poles(self, count: int = 10) -> ComplexArray:
        """The `count` rightmost poles [1/s], of infinitely many: those of `rightmost_roots`, which says how certain.

        Raises
        ------
        InvalidParameterError
            If the count is not an integer >= 1, or no certificate could be had.
        NeutralSystemError
            If a delay feeds back into itself without passing a state.
        """
        from flycontrol.delay.spectrum import rightmost_roots

        found = rightmost_roots(self, count)
        if not found.certified:
            raise InvalidParameterError(
                f"The {count} rightmost poles could not be listed for certain ({found.status}); ask for another "
                "number, or see what rightmost_roots finds."
            )
        return found.roots

    def __getitem__(self, key: tuple[Any, Any]) -> DelayLTI:
        """sys[i, j] or with slices: from inputs j to outputs i, as in python-control; states and delays all stay."""
        if not (isinstance(key, tuple) and len(key) == 2):
            raise InvalidParameterError(f"A part of a system is sys[outputs, inputs], two indices, got {key!r}.")
        rows, columns = (
            _picked(index, many, kind)
            for index, many, kind in zip(key, (self.n_outputs, self.n_inputs), ("outputs", "inputs"), strict=True)
        )
        return replace(
            self,
            B1=self.B1[:, columns], C1=self.C1[rows], D11=self.D11[rows][:, columns], D12=self.D12[rows],
            D21=self.D21[:, columns], input_names=tuple(self.input_names[columns]),
            output_names=tuple(self.output_names[rows]),
        )  # fmt: skip

    def feedback(self, other: Operand | None = None, sign: float = -1.0) -> DelayLTI:
        """The loop y = self(v + sign * other(y)), see `flycontrol.delay.interconnect.feedback`."""
        from flycontrol.delay.interconnect import feedback

        return feedback(self, other, sign)

    def __add__(self, other: Operand) -> DelayLTI:
        from flycontrol.delay.arithmetic import add

        return add(self, other)

    def __radd__(self, other: Operand) -> DelayLTI:
        from flycontrol.delay.arithmetic import add

        return add(other, self)

    def __sub__(self, other: Operand) -> DelayLTI:
        from flycontrol.delay.arithmetic import subtract

        return subtract(self, other)

    def __rsub__(self, other: Operand) -> DelayLTI:
        from flycontrol.delay.arithmetic import subtract

        return subtract(other, self)

    def __mul__(self, other: Operand) -> DelayLTI:
        from flycontrol.delay.arithmetic import multiply

        return multiply(self, other)

    def __rmul__(self, other: Operand) -> DelayLTI:
        from flycontrol.delay.arithmetic import multiply

        return multiply(other, self)

    def __truediv__(self, other: Operand) -> DelayLTI:
        from flycontrol.delay.arithmetic import divide

        return divide(self, other)

    def __rtruediv__(self, other: Operand) -> DelayLTI:
        from flycontrol.delay.arithmetic import divide

        return divide(other, self)

    def __neg__(self) -> DelayLTI:
        return -1.0 * self

    def __repr__(self) -> str:
        counts = ((self.n_states, "state"), (self.n_inputs, "input"), (self.n_outputs, "output"))
        sizes = ", ".join(f"{many} {noun}" + "s" * (many != 1) for many, noun in counts)
        return f"<DelayLTI {self.name}".rstrip() + f": {sizes}, {_delays_in_words(self.tau)}>"


def _picked(index: Any, many: int, kind: str) -> slice:
    """An index or a slice among so many signals, as a slice."""
    if isinstance(index, slice):
        return index
    if not (isinstance(index, int | np.integer) and -many <= index < many):
        raise InvalidParameterError(f"There are {many} {kind}, numbered from 0; got {index!r}.")
    place = int(index) % many
    return slice(place, place + 1)


def _check_names(field: str, names: tuple[str, ...], many: int) -> None:
    if names == ():
        return
    fits = isinstance(names, tuple) and all(isinstance(name, str) and name for name in names)
    if not (fits and len(names) in (0, many) and len(set(names)) == len(names)):
        raise InvalidParameterError(
            f"DelayLTI.{field} must be {many} distinct names in a tuple, or empty, got {names!r}."
        )


def _delays_in_words(tau: FloatArray) -> str:
    """'no delay', 'delay 13.6 ms', '2 delays 5 ms, 13.6 ms', '9 delays 1 ms .. 2 s'."""
    if len(tau) == 0:
        return "no delay"
    words = [f"{t:.4g} s" if t >= 1 else f"{t * 1e3:.4g} ms" if t >= 1e-3 else f"{t * 1e6:.4g} us" for t in tau]
    if len(tau) == 1:
        return f"delay {words[0]}"
    listed = ", ".join(words) if len(tau) <= 4 else f"{words[int(tau.argmin())]} .. {words[int(tau.argmax())]}"
    return f"{len(tau)} delays {listed}"


def delay_lti(  # noqa: PLR0913 (one argument a block)
    *,
    A: ArrayLike,
    B1: ArrayLike,
    C1: ArrayLike,
    tau: ArrayLike = (),
    B2: ArrayLike | None = None,
    C2: ArrayLike | None = None,
    D11: ArrayLike | None = None,
    D12: ArrayLike | None = None,
    D21: ArrayLike | None = None,
    D22: ArrayLike | None = None,
) -> DelayLTI:
    """A `DelayLTI` from its blocks; blocks that are left out are zero. Shapes as in `DelayLTI`.

    Raises
    ------
    InvalidParameterError
        If a block is no array of real numbers, or does not fit the others.
    """
    a, b1, c1 = _real("A", A), _real("B1", B1), _real("C1", C1)
    delays = _real("tau", tau, 1)
    n, m, p, q = a.shape[0], b1.shape[1], c1.shape[0], len(delays)

    def block(name: str, given: ArrayLike | None, shape: tuple[int, int]) -> FloatArray:
        return np.zeros(shape) if given is None else _real(name, given)

    return DelayLTI(
        a, b1, block("B2", B2, (n, q)), c1, block("C2", C2, (q, n)),
        block("D11", D11, (p, m)), block("D12", D12, (p, q)), block("D21", D21, (q, m)), block("D22", D22, (q, q)),
        delays,
    )  # fmt: skip


def _real(name: str, block: ArrayLike, ndmin: int = 2) -> FloatArray:
    """A block as a new array of float64."""
    try:
        return np.array(block, dtype=np.float64, ndmin=ndmin)
    except (TypeError, ValueError) as refusal:
        raise InvalidParameterError(
            f"DelayLTI.{name} must be an array of real numbers, its rows equally long, got {block!r}."
        ) from refusal


def _delay_factor(system: DelayLTI, s: ComplexArray) -> ComplexArray:
    """exp(-s tau_i), shape s.shape + (q,)."""
    return np.exp(-s[..., None] * system.tau)


def characteristic_matrix(system: DelayLTI, s: ArrayLike) -> ComplexArray:
    """[[s I - A, -B2], [-E C2, I - E D22]] with E = diag exp(-s tau_i); singular exactly at the system's roots.

    Shape s.shape + (n + q, n + q). Its determinant is entire in s when the system is of retarded type.
    """
    points = np.asarray(s, dtype=np.complex128)
    n, q = system.n_states, system.n_delays
    factor = _delay_factor(system, points)[..., None]
    matrix = np.empty((*points.shape, n + q, n + q), dtype=np.complex128)
    matrix[..., :n, :n] = points[..., None, None] * np.eye(n) - system.A
    matrix[..., :n, n:] = -system.B2
    matrix[..., n:, :n] = -factor * system.C2
    matrix[..., n:, n:] = np.eye(q) - factor * system.D22
    return matrix


def is_retarded(system: DelayLTI) -> bool:
    """Whether no path leads from a delay back into itself without passing a state (D22 structurally nilpotent)."""
    if not np.count_nonzero(system.D22):
        return True
    pattern = (system.D22 != 0).astype(np.float64)
    return not np.linalg.matrix_power(pattern, system.n_delays).any()


def require_retarded(system: DelayLTI) -> None:
    """Refuse a system of neutral type.

    Raises
    ------
    NeutralSystemError
        If a delay feeds back into itself without passing a state.
    """
    if not is_retarded(system):
        raise NeutralSystemError(
            "This system is of neutral type: a delay feeds back into itself without passing a state, so that "
            "infinitely many roots can crowd a vertical line and jumps echo for ever. Put a lag into that path."
        )
