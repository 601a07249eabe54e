"""The parts of a flight experiment, from the tables of its file to values in SI units."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flycontrol.errors import InvalidInputError
from flycontrol.io.flight_experiment_file import (
    AirTable,
    BodyTable,
    HingesTable,
    JointTable,
    PulseTable,
    WingHingeTable,
)
from flycontrol.io.quantities import (
    ANGLE,
    DENSITY,
    STIFFNESS,
    TIME,
    TORQUE,
    TORQUE_PER_RATE,
    WINGBEATS,
    Kind,
    read_quantity,
)
from flycontrol.io.toml_files import TomlFile
from flycontrol.model.flight_experiment import (
    FREEDOMS,
    Air,
    FlightTime,
    Freedom,
    Joint,
    TorqueJoint,
    TorquePulse,
    WingJoints,
)
from flycontrol.model.hinge import DampedSpring
from flycontrol.model.morphology import pitch_rotation
from flycontrol.model.stroke import Side

_AXES = {"roll": 0, "pitch": 1, "yaw": 2}
_OF_A_SPRING, _OF_A_TORQUE = ("stiffness", "damping", "rest_angle"), ("amplitude", "mean", "lead")
_JOINT_KINDS = {
    "stiffness": STIFFNESS,
    "damping": TORQUE_PER_RATE,
    "rest_angle": ANGLE,
    "amplitude": TORQUE,
    "mean": TORQUE,
    "lead": ANGLE,
}


@dataclass(frozen=True, slots=True, kw_only=True)
class FlightReader:
    """Reads the tables of one experiment; InvalidInputError with file and line for what cannot be meant."""

    toml: TomlFile
    stroke_plane_angle: float  #: [rad]

    def refusal(self, key: str, why: str, element: int | None = None) -> InvalidInputError:
        """Say why a key cannot be meant."""
        return InvalidInputError(f"{self._where(key, element)}: {key} {why}.")

    def quantity(self, written: object, kind: Kind, key: str, element: int | None = None) -> float:
        """Read a quantity of one kind, in SI units."""
        return read_quantity(written, kind, key=key, where=self._where(key, element)).value

    def deviation(self, written: object, kind: Kind, key: str) -> float:
        """Read a standard deviation."""
        value = self.quantity(written, kind, key)
        if not value >= 0:
            raise self.refusal(key, f"is '{written}'; a standard deviation is at least 0")
        return value

    def moment(self, written: object, key: str, element: int) -> FlightTime:
        """Read a time given in seconds or wingbeats."""
        time = read_quantity(written, WINGBEATS, TIME, key=key, where=self._where(key, element))
        return FlightTime(wingbeats=time.value) if time.kind is WINGBEATS else FlightTime(seconds=time.value)

    def span(self, written: object, key: str, element: int) -> FlightTime:
        """Read a time that is more than nothing."""
        time = self.moment(written, key, element)
        if not time.at(1.0) > 0:
            raise self.refusal(key, f"is '{written}'; a time longer than 0 s is needed", element)
        return time

    def air(self, table: AirTable) -> Air:
        """Read what the air does."""
        density = self.quantity(table.density, DENSITY, "air.density")
        return Air(terms=tuple(table.terms), coefficients=table.coefficients, density=density, nodes=table.nodes)

    def freedoms(self, table: BodyTable) -> tuple[Freedom, ...]:
        """Read what of the body is free, in the order of FREEDOMS."""
        if isinstance(table.free, str):
            free: dict[str, tuple[Freedom, ...]] = {"all": FREEDOMS, "yaw": ("yaw",), "none": ()}
            return free[table.free]
        return tuple(name for name in FREEDOMS if name in table.free)

    def joints(self, both: HingesTable, own: WingHingeTable, side: Side) -> WingJoints:
        """Read what moves the angles of one wing: its own table, else that of both."""
        return WingJoints(**{
            name: self._joint(getattr(own, name) or getattr(both, name), f"hinges.{side}.{name}")
            for name in ("stroke", "deviation", "pitch")
        })  # fmt: skip

    def pulse(self, table: PulseTable, element: int) -> TorquePulse:
        """Read a torque on the body."""
        torque = np.zeros(3)
        torque[_AXES[table.axis]] = self.quantity(table.torque, TORQUE, "pulse.torque", element)
        if table.frame == "body":
            torque = pitch_rotation(self.stroke_plane_angle) @ torque
        x, y, z = (float(component) for component in torque)
        return TorquePulse(
            onset=self.moment(table.onset, "pulse.onset", element),
            duration=self.span(table.duration, "pulse.duration", element),
            torque_S=(x, y, z),
        )

    def _joint(self, table: JointTable | None, key: str) -> Joint:
        if table is None or table.kind == "prescribed":
            return None
        own, foreign = (_OF_A_SPRING, _OF_A_TORQUE) if table.kind == "spring" else (_OF_A_TORQUE, _OF_A_SPRING)
        wrong = next((name for name in foreign if getattr(table, name) is not None), None)
        if wrong is not None:
            raise self.refusal(f"{key}.{wrong}", f"is not of a {table.kind}; it has {', '.join(own)}")
        if getattr(table, own[0]) is None:
            raise self.refusal(key, f"has no {own[0]}, which a {table.kind} needs")
        values = {
            name: self.quantity(getattr(table, name), _JOINT_KINDS[name], f"{key}.{name}")
            for name in own
            if getattr(table, name) is not None
        }
        return DampedSpring(**values) if table.kind == "spring" else TorqueJoint(**values)

    def _where(self, key: str, element: int | None) -> str:
        keys = key.split(".")
        return self.toml.where(*keys) if element is None else self.toml.where(keys[0], str(element), *keys[1:])
