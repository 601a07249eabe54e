"""Exact theory of linear systems with delays, for any plant: nothing here knows a fly.

>>> import control
>>> from flycontrol.delay import delay, feedback, margins, rightmost_roots
>>> loop = control.tf([900], [1, 20, 0]) * delay(0.0136)
>>> margins(loop).delay_margin, rightmost_roots(feedback(loop)).abscissa  # doctest: +SKIP

Names are loaded when they are first used, so that importing this package costs nothing.
"""

import sys
from importlib import import_module
from types import ModuleType
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from flycontrol.delay.convert import from_control as from_control
    from flycontrol.delay.convert import static_gain as static_gain
    from flycontrol.delay.convert import to_statespace as to_statespace
    from flycontrol.delay.count import RootCount as RootCount
    from flycontrol.delay.count import count_right_of as count_right_of
    from flycontrol.delay.frequency import FrequencyResponse as FrequencyResponse
    from flycontrol.delay.frequency import frequency_response as frequency_response
    from flycontrol.delay.interconnect import append as append
    from flycontrol.delay.interconnect import connect as connect
    from flycontrol.delay.interconnect import delay as delay
    from flycontrol.delay.interconnect import feedback as feedback
    from flycontrol.delay.interconnect import parallel as parallel
    from flycontrol.delay.interconnect import series as series
    from flycontrol.delay.locus import RootLocus as RootLocus
    from flycontrol.delay.locus import root_locus as root_locus
    from flycontrol.delay.margins import Margins as Margins
    from flycontrol.delay.margins import margins as margins
    from flycontrol.delay.pade import pade as pade
    from flycontrol.delay.response import Response as Response
    from flycontrol.delay.response import response as response
    from flycontrol.delay.signals import named as named
    from flycontrol.delay.spectrum import Spectrum as Spectrum
    from flycontrol.delay.spectrum import rightmost_roots as rightmost_roots
    from flycontrol.delay.system import DelayLTI as DelayLTI
    from flycontrol.delay.system import characteristic_matrix as characteristic_matrix
    from flycontrol.delay.system import delay_lti as delay_lti
    from flycontrol.delay.system import is_retarded as is_retarded
    from flycontrol.delay.wiring import interconnect as interconnect
    from flycontrol.delay.wiring import summing_junction as summing_junction

#: What the package offers, by the module that holds it; the same list as above, which type checkers read.
_OFFERED = {
    "convert": ("from_control", "static_gain", "to_statespace"),
    "count": ("RootCount", "count_right_of"),
    "frequency": ("FrequencyResponse", "frequency_response"),
    "interconnect": ("append", "connect", "delay", "feedback", "parallel", "series"),
    "locus": ("RootLocus", "root_locus"),
    "margins": ("Margins", "margins"),
    "pade": ("pade",),
    "response": ("Response", "response"),
    "signals": ("named",),
    "spectrum": ("Spectrum", "rightmost_roots"),
    "system": ("DelayLTI", "characteristic_matrix", "delay_lti", "is_retarded"),
    "wiring": ("interconnect", "summing_junction"),
}
_HOME = {name: module for module, names in _OFFERED.items() for name in names}


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    globals()[name] = getattr(import_module(f"{__name__}.{_HOME[name]}"), name)
    return globals()[name]


def __dir__() -> list[str]:
    return sorted(_HOME)


class _Package(ModuleType):
    """`flycontrol.delay.pade` is the function, also after something has imported the module of that name."""

    def __setattr__(self, name: str, value: object) -> None:
        if not (name in _HOME and isinstance(value, ModuleType)):
            super().__setattr__(name, value)


sys.modules[__name__].__class__ = _Package
