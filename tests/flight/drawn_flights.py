"""Flights drawn at random, importable by worker processes."""

from dataclasses import replace

import numpy as np
from simulated_fly import FLY, FREQUENCY, MELANOGASTER, SYMMETRIC

from flycontrol.flight.ensemble import FlightPlan
from flycontrol.flight.pulses import BodyPulse


def draw(generator: np.random.Generator) -> FlightPlan:
    fly = replace(FLY, morphology=replace(MELANOGASTER, mass=1.1e-6 * generator.uniform(0.9, 1.1)))
    pulse = BodyPulse(start=0.0, duration=1 / FREQUENCY, torque_S=(0.0, 0.0, generator.normal() * 1e-10))
    return FlightPlan(fly=fly, stroke=SYMMETRIC, pulses=(pulse,))
