"""Range reduction: exponent = octave ln 2 + remainder, 0 <= remainder < ln 2 (Liu, Li, Shen, eqs. 7 to 9, figure 2).

With z = exponent 2^M, C1 = round(2^M / ln 2) and C2 = round(2^M ln 2): A = z C1, octave = A >> 2M,
and remainder = (A[2M-1:M] C2) >> M. For -2^N <= exponent < 2^N the product takes 2M + N + 3 bits.
Rounding C1 to M bits makes the remainder wrong by up to |exponent| 2^-M / 2 / C1, which is the
larger part of the error of an exponential.
"""

from collections.abc import Iterator
from typing import NamedTuple

from proofmass.blocks.arithmetic.elementary import logarithm
from proofmass.blocks.arithmetic.fixed_point import Fixed, FixedValue, fixed
from proofmass.blocks.declaration.declare import Block, Input, param

MOST_BITS = 64  # of the product


class FixedRangeReducer(Block):
    """Splits the argument of an exponential into a power of two and what CORDIC converges for: two multipliers."""

    fraction_bits: int = param("1", "M, of exponent and remainder.", default=16, at_least=4, at_most=28)
    range_bits: int = param("1", "N: the exponent is from -2^N to 2^N.", default=6, at_least=0, at_most=16)

    exponent = Input("1", "Exponent to split.", dtype=FixedValue)


class Constants(NamedTuple):
    reciprocal: FixedValue
    ln2: FixedValue
    product: Fixed
    octave: Fixed
    remainder: Fixed


@FixedRangeReducer.requires
def requires(p: FixedRangeReducer) -> Iterator[tuple[str, str]]:
    if 2 * p.fraction_bits + p.range_bits + 3 > MOST_BITS:
        yield "fraction_bits", f"2 M + N + 3 at most {MOST_BITS}, the bits of the product"


@FixedRangeReducer.formats
def formats(p: FixedRangeReducer) -> dict[str, Fixed]:
    return {
        "exponent": Fixed(p.range_bits + p.fraction_bits + 1, p.fraction_bits),
        "octave": Fixed(p.range_bits + 2),
        "remainder": Fixed(p.fraction_bits, p.fraction_bits, signed=False),
    }


@FixedRangeReducer.constants
def constants(p: FixedRangeReducer, period: float) -> Constants:
    bits, known = p.fraction_bits, formats(p)
    reciprocal = fixed(1.0 / logarithm(2.0), Fixed(bits + 2, bits), "half_even")
    ln2 = fixed(logarithm(2.0), Fixed(bits + 1, bits), "half_even")
    return Constants(reciprocal, ln2, Fixed(2 * bits + p.range_bits + 3, 2 * bits), known["octave"], known["remainder"])


@FixedRangeReducer.output("1")
def octave(c: Constants, p: FixedRangeReducer, exponent: FixedValue) -> FixedValue:
    """The power of two: the exponent divided by ln 2, rounded down."""
    return _product(c, exponent).to(c.octave, "floor", "refuse")


@FixedRangeReducer.output("1")
def remainder(c: Constants, p: FixedRangeReducer, exponent: FixedValue) -> FixedValue:
    """Remainder, below ln 2."""
    upper_half = (_product(c, exponent).mantissa >> p.fraction_bits) & ((1 << p.fraction_bits) - 1)
    return (FixedValue(upper_half, p.fraction_bits) * c.ln2).to(c.remainder, "floor", "refuse")


def _product(c: Constants, exponent: FixedValue) -> FixedValue:
    return (exponent * c.reciprocal).to(c.product, overflow="refuse")
