"""Digital-to-analog converter of weighted elements: voltage = (sum of b_i w_i - 2^(bits-1)) reference / 2^(bits-1).

b_i are the bits of clip(rint(number)) + 2^(bits-1), w_i = 2^i (1 + error_i). Weights that do not match make INL and
DNL, the largest where the highest bit changes (IEEE Std 1658, section 6).
"""

import math
from collections.abc import Iterator

from proofmass.blocks.arithmetic.bit_weights import bit_weights
from proofmass.blocks.arithmetic.rounding import nearest_integer, round_half_even, saturated
from proofmass.blocks.declaration.declare import Block, Buffer, Input, param


class WeightedDigitalToAnalog(Block):
    """Digital-to-analog converter with the errors of its elements: typed, from a file, or drawn for a device."""

    bits: int = param("bit", "Resolution.", default=12, at_least=2, at_most=24)
    reference: float = param("V", "Voltage of the code 2^(bits-1): half the span.", default=2.5, above=0.0)
    bit_errors: tuple[float, ...] = param("1", "Relative error of each weight, the highest bit first.", default=(0.0,))
    mismatch: float = param("1", "Standard deviation of a unit element, relative.", default=0.0, at_least=0.0)
    device: float = param(
        "1",
        "Whole number of the specimen, whose elements are drawn; studies spread it.",
        default=1.0,
        at_least=0.0,
        at_most=1e15,
    )

    number = Input("1", "Number to convert; rounded half to even and saturated.")

    weights = Buffer("Weights in steps, the highest first.", float, ("bits",))


@WeightedDigitalToAnalog.requires
def requires(p: WeightedDigitalToAnalog) -> Iterator[tuple[str, str]]:
    if len(p.bit_errors) > p.bits:
        yield "bit_errors", f"at most {p.bits} numbers, as there are bits"


@WeightedDigitalToAnalog.start
def start(p: WeightedDigitalToAnalog, weights: list[float]) -> None:
    weights[:] = bit_weights(p.bits, p.bit_errors, p.mismatch, math.floor(p.device))


@WeightedDigitalToAnalog.output("V")
def voltage(p: WeightedDigitalToAnalog, weights: list[float], number: float) -> float:
    """Voltage of the code."""
    half = float(1 << (p.bits - 1))
    inside = saturated(number, -half, half - 1.0)
    total, rest, ideal = round_half_even(inside), nearest_integer(inside) + half, half
    for i in range(len(weights)):
        bit = 1.0 if rest >= ideal else 0.0
        total += bit * (weights[i] - ideal)
        rest, ideal = rest - bit * ideal, 0.5 * ideal
    return total * (p.reference / half)
