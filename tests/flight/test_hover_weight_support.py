"""Weight support by the measured hover of Drosophila melanogaster, term by term."""

from dataclasses import replace

import numpy as np
import pytest
from simulated_fly import FLY, MELANOGASTER

from flycontrol.flight.multibody.freedoms import HELD
from flycontrol.flight.quasi_steady import TERMS
from flycontrol.flight.settings import MarchSettings
from flycontrol.flight.simulate import simulate_flight
from flycontrol.flight.wing_loads import loads_along
from flycontrol.io.series_conventions import CONVENTIONS
from flycontrol.io.series_files import read_series_file
from flycontrol.model.stroke_kinematics import StrokeKinematics
from flycontrol.model.wing_stroke import FourierStroke

FREQUENCY = 218.0


def hover(folder) -> FourierStroke:
    """Stroke, deviation and pitch of the file, in this package's signs."""
    return read_series_file(
        folder / "kinematics_fourier" / "Drosophila_hovering_fry.json", CONVENTIONS["hovering fruit fly"]
    )


def upside_down(stroke: FourierStroke) -> FourierStroke:
    """The same stroke with its deviation's sign turned."""
    signs = np.array([[1.0], [-1.0], [1.0]])
    return FourierStroke(cosine=signs * stroke.cosine, sine=signs * stroke.sine)


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
    assert sum(support(upside_down(stroke)).values()) == pytest.approx(0.775, abs=0.005)  # others report 0.7 to 0.8


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
