"""Sine and cosine from a table: sin(2 pi (u + 1/2) / 2^P) for the phase word u = 2^P phase, to the nearest step.

A table of a quarter wave, 2^(P-2) words. Of a longer phase the bits that are cut off make spurs;
the worst is 2^-P x / sin x below the carrier, x = pi G / 2^B, for B bits cut off and G the greatest
common divisor of 2^B and the step of the phase (Nicholas and Samueli, Proc. 41st Annual Frequency
Control Symposium, 1987).
"""

from typing import NamedTuple

from proofmass.blocks.arithmetic.fixed_point import Fixed, FixedValue
from proofmass.blocks.arithmetic.quarter_wave import quarter_wave, sine_word
from proofmass.blocks.declaration.declare import Block, Input, param


class FixedSineTable(Block):
    """Sine and cosine of the phase of a FixedPhaseAccumulator, in one tick without a multiplier."""

    phase_bits: int = param("bit", "P, of the phase.", default=8, at_least=3, at_most=12)
    fraction_bits: int = param("bit", "M, of sine and cosine.", default=14, at_least=2, at_most=32)

    phase = Input("1", "Phase in turns, from -1/2 to 1/2.", dtype=FixedValue)


class Constants(NamedTuple):
    table: tuple[int, ...]


@FixedSineTable.formats
def formats(p: FixedSineTable) -> dict[str, Fixed]:
    output = Fixed(p.fraction_bits + 2, p.fraction_bits)
    return {"phase": Fixed(p.phase_bits, p.phase_bits), "sine": output, "cosine": output}


@FixedSineTable.constants
def constants(p: FixedSineTable, period: float) -> Constants:
    return Constants(quarter_wave(p.phase_bits, p.fraction_bits))


@FixedSineTable.output("1")
def sine(c: Constants, p: FixedSineTable, phase: FixedValue) -> FixedValue:
    """Sine of the phase and half a step."""
    return FixedValue(sine_word(c.table, phase.mantissa), p.fraction_bits)


@FixedSineTable.output("1")
def cosine(c: Constants, p: FixedSineTable, phase: FixedValue) -> FixedValue:
    """Cosine of the phase and half a step."""
    return FixedValue(sine_word(c.table, phase.mantissa + len(c.table)), p.fraction_bits)
