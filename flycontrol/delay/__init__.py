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
    from flycontrol.delay.arithmetic import inverse as inverse
    from flycontrol.delay.certificate import DelayCertificate as DelayCertificate
    from flycontrol.delay.certificate import IntervalCertificate as IntervalCertificate
    from flycontrol.delay.certificate import certify_interval as certify_interval
    from flycontrol.delay.certificate import check_matrices as check_matrices
    from flycontrol.delay.certificate import largest_certified_delay as largest_certified_delay
    from flycontrol.delay.certificate import stability_certificate as stability_certificate
    from flycontrol.delay.characteristic import CharacteristicBlocks as CharacteristicBlocks
    from flycontrol.delay.characteristic import characteristic_blocks as characteristic_blocks
    from flycontrol.delay.chart import Axis as Axis
    from flycontrol.delay.chart import StabilityChart as StabilityChart
    from flycontrol.delay.chart import stability_chart as stability_chart
    from flycontrol.delay.continuation import Collision as Collision
    from flycontrol.delay.convert import from_control as from_control
    from flycontrol.delay.convert import static_gain as static_gain
    from flycontrol.delay.convert import to_statespace as to_statespace
    from flycontrol.delay.count import RootCount as RootCount
    from flycontrol.delay.count import count_right_of as count_right_of
    from flycontrol.delay.dcurve import DCurve as DCurve
    from flycontrol.delay.dcurve import PDGains as PDGains
    from flycontrol.delay.dcurve import pd_boundary as pd_boundary
    from flycontrol.delay.disk_margins import DiskMargins as DiskMargins
    from flycontrol.delay.disk_margins import disk_margins as disk_margins
    from flycontrol.delay.family import Family as Family
    from flycontrol.delay.frequency import FrequencyResponse as FrequencyResponse
    from flycontrol.delay.frequency import active_range as active_range
    from flycontrol.delay.frequency import frequency_response as frequency_response
    from flycontrol.delay.h2 import H2Norm as H2Norm
    from flycontrol.delay.h2 import h2_norm as h2_norm
    from flycontrol.delay.interconnect import append as append
    from flycontrol.delay.interconnect import connect as connect
    from flycontrol.delay.interconnect import delay as delay
    from flycontrol.delay.interconnect import feedback as feedback
    from flycontrol.delay.interconnect import parallel as parallel
    from flycontrol.delay.interconnect import series as series
    from flycontrol.delay.locus import AxisCrossing as AxisCrossing
    from flycontrol.delay.locus import Entry as Entry
    from flycontrol.delay.locus import RootLocus as RootLocus
    from flycontrol.delay.locus import root_locus as root_locus
    from flycontrol.delay.margins import Margins as Margins
    from flycontrol.delay.margins import margins as margins
    from flycontrol.delay.nonlinear import nonlinear_response as nonlinear_response
    from flycontrol.delay.norms import system_norm as system_norm
    from flycontrol.delay.nyquist import NyquistResponse as NyquistResponse
    from flycontrol.delay.nyquist import nyquist_response as nyquist_response
    from flycontrol.delay.pade import PadeMatrices as PadeMatrices
    from flycontrol.delay.pade import pade as pade
    from flycontrol.delay.pade import pade_matrices as pade_matrices
    from flycontrol.delay.pade_order import PadeCertificate as PadeCertificate
    from flycontrol.delay.pade_order import pade_certificate as pade_certificate
    from flycontrol.delay.pade_order import pade_order as pade_order
    from flycontrol.delay.peak_gain import PeakGain as PeakGain
    from flycontrol.delay.peak_gain import hinf_norm as hinf_norm
    from flycontrol.delay.peak_gain import linfnorm as linfnorm
    from flycontrol.delay.piecewise import PiecewisePolynomial as PiecewisePolynomial
    from flycontrol.delay.piecewise import fitted as fitted
    from flycontrol.delay.piecewise import piecewise_polynomial as piecewise_polynomial
    from flycontrol.delay.piecewise import sampled as sampled
    from flycontrol.delay.plots import bode_plot as bode_plot
    from flycontrol.delay.plots import d_curve_plot as d_curve_plot
    from flycontrol.delay.plots import gangof4_plot as gangof4_plot
    from flycontrol.delay.plots import nichols_plot as nichols_plot
    from flycontrol.delay.plots import nyquist_plot as nyquist_plot
    from flycontrol.delay.plots import pole_map as pole_map
    from flycontrol.delay.plots import pole_plot as pole_plot
    from flycontrol.delay.plots import root_locus_map as root_locus_map
    from flycontrol.delay.plots import root_locus_plot as root_locus_plot
    from flycontrol.delay.plots import stability_chart_plot as stability_chart_plot
    from flycontrol.delay.plots import time_response_plot as time_response_plot
    from flycontrol.delay.response import Response as Response
    from flycontrol.delay.response import response as response
    from flycontrol.delay.response_sensitivity import BlockDerivatives as BlockDerivatives
    from flycontrol.delay.response_sensitivity import ResponseSensitivity as ResponseSensitivity
    from flycontrol.delay.response_sensitivity import delay_derivatives as delay_derivatives
    from flycontrol.delay.response_sensitivity import response_sensitivity as response_sensitivity
    from flycontrol.delay.sensitivity import GangOfFour as GangOfFour
    from flycontrol.delay.sensitivity import SensitivityPeaks as SensitivityPeaks
    from flycontrol.delay.sensitivity import complementary_sensitivity as complementary_sensitivity
    from flycontrol.delay.sensitivity import gangof4 as gangof4
    from flycontrol.delay.sensitivity import sensitivity as sensitivity
    from flycontrol.delay.signals import named as named
    from flycontrol.delay.spectrum import Spectrum as Spectrum
    from flycontrol.delay.spectrum import rightmost_roots as rightmost_roots
    from flycontrol.delay.system import DelayLTI as DelayLTI
    from flycontrol.delay.system import characteristic_matrix as characteristic_matrix
    from flycontrol.delay.system import delay_lti as delay_lti
    from flycontrol.delay.system import is_retarded as is_retarded
    from flycontrol.delay.system import require_retarded as require_retarded
    from flycontrol.delay.timeresponse import Impulses as Impulses
    from flycontrol.delay.timeresponse import TimeResponse as TimeResponse
    from flycontrol.delay.timeresponse import forced_response as forced_response
    from flycontrol.delay.timeresponse import impulse_response as impulse_response
    from flycontrol.delay.timeresponse import initial_response as initial_response
    from flycontrol.delay.timeresponse import step_response as step_response
    from flycontrol.delay.wiring import interconnect as interconnect
    from flycontrol.delay.wiring import summing_junction as summing_junction

