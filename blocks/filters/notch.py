"""Notch: H(z) = g (1 - 2 cos(w) z^-1 + z^-2) / (1 - 2 g cos(w) z^-1 + (2g - 1) z^-2), w = 2 pi f T.

g = 1 / (1 + tan(w / (2 quality))); f / quality is the band in which it is down by 3 dB or more
(Orfanidis, Introduction to Signal Processing, section 11.3). `band` is what the notch takes out:
1 - H, a resonator with gain 1 at f.
"""

import math
from typing import NamedTuple

from proofmass.blocks.arithmetic.elementary import cosine, tangent
from proofmass.blocks.declaration.declare import Block, Input, param


class Notch(Block):
    """Takes one frequency out of a signal: mains, a structural mode in a control loop; `band` is that frequency."""

    frequency: float = param("Hz", "Frequency to take out; less than half the rate.", default=50.0, above=0.0)
    quality: float = param("1", "Frequency over bandwidth.", default=30.0, above=0.5)
    unit: str = param("", "Unit of input and output.", default="1")

    input = Input("{unit}", "Signal to filter.")


class State(NamedTuple):
    first: float
    second: float


class Constants(NamedTuple):
    gain: float
    b1: float
    a2: float


@Notch.constants
def constants(p: Notch, period: float) -> Constants:
    w = 2.0 * math.pi * p.frequency * period
    gain = 1.0 / (1.0 + tangent(0.5 * w / p.quality))
    return Constants(gain, -2.0 * gain * cosine(w), 2.0 * gain - 1.0)


@Notch.output("{unit}")
def output(c: Constants, x: State, input: float) -> float:
    """The signal without the frequency."""
    return c.gain * input + x.first


@Notch.output("{unit}")
def band(c: Constants, x: State, input: float) -> float:
    """The part of the signal at the frequency."""
    return input - (c.gain * input + x.first)


@Notch.update
def update(c: Constants, x: State, input: float) -> State:
    y = c.gain * input + x.first
    return State(c.b1 * (input - y) + x.second, c.gain * input - c.a2 * y)
