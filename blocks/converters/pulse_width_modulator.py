"""Pulse width modulator: output = high while input > carrier, else low; the carrier runs from -1 to 1 at `frequency`.

A sawtooth carrier rises all the period, a triangular one rises and falls; edges fall on ticks
(Holmes and Lipo, Pulse Width Modulation for Power Converters, 2003, chapter 3).
"""

import math
from typing import NamedTuple

from proofmass.blocks.declaration.declare import Block, Input, param


class PulseWidthModulator(Block):
    """Turns a signal between -1 and 1 into pulses whose duty is (1 + input) / 2."""

    frequency: float = param("Hz", "Frequency of the carrier; far below the rate.", default=100.0, above=0.0)
    triangular: bool = param("", "Whether the carrier is a triangle instead of a sawtooth.", default=False)
    low: float = param("{unit}", "Output between the pulses.", default=-1.0)
    high: float = param("{unit}", "Output during a pulse.", default=1.0)
    unit: str = param("", "Unit of the output.", default="V")

    input = Input("1", "Signal to modulate, from -1 to 1.")


class State(NamedTuple):
    turns: float  # of the carrier, from 0 to 1


class Constants(NamedTuple):
    turns: float
    triangular: bool
    low: float
    high: float


@PulseWidthModulator.constants
def constants(p: PulseWidthModulator, period: float) -> Constants:
    return Constants(p.frequency * period, p.triangular, p.low, p.high)


@PulseWidthModulator.output("1")
def on(c: Constants, x: State, input: float) -> bool:
    """True while a pulse is on."""
    return input > (1.0 - abs(4.0 * x.turns - 2.0) if c.triangular else 2.0 * x.turns - 1.0)


@PulseWidthModulator.output("{unit}")
def output(c: Constants, x: State, input: float) -> float:
    """The pulses."""
    return c.high if on(c, x, input) else c.low


@PulseWidthModulator.update
def update(c: Constants, x: State) -> State:
    turns = x.turns + c.turns
    return State(turns - float(math.floor(turns)))
