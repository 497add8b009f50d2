"""Flicker noise: value = nominal (1 + d); the one-sided power density of d is level^2 / f within the band.

White noise passes filters of first order (Keshner, Proc. IEEE 70, 212, 1982), poles two octaves
apart, zeros between: 1/f^2 above the band; in it at most 0.04 dB off up to a tenth of the rate,
0.16 dB up to half of it. Below it 1/f goes on for some two octaves, to 7.5 to 10.6 dB above
level^2 / lowest_frequency, flat below lowest_frequency / 32. Each is y = g u + (1 - g) w, w += a
(u - w), a = 1 - exp(-2 pi pole T), g = a / b, b = a (2 - a) for its zero. It starts at 0.
"""

import math
from collections.abc import Iterator
from typing import NamedTuple

from proofmass.blocks.arithmetic.elementary import binary_logarithm, exponential_less_one
from proofmass.blocks.declaration.declare import Block, Buffer, param
from proofmass.blocks.noise_and_drift.random_walk import deviation, value

ZERO, POLE = 0.41715495, 0.3249102  # of a filter that makes up for what sampling does to the ladder near half the rate


def poles(lowest: float, highest: float) -> int:
    """Number of poles that span the band and a factor of 4 at each end."""
    return 1 + math.ceil(0.5 * binary_logarithm(16.0 * highest / lowest))


class FlickerNoise(Block):
    """A parameter with bias instability: 1/f noise of amplifiers, references and readouts."""

    level: float = param("1", "Relative density of amplitude at 1 Hz times sqrt(Hz).", default=1.0e-6, at_least=0.0)
    lowest_frequency: float = param(
        "Hz", "Lower end of the band; 1/f goes on for two octaves.", default=1.0e-3, above=0.0
    )
    highest_frequency: float = param("Hz", "Frequency at which the band ends.", default=1.0e3, above=0.0)
    nominal: float = param("{unit}", "Value without deviation.", default=1.0)
    unit: str = param("", "Unit of the value.", default="1")

    slow = Buffer("w of each filter.", float, (lambda p: poles(p.lowest_frequency, p.highest_frequency),))


class State(NamedTuple):
    deviation: float
    delayed: float


class Constants(NamedTuple):
    white: float
    lowest: float  # a of the lowest pole
    nominal: float


@FlickerNoise.requires
def requires(p: FlickerNoise) -> Iterator[tuple[str, str]]:
    if not p.lowest_frequency < p.highest_frequency <= 1.0e15 * p.lowest_frequency:
        yield "highest_frequency", "above lowest_frequency, by 15 decades at most"


@FlickerNoise.constants
def constants(p: FlickerNoise, period: float) -> Constants:
    low, high = p.lowest_frequency, p.highest_frequency
    turns = math.sqrt(low) * math.sqrt(high) * period / (1 << (poles(low, high) - 1))  # of the lowest pole, a tick
    white = p.level / math.sqrt(math.sqrt(2.0) * turns) * (1.0 + POLE) / (1.0 + ZERO)
    return Constants(white, -exponential_less_one(-2.0 * math.pi * turns), p.nominal)


FlickerNoise.output("{unit}")(value)
FlickerNoise.output("1")(deviation)


@FlickerNoise.update
def update(c: Constants, x: State, slow: list[float], normal: float) -> State:
    u = first = c.white * normal + x.delayed
    a = c.lowest
    for i in range(len(slow)):
        b, w = a * (2.0 - a), slow[i]
        g = a / b if i < len(slow) - 1 else 0.0
        slow[i] = w + a * (u - w)
        u, a = g * u + (1.0 - g) * w, b * (2.0 - b)
    return State(u, ZERO * c.white * normal - POLE * first)
