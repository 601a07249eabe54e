"""The published fly of the tests of the reduced model, its hover, and strokes at their limits."""

from dataclasses import replace
from functools import cache

import numpy as np

from flycontrol.flight.flapping_fly import FlappingFly
from flycontrol.flight.quasi_steady import TERMS, QuasiSteadyModel, Term
from flycontrol.flight.stroke_derivatives import StrokeDerivatives, stroke_derivatives
from flycontrol.flight.trim import HoverTrim, hover_trim
from flycontrol.io.morphology import read_morphology_table
from flycontrol.io.series_conventions import CONVENTIONS
from flycontrol.io.series_files import read_series_file
from flycontrol.model.morphology import Morphology, drosophila_hydei, morphology_from_table
from flycontrol.model.stroke_kinematics import StrokeKinematics, hover_stroke
from flycontrol.model.wing_stroke import BermanWangStroke, fourier_stroke
from flycontrol.reduce.yaw_torque import YawExperiment
from flycontrol.units import deg

MELANOGASTER = morphology_from_table(read_morphology_table(), "Drosophila melanogaster", 220.0)
FLY = FlappingFly(morphology=MELANOGASTER)
STEADY = QuasiSteadyModel(terms=("translational",))
ON_AXIS = replace(MELANOGASTER, right_hinge=(0.0, 0.0, 0.0))


@cache
def trim() -> HoverTrim:
    return hover_trim(FLY, hover_stroke())


@cache
def derivatives() -> StrokeDerivatives:
    return stroke_derivatives(FLY, trim().kinematics)


def hover() -> YawExperiment:
    return YawExperiment(fly=FLY, kinematics=trim().kinematics)


def wiggling(morphology: Morphology = MELANOGASTER, frequency: float = 220.0) -> YawExperiment:
    """A stroke that uses every angle."""
    stroke = BermanWangStroke(
        stroke_amplitude=70 * deg,
        stroke_shape=0.7,
        stroke_offset=-3 * deg,
        pitch_shape=2.0,
        pitch_lead=5 * deg,
        deviation_amplitude=8 * deg,
        deviation_phase=0.4,
    )
    return YawExperiment(
        fly=FlappingFly(morphology=morphology), kinematics=StrokeKinematics.symmetric(stroke, frequency)
    )


def sweeping(
    *,
    stroke_shape: float = 1e-4,
    pitch_shape: float = 100.0,
    pitch_amplitude: float = 45 * deg,
    morphology: Morphology = ON_AXIS,
    terms: tuple[Term, ...] = TERMS,
) -> YawExperiment:
    """A stroke in its plane, from sine (shape 0) to constant speed (shape 1), pitch from sine to a switch."""
    stroke = BermanWangStroke(
        stroke_amplitude=70 * deg,
        stroke_shape=stroke_shape,
        pitch_amplitude=pitch_amplitude,
        pitch_shape=pitch_shape,
    )
    fly = FlappingFly(morphology=morphology, air=QuasiSteadyModel(terms=terms))
    return YawExperiment(fly=fly, kinematics=StrokeKinematics.symmetric(stroke, 220.0))


def fry_hover(real_data) -> YawExperiment:
    """The measured hover of D. melanogaster."""
    path = real_data / "kinematics_fourier" / "Drosophila_hovering_fry.json"
    stroke = read_series_file(path, CONVENTIONS["hovering fruit fly"])
    return YawExperiment(fly=FLY, kinematics=StrokeKinematics.symmetric(stroke, 218.0))


def hydei_wingbeat(real_data) -> YawExperiment:
    """The measured mean wingbeat of D. hydei; the file's stroke and pitch count the other way round."""
    path = real_data / "muijres_mean_wingbeats" / "steady_free_flight.csv"
    table = np.genfromtxt(path, delimiter=",", names=True)[:-1]
    angles = np.stack([-table["stroke_mean_deg"], table["dev_mean_deg"], 180 - table["pitch_mean_deg"]], axis=1) * deg
    stroke = fourier_stroke(np.arange(len(table)) / len(table), angles, 12)
    fly = FlappingFly(morphology=drosophila_hydei(189.0))
    return YawExperiment(fly=fly, kinematics=StrokeKinematics.symmetric(stroke, 189.0))
