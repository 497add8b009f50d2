"""Sigma-delta modulator in registers: x_i[n+1] = x_i + g_i (x_(i-1) - f_i v), x_0 = u, v = the level nearest to x_n.

The twin of a SigmaDeltaModulator of order n: levels s (k - (2^B - 1) / 2), s = 2^(2-B), k from 0 to
2^B - 1. One bit gives 1 and -1, and the highest level is 2 - 2^(1-B). `resonance` takes so much of
the last integrator from the input of the one before. Products are exact, and rounded once into each
integrator (Schreier and Temes, chapter 4).
"""

from collections.abc import Iterator
from typing import NamedTuple

from proofmass.blocks.arithmetic.fixed_point import Fixed, FixedValue, Overflow, Rounding, clip, fixed
from proofmass.blocks.declaration.declare import Block, Buffer, Input, param


class FixedSigmaDeltaModulator(Block):
    """Modulator of order 1 to 4 in fixed point: a digital-to-analog converter of one bit, a fractional divider."""

    gains: tuple[float, ...] = param("1", "g of each integrator, the first at the input.", default=(0.5, 0.5))
    feedback: tuple[float, ...] = param("1", "f of each integrator.", default=(1.0, 1.0))
    resonance: float = param("1", "Part of the last integrator that goes back by one.", default=0.0, at_least=0.0)
    bits: int = param("bit", "B, of the quantiser.", default=1, at_least=1, at_most=8)
    input_format: Fixed = param("1", "Format of the input.", default=Fixed(16, 14))
    coefficient_format: Fixed = param("1", "Format of g, f and the resonance.", default=Fixed(12, 9))
    state_format: Fixed = param("1", "Format of the integrators.", default=Fixed(24, 18))
    rounding: Rounding = param("", "Rounding of the bits below the last.", default="half_even")
    overflow: Overflow = param("", "Handling of values beyond the range of the integrators.", default="saturate")

    input = Input("1", "Value to convert; 1 is the level of one bit.", dtype=FixedValue)

    integrators = Buffer("x, zero in tick 0.", FixedValue, ("gains",))


class Constants(NamedTuple):
    gains: tuple[FixedValue, ...]
    feedback: tuple[FixedValue, ...]
    resonance: FixedValue


@FixedSigmaDeltaModulator.requires
def requires(p: FixedSigmaDeltaModulator) -> Iterator[tuple[str, str]]:
    if len(p.gains) > 4:
        yield "gains", "at most 4 numbers"
    if len(p.feedback) != len(p.gains):
        yield "feedback", f"{len(p.gains)} numbers, as gains has"


@FixedSigmaDeltaModulator.formats
def formats(p: FixedSigmaDeltaModulator) -> dict[str, Fixed]:
    registers = {"input": p.input_format, "c": p.coefficient_format, "integrators": p.state_format}
    return registers | {"code": Fixed(p.bits, 0, signed=False), "output": Fixed(p.bits + 1, p.bits - 1)}


@FixedSigmaDeltaModulator.constants
def constants(p: FixedSigmaDeltaModulator, period: float) -> Constants:
    def rounded(values: tuple[float, ...]) -> tuple[FixedValue, ...]:
        return tuple(fixed(value, p.coefficient_format, "half_even") for value in values)

    return Constants(rounded(p.gains), rounded(p.feedback), *rounded((p.resonance,)))


@FixedSigmaDeltaModulator.output("1")
def code(c: Constants, p: FixedSigmaDeltaModulator, integrators: list[FixedValue]) -> FixedValue:
    """Number of the level, from 0: the bit of a modulator with one."""
    last, half = integrators[-1], 1 << (p.bits - 1)
    below = (last << (p.bits - 2)).to(Fixed(p.state_format.width + p.bits, 0), "floor", "wrap")
    return clip(below, -half, half - 1) + half  # type: ignore[no-any-return]


@FixedSigmaDeltaModulator.output("1")
def output(c: Constants, p: FixedSigmaDeltaModulator, integrators: list[FixedValue]) -> FixedValue:
    """The level."""
    number = code(c, p, integrators)
    return FixedValue(2 * number.mantissa - ((1 << p.bits) - 1), p.bits - 1)


@FixedSigmaDeltaModulator.update
def update(c: Constants, p: FixedSigmaDeltaModulator, integrators: list[FixedValue], input: FixedValue) -> None:
    level, before, last, order = output(c, p, integrators), input, integrators[-1], len(integrators)
    for i in range(order):
        now, entry = integrators[i], before - c.feedback[i] * level
        if i == order - 2:
            entry = entry - c.resonance * last
        integrators[i] = (now + c.gains[i] * entry).to(p.state_format, p.rounding, p.overflow)
        before = now
