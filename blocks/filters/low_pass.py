"""First-order low-pass: x' = 2 pi f (gain u - x), gain / (1 + s / (2 pi f)); continuous."""

import math
from typing import NamedTuple

from proofmass.blocks.declaration.declare import Block, Input, param


class LowPass(Block):
    """Analog low-pass of first order: an RC filter, the bandwidth of an amplifier."""

    corner_frequency: float = param("Hz", "Frequency at which the response is down by 3 dB.", default=20.0e3, above=0.0)
    gain: float = param("({output_unit})/({input_unit})", "Output per input at rest.", default=1.0)
    input_unit: str = param("", "Unit of the input.", default="1")
    output_unit: str = param("", "Unit of the output.", default="1")

    input = Input("{input_unit}", "Signal to filter.")


class State(NamedTuple):
    filtered: float


class Constants(NamedTuple):
    corner: float  # rad/s
    gain: float


@LowPass.constants
def constants(p: LowPass, period: float) -> Constants:
    return Constants(2.0 * math.pi * p.corner_frequency, p.gain)


@LowPass.output("{output_unit}")
def output(c: Constants, x: State) -> float:
    """The filtered signal."""
    return x.filtered


@LowPass.derivative(linear=True)
def derivative(c: Constants, x: State, input: float) -> State:
    return State(c.corner * (c.gain * input - x.filtered))
