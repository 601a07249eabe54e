"""How high a Pade order a loop needs: the least whose closed loop is certified to be as stable and as accurate."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flycontrol.delay.balance import balance
from flycontrol.delay.convert import as_delay_lti
from flycontrol.delay.frequency_domain import frequency_domain
from flycontrol.delay.interconnect import append, delay, feedback, series
from flycontrol.delay.pade import pade
from flycontrol.delay.panels import kernel_blocks, transfer
from flycontrol.delay.peak_gain import linfnorm, peak_between
from flycontrol.delay.system import ComplexArray, DelayLTI, FloatArray, require_retarded
from flycontrol.errors import InvalidParameterError, UnstableSystemError

if TYPE_CHECKING:
    from flycontrol.delay.convert import Operand

_TOLERANCE = 1e-3  # relative, of both peak gains
_HIGHEST = 40
_LEAST_ACCURACY = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True)
class PadeCertificate:
    """What is known of a loop closed with all its delays approximated by [m/n]; T = L / (1 + L), S = 1 - T."""

    order: int  #: n
    numdeg: int  #: m
    #: sup over w of |(R - E) H|, the error of the approximant R of E around the exact loop; below 1 it certifies
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
    if not _LEAST_ACCURACY <= accuracy < 1:
        raise InvalidParameterError(
            f"The accuracy must lie in [{_LEAST_ACCURACY:g}, 1), got {accuracy!r}: rounding allows no less."
        )
    closed, band = _closed(loop), _band(loop, band)
    omega = frequency_domain(closed).panels(0.0, band).centre.imag
    exact = transfer(kernel_blocks(balance(closed)), 1j * omega)[0]
    least = 1 if numdeg is None else max(1, -numdeg, numdeg)
    for order in range(least, _HIGHEST + 1):
        if _refuted(omega, exact, pade(closed, order, numdeg), accuracy):
            continue
        found = _certificate(closed, order, numdeg, band, 1e-3 * accuracy)
        if found.certified and found.error <= accuracy:
            return found
    raise InvalidParameterError(
        f"No Pade order up to {_HIGHEST} closes this loop with an error of at most {accuracy:g} up to {band:.4g} "
        "rad/s; ask for less or for a narrower band, or keep the delay exact."
    )


def pade_certificate(
    loop: Operand, order: int, numdeg: int | None = None, *, band: float | None = None
) -> PadeCertificate:
    """Compare a loop under negative unit feedback with its [m/n] approximation.

    Delays E = diag exp(-s tau_i) become R. With H the exact closed loop from the delays' outputs back to their inputs,
    det(approximate) / det(exact) = det(I - (R - E) H). While |(R - E) H| < 1 on the imaginary axis, no root crosses it
    on the way from E to R; none comes from infinity, nor from a pole of R, which are stable. For one delay and
    L = N / D exp(-s T) this is |N (R - exp(-jwT)) / (D + N exp(-jwT))|: an integrator in D does no harm. The suprema
    are upper bounds that nothing between grid points exceeds.

    Raises
    ------
    InvalidParameterError, UnstableSystemError, NeutralSystemError
        As `pade_order`; or if the approximant is refused by `pade_matrices`.
    """
    return _certificate(_closed(loop), order, numdeg, _band(loop, band), 1e-9)


def _band(loop: Operand, band: float | None) -> float:
    if band is None:
        return frequency_domain(as_delay_lti(loop)).far.beyond(0.1)
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
    around = series(_seen_by_delays(closed), _approximation_error(closed, order, numdeg))
    loop_error = linfnorm(around, _TOLERANCE, floor=1e-4).upper
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


def _seen_by_delays(closed: DelayLTI) -> DelayLTI:
    """H: from what is added to the delays' outputs to the delays' inputs, the loop closed."""
    x = closed
    return DelayLTI(x.A, x.B2, x.B2, x.C2, x.C2, x.D22, x.D22, x.D22, x.D22, x.tau)


def _approximation_error(closed: DelayLTI, order: int, numdeg: int | None) -> DelayLTI:
    """R - E, one channel for each delay."""
    return append(*[pade(delay(tau), order, numdeg) - delay(tau) for tau in closed.tau])


def _refuted(omega: FloatArray, exact: ComplexArray, approximated: DelayLTI, accuracy: float) -> bool:
    """Whether T is off by more than the accuracy at one of some frequencies already."""
    error = exact - transfer(kernel_blocks(balance(approximated)), 1j * omega)[0]
    return bool(np.linalg.norm(error, 2, axis=(1, 2)).max() > accuracy)
