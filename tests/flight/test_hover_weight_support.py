"""Weight support by the measured hover of Drosophila melanogaster, term by term."""

import json
from dataclasses import replace

import numpy as np
import pytest
from simulated_fly import FLY, MELANOGASTER

from flycontrol.flight.multibody.freedoms import HELD
from flycontrol.flight.quasi_steady import TERMS
from flycontrol.flight.settings import MarchSettings
from flycontrol.flight.simulate import simulate_flight
from flycontrol.flight.wing_loads import loads_along
from flycontrol.model.stroke_kinematics import StrokeKinematics
from flycontrol.model.wing_stroke import FourierStroke
from flycontrol.units import deg

FREQUENCY = 218.0


def hover(folder, deviation: float = -1.0) -> FourierStroke:
    """The file counts stroke > 0 dorsal, deviation > 0 down and pitch from the vertical; a0 is twice the mean."""
    table = json.loads((folder / "kinematics_fourier" / "Drosophila_hovering_fry.json").read_text(encoding="utf-8"))
    signs = {"phi": -1.0, "theta": deviation, "alpha": -1.0}
    cosine = np.array([sign * np.array([table[n]["a0"] / 2, *table[n]["ai"]]) for n, sign in signs.items()]) * deg
    sine = np.array([sign * np.array([0.0, *table[n]["bi"]]) for n, sign in signs.items()]) * deg
    cosine[2, 0] += 90 * deg
    return FourierStroke(cosine=cosine, sine=sine)


def support(stroke: FourierStroke, frequency: float = FREQUENCY, morphology=MELANOGASTER) -> dict[str, float]:
    """Mean upward force of both wings over the weight, by term."""
    fly = replace(FLY, morphology=morphology, body=HELD)
    beat = simulate_flight(fly, StrokeKinematics.symmetric(stroke, frequency), 1, settings=MarchSettings(samples=200))
    loads = loads_along(fly, beat)
    return {
        term: -sum(wing.terms[term].force[:-1, 2].mean() for wing in (loads.left, loads.right)) / morphology.weight
        for term in TERMS
    }


def test_the_measured_hover_carries_1_1_mg_and_translation_alone_nearly_so(real_data):
    """2.4 mm wings at 218 Hz: 1.13 of the weight; published replays by quasi-steady models carry nearly all of it."""
    found = support(hover(real_data))
    assert 0.9 < found["translational"] < 1.0
    assert 1.0 < sum(found.values()) < 1.2
    assert found["rotational"] > abs(found["added_mass"])
    assert abs(found["dissipative"]) < 1e-12


def test_the_wing_path_is_the_published_u_and_its_mirror_image_would_lose_a_third_of_the_lift(real_data):
    """Fry 2005: U-shaped paths, wings plunging at the start of each stroke; hence the file's deviation counts down."""
    stroke = hover(real_data)
    phase = np.arange(200) / 200
    sweep, deviation, _ = stroke(phase).angles.T
    middle = np.abs(sweep - (sweep.max() + sweep.min()) / 2) < 0.2 * np.ptp(sweep)
    for reversal in (sweep.argmin(), sweep.argmax()):
        assert deviation[reversal] > deviation[middle].max()
    upside_down = support(hover(real_data, deviation=1.0))
    assert sum(upside_down.values()) == pytest.approx(0.78, abs=0.01)  # 0.7 to 0.8 is what others report


def test_lift_goes_with_the_square_of_frequency_and_the_fourth_power_of_wing_length(real_data):
    """Every term is a velocity or an acceleration squared in f, and an area times r^2 or c^2 r in the wing's size."""
    stroke = hover(real_data)
    once = support(stroke)
    faster = support(stroke, 1.2 * FREQUENCY)
    larger = support(
        stroke,
        morphology=replace(
            MELANOGASTER, wing_length=1.1 * MELANOGASTER.wing_length, mean_chord=1.1 * MELANOGASTER.mean_chord
        ),
    )
    for term in ("translational", "rotational", "added_mass"):
        assert faster[term] == pytest.approx(1.44 * once[term], rel=1e-9)
        assert larger[term] == pytest.approx(1.1**4 * once[term], rel=1e-9)
