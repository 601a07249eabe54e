"""The numbers of a fly and of its nominal experiment, each with its source and how certain it is."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Literal

from flycontrol.errors import InvalidParameterError
from flycontrol.model.references import cite

WrittenCertainty = Literal["S", "S2", "C", "user"]
"""What a file may say."""
Certainty = WrittenCertainty | Literal["fit", "fixed"]

CERTAINTIES: dict[Certainty, str] = {
    "S": "read in the source",
    "S2": "second hand: reported by another source than the one that measured it",
    "C": "calibrated by this package, by the rule that the note states",
    "user": "given in the user's parameter file",
    "fit": "fitted to the recordings",
    "fixed": "taken for known in the fit to the recordings",
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Sourced:
    """A number with its unit, its source and how certain it is."""

    value: float  #: in `unit`
    unit: str  #: an SI unit, radians for angles
    source: str = ""  #: a key of references.bib; empty for a user's own value
    certainty: Certainty = "user"
    note: str = ""
    text: str = ""  #: as the parameter file writes it, "13.6 ms"

    def __post_init__(self) -> None:
        if self.certainty not in CERTAINTIES:
            raise InvalidParameterError(f"Certainty must be one of {', '.join(CERTAINTIES)}, got {self.certainty!r}.")
        if self.source:
            cite(self.source)


@dataclass(frozen=True, slots=True, kw_only=True)
class Parameters:
    """I psi'' = -beta psi' - (K_P psi + K_D psi')(t - T) + N_ext.  Review, Eq. 6-7, restoring gains positive.

    Only ratios to I can be identified from yaw: gains are held as K_P/I and K_D/I.
    """

    name: str  #: of the fly
    inertia: Sourced  #: I about the vertical axis [kg m^2]
    damping: Sourced  #: beta [N m s]
    wingbeat_frequency: Sourced  #: [1/s]
    proportional_gain: Sourced  #: K_P/I [1/s^2]
    derivative_gain: Sourced  #: K_D/I [1/s]
    delay: Sourced  #: T [s]
    pulse_duration: Sourced  #: [s]
    pulse_peak: Sourced  #: largest yaw that the nominal pulse causes in the closed loop [rad]
    tolerance: Sourced  #: half width of the band that ends a recovery [rad]
    deadline: Sourced  #: recovery time that real flies keep from the nominal pulse [s]
    damping_low: Sourced  #: lowest published beta/I [1/s]
    damping_high: Sourced  #: highest published beta/I [1/s]
    paddling_gain: Sourced | None = None  #: gamma [N m/rad]; None: what drag makes of the damping
    defaulted: tuple[str, ...] = ()  #: keys that the user's file left out, as "controller.delay"
    file: str = ""  #: name of the file read
    sha256: str = ""  #: hash of the bytes of the file read and, where keys were missing, of the default file

    def __post_init__(self) -> None:
        for name in ("inertia", "wingbeat_frequency", "pulse_duration", "pulse_peak", "tolerance", "deadline"):
            self._require(name, above=0.0, inclusive=False)
        for name in ("damping", "delay", "damping_low", "damping_high"):
            self._require(name, above=0.0, inclusive=True)
        for name in ("proportional_gain", "derivative_gain"):
            self._require(name, above=float("-inf"), inclusive=False)

    def _require(self, name: str, *, above: float, inclusive: bool) -> None:
        number: Sourced = getattr(self, name)
        fine = above <= number.value if inclusive else above < number.value
        if not (fine and number.value < float("inf")):  # refuses NaN too
            sign = ">=" if inclusive else ">"
            raise InvalidParameterError(
                f"Parameters.{name} must be finite and {sign} {above:g} {number.unit}, got {number.value!r}."
            )

    @property
    def damping_rate(self) -> float:
        """Yaw damping beta/I, in the equations b [1/s]."""
        return self.damping.value / self.inertia.value

    @property
    def delay_in_wingbeats(self) -> float:
        """T f."""
        return self.delay.value * self.wingbeat_frequency.value

    def sourced(self) -> dict[str, Sourced]:
        """Every number by its field's name, in the order of the parameter file."""
        values = {field.name: getattr(self, field.name) for field in fields(self)}
        return {name: value for name, value in values.items() if isinstance(value, Sourced)}
