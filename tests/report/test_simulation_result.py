import json
import re

import numpy as np
import pytest

from flycontrol.flight.experiments import planned_flight
from flycontrol.flight.flight_record import FlightRecorder
from flycontrol.flight.heading import nose_heading
from flycontrol.io.flight_experiments import read_flight_experiment
from flycontrol.report.simulation.figures import simulation_figures
from flycontrol.report.simulation.result import FIELDS, flight_provenance, simulation_result_json
from flycontrol.report.simulation.words import lead
from flycontrol.units import deg


@pytest.fixture(scope="module")
def record(tmp_path_factory):
    file = tmp_path_factory.mktemp("flight") / "flight.toml"
    file.write_text(
        '[march]\nwingbeats = 4\n[[pulse]]\naxis = "yaw"\ntorque = "3e-9 N m"\nonset = "1 wingbeat"\n'
        'duration = "1 wingbeat"\n'
    )
    planned = planned_flight(read_flight_experiment(file))
    recorder = FlightRecorder(planned)
    for piece in planned.chunks():
        recorder.add(piece)
    return recorder.finish()


def paths(value, path=""):
    """Names of all numbers and words in a result, as its fields name them."""
    if isinstance(value, dict):
        for key, inner in value.items():
            yield from paths(inner, f"{path}.{key}" if path else key)
    elif isinstance(value, list):
        for inner in value:
            yield from paths(inner, f"{path}[]")
    else:
        yield path


def test_every_field_says_what_it_holds(record):
    origin = flight_provenance(record.planned.experiment, "flycontrol simulate")
    found = json.loads(simulation_result_json(record, origin, {"result.json": "numbers"}))
    assert found.pop("fields") == FIELDS
    alone = [name for name in FIELDS if not name.startswith("ensemble.")]
    known = [re.compile(re.escape(name).replace(r"\*", r"[^\[\]]+") + "$") for name in alone]
    said = set(paths(found))
    assert not {path for path in said if not any(name.match(path) for name in known)}
    assert not {name.pattern for name in known if not any(name.match(path) for path in said)}


def test_forces_by_term_add_up_to_all(record):
    found = json.loads(
        simulation_result_json(record, flight_provenance(record.planned.experiment, "flycontrol simulate"), {})
    )
    lift = found["mean"]["lift_weights"]
    assert sum(value for term, value in lift.items() if term != "all") == pytest.approx(lift["all"], rel=1e-12)


def test_a_roll_swings_the_nose_sideways_and_the_stroke_planes_heading_not():
    roll, angle = 20 * deg, 55 * deg
    level = np.array([0.0, 1.0, 0.0, 0.0])  # x forward, y right, z down in a world with z up
    rolled = np.array([[-np.sin(roll / 2), np.cos(roll / 2), 0.0, 0.0]])  # level, then about its own x
    assert nose_heading(level[None], angle) == pytest.approx([0.0], abs=1e-15)
    sideways = np.arctan2(np.sin(angle) * np.sin(roll), np.cos(angle))
    assert np.abs(nose_heading(rolled, angle)) == pytest.approx([sideways], rel=1e-12)


def test_the_lead_begins_with_the_turn_and_names_the_nose(record):
    first, second = lead(record)[:2]
    assert first.startswith("The heading of its stroke plane went")
    assert "the nose" in second


def test_a_held_body_has_no_figures_of_its_turning(tmp_path):
    (tmp_path / "held.toml").write_text('[trim]\nmoves = []\n[body]\nfree = "none"\n[march]\nwingbeats = 2\n')
    planned = planned_flight(read_flight_experiment(tmp_path / "held.toml"))
    recorder = FlightRecorder(planned)
    for piece in planned.chunks():
        recorder.add(piece)
    assert not {"attitude", "track", "yaw"} & set(simulation_figures(recorder.finish()))
