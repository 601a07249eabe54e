"""The published fly of the wing-level tests, and strokes that use every angle."""

import numpy as np

from flycontrol.flight.flapping_fly import FlappingFly
from flycontrol.io.morphology import read_morphology_table
from flycontrol.model.morphology import morphology_from_table
from flycontrol.model.stroke_kinematics import StrokeKinematics
from flycontrol.model.wing_stroke import BermanWangStroke
from flycontrol.units import deg

FREQUENCY = 220.0
MELANOGASTER = morphology_from_table(read_morphology_table(), "Drosophila melanogaster", FREQUENCY)
FLY = FlappingFly(morphology=MELANOGASTER)


def wing_stroke(paddling: float = 0.0, lead: float = 5 * deg, amplitude: float = 70 * deg) -> BermanWangStroke:
    return BermanWangStroke(
        stroke_amplitude=amplitude,
        stroke_shape=0.7,
        stroke_offset=-3 * deg,
        pitch_shape=2.0,
        pitch_lead=lead,
        pitch_offset=paddling,
        deviation_amplitude=8 * deg,
        deviation_phase=0.4,
    )


SYMMETRIC = StrokeKinematics.symmetric(wing_stroke(), FREQUENCY)
ASYMMETRIC = StrokeKinematics(
    frequency=FREQUENCY, left=wing_stroke(-4 * deg), right=wing_stroke(5 * deg, lead=12 * deg, amplitude=66 * deg)
)


def swapped(stroke: StrokeKinematics) -> StrokeKinematics:
    return StrokeKinematics(frequency=stroke.frequency, left=stroke.right, right=stroke.left)


def rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(np.square(values))))
