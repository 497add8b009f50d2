"""Digital-to-analog converter of weighted elements: voltage = (sum of b_i w_i - 2^(bits-1)) reference / 2^(bits-1).

b_i are the bits of clip(rint(number)) + 2^(bits-1), w_i = 2^i (1 + error_i). Weights that do not
match make INL and DNL, the largest where the highest bit changes (IEEE Std 1658, section 6).
"""

import math

from proofmass.blocks.arithmetic.bit_weights import bit_weights
from proofmass.blocks.arithmetic.rounding import nearest_integer, round_half_even, saturated
from proofmass.blocks.declaration.declare import Input, param
from proofmass.blocks.parameter_sets.weighted_elements import WeightedElements


class WeightedDigitalToAnalog(WeightedElements):
    """Digital-to-analog converter with the errors of its elements: typed, from a file, or drawn for a device."""

    reference: float = param("V", "Voltage of the code 2^(bits-1): half the span.", default=2.5, above=0.0)

    number = Input("1", "Number to convert; rounded half to even and saturated.")


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
