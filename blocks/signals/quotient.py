"""Quotient of two signals: output = numerator / d, d the denominator, but at least `smallest` away from zero.

Where |denominator| < smallest, d is smallest with the sign of the denominator, plus at zero: the
output stays finite.
"""

from proofmass.blocks.declaration.declare import Block, Input, param


class Quotient(Block):
    """Division of two signals with a guard against zero: normalisation by an amplitude, a ratio of readouts."""

    smallest: float = param("{denominator_unit}", "Smallest size of the divisor.", default=1e-12, above=0.0)
    numerator_unit: str = param("", "Unit of the numerator.", default="1")
    denominator_unit: str = param("", "Unit of the denominator.", default="1")

    numerator = Input("{numerator_unit}", "Number to divide.")
    denominator = Input("{denominator_unit}", "Number to divide by.")


@Quotient.output("({numerator_unit})/({denominator_unit})")
def output(p: Quotient, numerator: float, denominator: float) -> float:
    """The quotient."""
    if -p.smallest < denominator < p.smallest:
        return numerator / (-p.smallest if denominator < 0.0 else p.smallest)
    return numerator / denominator


@Quotient.corner
def above_guard(p: Quotient, denominator: float) -> float:
    return denominator - p.smallest


@Quotient.corner
def below_guard(p: Quotient, denominator: float) -> float:
    return denominator + p.smallest


@Quotient.corner
def above_zero(p: Quotient, denominator: float) -> float:
    return denominator
