"""Noise of a sampling switch: output = input + s n, s^2 = k T / C + (jitter slope)^2, n standard normal in every tick.

slope = (u[n] - u[n-1]) / period, and zero in tick 0. k T / C is the variance of one sample,
whatever the rate. Both errors are white, normal and independent, and so is their sum (Razavi,
Principles of Data Conversion System Design, 1995, chapter 2).
"""

import math
from typing import NamedTuple

from proofmass.blocks.declaration.declare import Block, Input, param

BOLTZMANN = 1.380649e-23  # J/K, exact in the SI


class SamplingNoise(Block):
    """Noise of the sampling capacitor, and of a clock with jitter: before an AnalogToDigital."""

    capacitance: float = param("F", "Sampling capacitor, C.", default=1e-12, above=0.0)
    temperature: float = param("K", "Absolute temperature, T.", default=300.0, at_least=0.0)
    jitter: float = param("s", "Standard deviation of the instant of sampling.", default=0.0, at_least=0.0)

    voltage = Input("V", "Signal to sample.")


class State(NamedTuple):
    before: float


class Constants(NamedTuple):
    variance: float
    jitter: float  # over the period


@SamplingNoise.constants
def constants(p: SamplingNoise, period: float) -> Constants:
    return Constants(BOLTZMANN * p.temperature / p.capacitance, p.jitter / period)


@SamplingNoise.output("V")
def output(c: Constants, x: State, voltage: float, normal: float, tick: int) -> float:
    """The sampled voltage."""
    moved = c.jitter * (voltage - x.before) if tick > 0 else 0.0  # the first sample has none before
    return voltage + math.sqrt(c.variance + moved * moved) * normal


@SamplingNoise.update
def update(c: Constants, x: State, voltage: float) -> State:
    return State(voltage)
