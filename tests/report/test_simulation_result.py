import json
import re

import pytest

from flycontrol.flight.experiments import planned_flight
from flycontrol.flight.flight_record import FlightRecorder
from flycontrol.io.flight_experiments import read_flight_experiment
from flycontrol.report.simulation_result import FIELDS, flight_provenance, simulation_result_json


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
