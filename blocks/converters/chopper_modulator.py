"""Chopper: output = input square, square = 1 for `half_period` ticks, then -1 for as many.

Two of them around an amplifier move its offset and 1/f noise to the chopping frequency (Enz and
Temes, Circuit techniques for reducing the effects of op-amp imperfections, Proc. IEEE 84, 1996).
"""

from typing import NamedTuple

from proofmass.blocks.declaration.declare import Block, Input, param


class ChopperModulator(Block):
    """Changes a signal's sign in turn: modulator, and demodulator with the same half period."""

    half_period: int = param("1", "Ticks between changes.", default=1, at_least=1, at_most=1_000_000_000)
    unit: str = param("", "Unit of input and output.", default="V")

    input = Input("{unit}", "Signal to chop.")


class State(NamedTuple):
    ticks: int  # since the last change
    negative: bool


@ChopperModulator.output("{unit}")
def output(p: ChopperModulator, x: State, input: float) -> float:
    """The chopped signal."""
    return -input if x.negative else input


@ChopperModulator.output("1")
def square(p: ChopperModulator, x: State) -> float:
    """The square wave, 1 or -1."""
    return -1.0 if x.negative else 1.0


@ChopperModulator.update
def update(p: ChopperModulator, x: State) -> State:
    if x.ticks + 1 < p.half_period:
        return State(x.ticks + 1, x.negative)
    return State(0, not x.negative)
