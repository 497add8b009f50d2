"""Successive-approximation converter: code = sum of the bits kept, each where v + reference still reaches its sum.

From the highest bit on, bit i is kept where (v + noise + reference) / lsb + 1/2 >= the weights kept
so far + w_i. With weights w_i = 2^i that is the nearest code; weights that do not match make INL
and DNL (IEEE Std 1241, section 6).
"""

import math

from proofmass.blocks.arithmetic.bit_weights import bit_weights
from proofmass.blocks.arithmetic.rounding import nearest_integer, round_half_even, saturated
from proofmass.blocks.declaration.declare import Input, param
from proofmass.blocks.parameter_sets.weighted_elements import WeightedElements


class SuccessiveApproximation(WeightedElements):
    """Analog-to-digital converter with the errors of its capacitors: typed, from a file, or drawn for a device."""

    reference: float = param("V", "Half the span.", default=2.5, above=0.0)
    noise: float = param("V", "Standard deviation of the comparator's noise.", default=0.0, at_least=0.0)

    voltage = Input("V", "Voltage to convert.")


@SuccessiveApproximation.start
def start(p: SuccessiveApproximation, weights: list[float]) -> None:
    weights[:] = bit_weights(p.bits, p.bit_errors, p.mismatch, math.floor(p.device))


def kept(p: SuccessiveApproximation, weights: list[float], steps: float) -> float:
    """The code for an input in steps: that of the search, but with the slope of a quantiser, which is one."""
    half = 1 << (p.bits - 1)
    rest, code, ideal = steps + float(half) + 0.5, 0, float(half)
    for i in range(len(weights)):
        bit = 1 if rest >= weights[i] else 0
        rest, steps = rest - float(bit) * weights[i], steps - float(bit) * (weights[i] - ideal)
        code, ideal = 2 * code + bit, 0.5 * ideal
    inside = saturated(steps, -float(half), float(half - 1))
    return round_half_even(inside) + (float(code - half) - nearest_integer(inside))


@SuccessiveApproximation.output("1")
def number(p: SuccessiveApproximation, weights: list[float], voltage: float, normal: float) -> float:
    """Output code as a number, for blocks that compute with numbers."""
    return kept(p, weights, (voltage + p.noise * normal) / p.reference * float(1 << (p.bits - 1)))


@SuccessiveApproximation.output("1")
def code(p: SuccessiveApproximation, weights: list[float], voltage: float, normal: float) -> int:
    """Output code, from -2^(bits-1) to 2^(bits-1) - 1."""
    return int(number(p, weights, voltage, normal))