#: What the package offers, by the module that holds it; the same list as above, which type checkers read.
_OFFERED = {
    "arithmetic": ("inverse",),
    "certificate": (
        "DelayCertificate",
        "IntervalCertificate",
        "certify_interval",
        "check_matrices",
        "largest_certified_delay",
        "stability_certificate",
    ),
    "characteristic": ("CharacteristicBlocks", "characteristic_blocks"),
    "chart": ("Axis", "StabilityChart", "stability_chart"),
    "continuation": ("Collision",),
    "convert": ("from_control", "static_gain", "to_statespace"),
    "count": ("RootCount", "count_right_of"),
    "dcurve": ("DCurve", "PDGains", "pd_boundary"),
    "disk_margins": ("DiskMargins", "disk_margins"),
    "family": ("Family",),
    "frequency": ("FrequencyResponse", "active_range", "frequency_response"),
    "h2": ("H2Norm", "h2_norm"),
    "interconnect": ("append", "connect", "delay", "feedback", "parallel", "series"),
    "locus": ("AxisCrossing", "Entry", "RootLocus", "root_locus"),
    "margins": ("Margins", "margins"),
    "nonlinear": ("nonlinear_response",),
    "norms": ("system_norm",),
    "nyquist": ("NyquistResponse", "nyquist_response"),
    "pade": ("PadeMatrices", "pade", "pade_matrices"),
    "pade_order": ("PadeCertificate", "pade_certificate", "pade_order"),
    "peak_gain": ("PeakGain", "hinf_norm", "linfnorm"),
    "piecewise": ("PiecewisePolynomial", "fitted", "piecewise_polynomial", "sampled"),
    "plots": (
        "bode_plot",
        "d_curve_plot",
        "gangof4_plot",
        "nichols_plot",
        "nyquist_plot",
        "pole_map",
        "pole_plot",
        "root_locus_map",
        "root_locus_plot",
        "stability_chart_plot",
        "time_response_plot",
    ),
    "response": ("Response", "response"),
    "response_sensitivity": ("BlockDerivatives", "ResponseSensitivity", "delay_derivatives", "response_sensitivity"),
    "sensitivity": ("GangOfFour", "SensitivityPeaks", "complementary_sensitivity", "gangof4", "sensitivity"),
    "signals": ("named",),
    "spectrum": ("Spectrum", "rightmost_roots"),
    "system": ("DelayLTI", "characteristic_matrix", "delay_lti", "is_retarded", "require_retarded"),
    "timeresponse": (
        "Impulses",
        "TimeResponse",
        "forced_response",
        "impulse_response",
        "initial_response",
        "step_response",
    ),
    "wiring": ("interconnect", "summing_junction"),
}
_HOME = {name: module for module, names in _OFFERED.items() for name in names}


def __getattr__(name: str) -> Any:
    if name == "__all__":  # for `from flycontrol.delay import *`
        return __dir__()
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
