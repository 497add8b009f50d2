"""Phase accumulator in fixed point: phase[n+1] = phase[n] + frequency T + control[n], in turns, modulo one turn.

The register has as many bits below the point as in all, so that its overflow is the whole turn:
frequencies are exact to the rate over 2^width. Of the phase the upper bits go on, to a
FixedCordicRotation or a table; what is cut off makes spurs about 6 dB a bit below the carrier
(Tierney, Rader and Gold, IEEE Trans. Audio 19, 1971).
"""

import math
from typing import NamedTuple

from proofmass.blocks.arithmetic.fixed_point import Fixed, FixedValue
from proofmass.blocks.declaration.declare import Block, Input, param


class FixedPhaseAccumulator(Block):
    """Phase of a numerically controlled oscillator in a register, from -1/2 to 1/2 of a turn."""

    frequency: float = param("Hz", "Frequency without control, or its alias below half the rate.", default=1000.0)
    width: int = param("bit", "Bits of the register.", default=32, at_least=2, at_most=48)
    control_format: Fixed = param("1", "Format of the control, in turns a tick.", default=Fixed(16, 24))
    output_bits: int = param("bit", "Upper bits of the phase that go on.", default=16, at_least=1, at_most=48)

    control = Input("1", "Turns that are added in this tick.", dtype=FixedValue)


class State(NamedTuple):
    phase: FixedValue


class Constants(NamedTuple):
    step: FixedValue


def register(p: FixedPhaseAccumulator) -> Fixed:
    """Format of the phase: from -1/2 to 1/2."""
    return Fixed(p.width, p.width)


@FixedPhaseAccumulator.formats
def formats(p: FixedPhaseAccumulator) -> dict[str, Fixed]:
    formats = {"control": p.control_format, "c.step": register(p), "x.phase": register(p)}
    return formats | {"phase": Fixed(p.output_bits, p.output_bits)}


@FixedPhaseAccumulator.constants
def constants(p: FixedPhaseAccumulator, period: float) -> Constants:
    turns = 1 << p.width
    steps = math.floor(p.frequency * period * turns + 0.5)
    return Constants(FixedValue((steps + turns // 2) % turns - turns // 2, p.width))


@FixedPhaseAccumulator.output("1")
def phase(c: Constants, p: FixedPhaseAccumulator, x: State) -> FixedValue:
    """Upper bits of the phase, in turns."""
    return x.phase.to(Fixed(p.output_bits, p.output_bits), "floor", "wrap")


@FixedPhaseAccumulator.update
def update(c: Constants, p: FixedPhaseAccumulator, x: State, control: FixedValue) -> State:
    return State((x.phase + c.step + control).to(register(p), "floor", "wrap"))
