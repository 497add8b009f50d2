"""Ageing by Arrhenius' law: value = nominal (1 + d), d' = pace exp(activation_energy / k (1 / T0 - 1 / T)).

k is Boltzmann's constant, T the temperature, held from tick to tick, T0 the reference temperature.
"""

from typing import NamedTuple

from proofmass.blocks.arithmetic.elementary import bounded_exponential
from proofmass.blocks.declaration.declare import Block, Input, param
from proofmass.blocks.noise_and_drift.random_walk import deviation, value

BOLTZMANN = 1.380649e-23  # J/K, exact in the SI


class ArrheniusAgeing(Block):
    """A parameter that ages steadily, faster when hotter: diffusion, outgassing, creep."""

    pace: float = param("1/s", "Relative deviation per second at the reference temperature.", default=1.0e-12)
    activation_energy: float = param(
        "J", "1 eV is 1.602e-19 J.", default=1.1215236438e-19, at_least=0.0, at_most=1.0e-18
    )
    reference_temperature: float = param("K", "Temperature of the stated pace.", default=298.15, at_least=100.0)
    start_deviation: float = param("1", "Relative deviation at the start.", default=0.0)
    nominal: float = param("{unit}", "Value when new.", default=1.0)
    unit: str = param("", "Unit of the value.", default="1")

    temperature = Input("K", "Absolute temperature; below 1 K nothing ages.")


class State(NamedTuple):
    deviation: float


class Constants(NamedTuple):
    step: float
    energy: float  # K
    at_reference: float
    nominal: float


@ArrheniusAgeing.constants
def constants(p: ArrheniusAgeing, period: float) -> Constants:
    energy = p.activation_energy / BOLTZMANN
    return Constants(p.pace * period, energy, energy / p.reference_temperature, p.nominal)


@ArrheniusAgeing.start
def start(p: ArrheniusAgeing) -> State:
    return State(p.start_deviation)


def acceleration_at(c: Constants, temperature: float) -> float:
    """Acceleration factor: speed of ageing relative to that at the reference temperature."""
    return 0.0 if temperature < 1.0 else bounded_exponential(c.at_reference - c.energy / temperature)


ArrheniusAgeing.output("{unit}")(value)
ArrheniusAgeing.output("1")(deviation)


@ArrheniusAgeing.output("1")
def acceleration(c: Constants, temperature: float) -> float:
    """Acceleration factor: speed of ageing relative to that at the reference temperature."""
    return acceleration_at(c, temperature)


@ArrheniusAgeing.update
def update(c: Constants, x: State, temperature: float) -> State:
    return State(x.deviation + c.step * acceleration_at(c, temperature))
