"""First-order low-pass: x' = 2 pi f (gain u - x), gain / (1 + s / (2 pi f)); continuous."""

import math
from typing import NamedTuple

from proofmass.blocks.declare import Block, Input, param


class LowPass(Block):
    """Analog low-pass of first order: an RC filter, the bandwidth of an amplifier."""

    corner_frequency: float = param(20.0e3, "Hz", "Frequency at which the response is down by 3 dB.", above=0.0)
    gain: float = param(1.0, "({output_unit})/({input_unit})", "Output per input at rest.")
    input_unit: str = param("1", "", "Unit of the input.")
    output_unit: str = param("1", "", "Unit of the output.")

    input = Input("{input_unit}", "What is filtered.")


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
