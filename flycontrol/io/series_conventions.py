"""What the numbers of a file of Fourier series mean: an explicit table, for conventions vary and are never guessed.

x(p) = offset + sign * scale * unit * (mean + sum of a_k cos 2 pi k (p + advance) + b_k sin 2 pi k (p + advance)).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from flycontrol.units import deg

Constant = Literal["twice the mean", "the mean"]


@dataclass(frozen=True, slots=True, kw_only=True)
class AngleSeries:
    """Where one angle's coefficients stand in a file, and how it becomes one of this package's angles."""

    cosine: str = ""  #: dotted name of the list a_1, a_2, ...
    sine: str = ""  #: dotted name of the list b_1, b_2, ...
    constant: str = ""  #: dotted name of a_0
    sign: Literal[1, -1] = 1
    offset: float = 0.0  #: [rad]
    advance: float = 0.0  #: by which the file's series runs ahead [wingbeats]
    scale: float = 1.0


@dataclass(frozen=True, slots=True, kw_only=True)
class SeriesConvention:
    """How a file of Fourier series is read."""

    unit: float  #: of its coefficients [rad]
    constant: Constant  #: what a_0 is
    stroke: AngleSeries
    pitch: AngleSeries
    deviation: AngleSeries | None = None  #: None: no deviation
    states: str = ""  #: what the file itself must say under "convention"


_FLAPPER = "alpha=sum_{i=1..29} bi sin(2 pi i (t+tadv[+t0adv])) measured from the vertical"

#: Conventions by name. All three files count time from the dorsal reversal, measure the stroke towards the back, the
#: deviation downwards and the feathering from the vertical, leading edge forward: phi = -phi_file,
#: theta = -theta_file, eta = 90 deg - alpha_file. A common shift of time (t0adv) moves no reversal and is left out.
CONVENTIONS = {
    "hovering fruit fly": SeriesConvention(
        unit=deg,
        constant="twice the mean",
        stroke=AngleSeries(cosine="phi.ai", sine="phi.bi", constant="phi.a0", sign=-1),
        deviation=AngleSeries(cosine="theta.ai", sine="theta.bi", constant="theta.a0", sign=-1),
        pitch=AngleSeries(cosine="alpha.ai", sine="alpha.bi", constant="alpha.a0", sign=-1, offset=90 * deg),
        states="u(t)=a0/2+sum ai cos(2 pi i t)+bi sin(2 pi i t)",
    ),
    "robofly": SeriesConvention(  # advanced rotation; the feathering of 40 deg scaled to 50 deg from the vertical
        unit=deg,
        constant="twice the mean",
        stroke=AngleSeries(cosine="ai_phi", sign=-1),
        pitch=AngleSeries(sine="bi_alpha", sign=-1, offset=90 * deg, advance=0.08, scale=50 / 40),
        states=_FLAPPER,
    ),
    "robofly, mean stroke 10 deg": SeriesConvention(  # the same with the mean that only the file's source states
        unit=deg,
        constant="twice the mean",
        stroke=AngleSeries(cosine="ai_phi", sign=-1, offset=-10 * deg),
        pitch=AngleSeries(sine="bi_alpha", sign=-1, offset=90 * deg, advance=0.08),
        states=_FLAPPER,
    ),
}
