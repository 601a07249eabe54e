"""How high a Pade order a loop needs: the least whose closed loop is certified to be as stable and as accurate."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from flycontrol.delay.balance import balance
from flycontrol.delay.convert import as_delay_lti
from flycontrol.delay.frequency import evaluate
from flycontrol.delay.frequency_domain import frequency_domain
from flycontrol.delay.interconnect import delay, feedback, series
from flycontrol.delay.pade import first_delays_approximated, pade
from flycontrol.delay.panels import kernel_blocks, transfer
from flycontrol.delay.peak_gain import linfnorm, peak_between
from flycontrol.delay.real import real_number
from flycontrol.delay.system import ComplexArray, DelayLTI, FloatArray, require_retarded
from flycontrol.errors import InvalidParameterError, UnstableSystemError

if TYPE_CHECKING:
    from flycontrol.delay.convert import Operand

_TOLERANCE = 1e-3  # relative, of both peak gains
_HIGHEST = 40
_DOUBTFUL = 8  # from here on it is asked whether the highest order would do
_SAMPLES = 200
_LEAST_ACCURACY = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True)
class PadeCertificate:
    """What is known of a loop closed with all its delays approximated by [m/n]; T = L / (1 + L), S = 1 - T."""

    order: int  #: n
    numdeg: int  #: m
    #: the delays replaced one after the other: largest |(R_i - E_i) H_i|, the error of an approximant around its loop,
    #: over w and i; below 1 it certifies; the first one of at least 1, if there is
    loop_error: float
    band: float  #: frequency up to which `error` holds [rad/s]
    error: float  #: never exceeded up to `band` by |T - T_approximate|, nor by the error of S; inf if not certified
    error_everywhere: float  #: never exceeded at any frequency; inf if not certified
    unstable: int  #: poles of the exact closed loop with Re s > 0
    status: str

    @property
    def certified(self) -> bool:
        """Whether exact and approximate closed loop have equally many poles with Re s >= 0."""
        return self.loop_error < 1


def pade_order(
    loop: Operand, accuracy: float, numdeg: int | None = None, *, band: float | None = None
) -> PadeCertificate:
    """The least order n whose [m/n] closes the loop certified, with T and S off by no more than `accuracy` in a band.

    Far above the band an approximant's phase is wrong altogether, so that T is off by as much as it is large there:
    see `error_everywhere`.

    Parameters
    ----------
    loop
        L, closed by negative unit feedback; any number of delays anywhere in it.
    accuracy
        Largest error of T and S, absolute (T is 1 where feedback is perfect).
    numdeg
        Degree m of the numerator: n when left out, n + numdeg when negative.
    band
        Highest frequency at which the accuracy is asked for [rad/s]; when left out, that from which on a bound keeps
        |L| below 0.1.

    Raises
    ------
    InvalidParameterError
        If the loop has no delay, the accuracy is not in [1e-9, 1), or no order up to 40 reaches it.
    UnstableSystemError
        If the exact closed loop has a pole on the imaginary axis.
    NeutralSystemError
        If it is of neutral type.
    """
    accuracy = real_number(accuracy, "The accuracy of a Pade approximation")
    if not _LEAST_ACCURACY <= accuracy < 1:
        raise InvalidParameterError(
            f"The accuracy must lie in [{_LEAST_ACCURACY:g}, 1), got {accuracy!r}: rounding allows no less."
        )
    closed, band = _closed(loop), _band(loop, band)
    sample = _sampled(closed, band)
    least = 1 if numdeg is None else max(1, -numdeg, numdeg)
    doubtful = _DOUBTFUL if numdeg is None or numdeg < 0 else _HIGHEST + 1  # [numdeg/40] may have unstable poles
    for order in range(least, _HIGHEST + 1):
        # errors fall with the order: where the highest one fails, the search need not go on
        if order == doubtful and _refuted(sample, closed, _HIGHEST, numdeg, accuracy):
            break
        if _refuted(sample, closed, order, numdeg, accuracy):
            continue
        found = _certificate(closed, order, numdeg, band, 1e-3 * accuracy)
        if found.certified and found.error <= accuracy:
            return found
    raise InvalidParameterError(
        f"No Pade order up to {_HIGHEST} closes this loop certified and with an error of at most {accuracy:g} up to "
        f"{band:.4g} rad/s; ask for less or for a narrower band, or keep the delay exact."
    )


def pade_certificate(
    loop: Operand, order: int, numdeg: int | None = None, *, band: float | None = None
) -> PadeCertificate:
    """Compare a loop under negative unit feedback with its [m/n] approximation.

    Delays E_i = exp(-s tau_i) become R_i one after the other. With H_i the closed loop from the i-th delay's output
    back to its input, the delays before it approximated and the others exact, det(approximate) / det(exact) is the
    product of 1 - (R_i - E_i) H_i. While every |(R_i - E_i) H_i| < 1 on the imaginary axis, no root crosses it on the
    way from E to R; none comes from infinity, nor from a pole of R, which are stable. These are scalars: no unit of a
    signal between two delays matters. For one delay and L = N / D exp(-s T) this is
    |N (R - exp(-jwT)) / (D + N exp(-jwT))|: an integrator in D does no harm. The suprema are upper bounds that nothing
    between grid points exceeds.

    Raises
    ------
    InvalidParameterError, UnstableSystemError, NeutralSystemError
        As `pade_order`; or if the approximant is refused by `pade_matrices`.
    """
    return _certificate(_closed(loop), order, numdeg, _band(loop, band), 1e-9)


def _band(loop: Operand, band: float | None) -> float:
    if band is None:
        return frequency_domain(as_delay_lti(loop)).far.beyond(0.1)
    band = real_number(band, "The band of a Pade approximation")
    if not 0 < band < np.inf:
        raise InvalidParameterError(f"The band of a Pade approximation must be > 0 rad/s and finite, got {band!r}.")
    return band


def _closed(loop: Operand) -> DelayLTI:
    closed = feedback(as_delay_lti(loop))
    if closed.n_delays == 0:
        raise InvalidParameterError("The closed loop has no delay to approximate.")
    require_retarded(closed)
    on_axis = frequency_domain(closed).poles.on_axis
    if on_axis:
        raise UnstableSystemError(
            f"The exact closed loop has a pole on the imaginary axis, at {on_axis[0].frequency:.4g} rad/s: any "
            "approximation may put it on either side. Change a gain or the delay first."
        )
    return closed


def _certificate(closed: DelayLTI, order: int, numdeg: int | None, band: float, floor: float) -> PadeCertificate:
    loop_error = _loop_error(closed, order, numdeg)
    unstable = frequency_domain(closed).poles.unstable
    error = everywhere = np.inf
    status = "not certified, which proves nothing: the approximate loop may or may not be as stable as the exact one"
    if loop_error < 1:
        difference = closed - pade(closed, order, numdeg)
        error = peak_between(difference, 0.0, band, _TOLERANCE, floor).upper
        everywhere = max(error, linfnorm(difference, 0.01, max(floor, 1e-4)).upper)
        status = (
            f"certified: exact and approximate loop have {unstable} unstable pole(s) each; T and S differ by at most "
            f"{error:.2g} up to {band:.3g} rad/s, and by {everywhere:.2g} anywhere"
        )
    return PadeCertificate(
        order=order,
        numdeg=order if numdeg is None else numdeg % order if numdeg < 0 else numdeg,
        loop_error=loop_error,
        band=band,
        error=error,
        error_everywhere=everywhere,
        unstable=unstable,
        status=status,
    )


def _loop_error(closed: DelayLTI, order: int, numdeg: int | None) -> float:
    """The largest |(R_i - E_i) H_i|; what comes after one of at least 1 says nothing more."""
    largest = 0.0
    for i in range(closed.n_delays):
        around = linfnorm(_error_around(closed, i, order, numdeg), _TOLERANCE, floor=1e-4)
        largest = max(largest, around.upper)
        if largest >= 1:
            break
    return largest


def _error_around(closed: DelayLTI, i: int, order: int, numdeg: int | None) -> DelayLTI:
    """(R_i - E_i) H_i, the delays before the i-th one approximated."""
    x, k = closed, slice(i, i + 1)
    seen = DelayLTI(x.A, x.B2[:, k], x.B2, x.C2[k], x.C2, x.D22[k, k], x.D22[k], x.D22[:, k], x.D22, x.tau)
    late = delay(float(x.tau[i]))
    return series(first_delays_approximated(seen, i, order, numdeg), pade(late, order, numdeg) - late)


class _Sample(NamedTuple):
    """Frequencies at which an order may be refuted at little cost."""

    inside: FloatArray  #: in the band [rad/s]
    exact: ComplexArray  #: the closed loop there
    everywhere: FloatArray  #: up to where an error of 2 in a delay no longer matters [rad/s]


def _sampled(closed: DelayLTI, band: float) -> _Sample:
    inside = frequency_domain(closed).panels(0.0, band).centre.imag
    exact = transfer(kernel_blocks(balance(closed)), 1j * inside)[0]
    x = closed
    around = frequency_domain(DelayLTI(x.A, x.B2, x.B2, x.C2, x.C2, x.D22, x.D22, x.D22, x.D22, x.tau))
    last = around.affordable_top(around.far.beyond(0.5))
    return _Sample(inside, exact, np.geomspace(1e-2 * band, max(last, band), _SAMPLES))


def _refuted(sample: _Sample, closed: DelayLTI, order: int, numdeg: int | None, accuracy: float) -> bool:
    """Whether a frequency shows already that T is off by more than the accuracy, or that nothing will be certified."""
    approximated = transfer(kernel_blocks(balance(pade(closed, order, numdeg))), 1j * sample.inside)[0]
    if np.linalg.norm(sample.exact - approximated, 2, axis=(1, 2)).max() > accuracy:
        return True
    return any(
        np.abs(evaluate(_error_around(closed, i, order, numdeg), sample.everywhere)).max() >= 1
        for i in range(closed.n_delays)
    )
