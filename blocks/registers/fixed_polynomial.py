"""Polynomial in fixed point: value = c0 + T (c1 + T (c2 + ...)) by Horner's rule, order 1 to 6, rounded in every step.

What Liu, Li and Shen compare their exponentials with (tables 1 and 2), and PolynomialModel in registers: `proofmass
fit --write` finds the coefficients. Each order is one multiplier.
"""

from collections.abc import Iterator
from typing import NamedTuple

from proofmass.blocks.arithmetic.fixed_point import Fixed, FixedValue, Overflow, Rounding, fixed
from proofmass.blocks.declaration.declare import Input, param
from proofmass.blocks.parameter_sets.polynomial_coefficients import PolynomialCoefficients


class FixedPolynomial(PolynomialCoefficients):
    """The value that a fitted polynomial predicts at a temperature, in fixed point."""

    order: int = param("1", "Order; coefficients above it are zero.", default=6, at_least=1, at_most=6)
    c1: float = param("({unit})/({temperature_unit})", "Coefficient of the temperature.", default=0.5)
    input_format: Fixed = param("1", "Format of the temperature.", default=Fixed(18, 16))
    sum_format: Fixed = param("1", "Format of coefficients, sums and value.", default=Fixed(28, 24))
    rounding: Rounding = param("", "Rounding of the bits below the last.", default="half_even")
    overflow: Overflow = param("", "Handling of values beyond the range of the sums.", default="saturate")

    temperature = Input(
        "{temperature_unit}", "Voltage of the temperature sensor, or the temperature.", dtype=FixedValue
    )


class Constants(NamedTuple):
    coefficients: tuple[FixedValue, ...]


@FixedPolynomial.requires
def requires(p: FixedPolynomial) -> Iterator[tuple[str, str]]:
    for k, coefficient in enumerate(_coefficients(p)):
        if k > p.order and coefficient != 0.0:
            yield f"c{k}", f"0, as the order is {p.order}"


@FixedPolynomial.formats
def formats(p: FixedPolynomial) -> dict[str, Fixed]:
    return {"temperature": p.input_format, "c.coefficients": p.sum_format, "value": p.sum_format}


@FixedPolynomial.constants
def constants(p: FixedPolynomial, period: float) -> Constants:
    kept = _coefficients(p)[: p.order + 1]
    return Constants(tuple(fixed(each, p.sum_format, "half_even") for each in kept))


@FixedPolynomial.output("{unit}")
def value(c: Constants, p: FixedPolynomial, temperature: FixedValue) -> FixedValue:
    """The predicted value."""
    total = c.coefficients[-1]
    for coefficient in c.coefficients[-2::-1]:
        total = (total * temperature + coefficient).to(p.sum_format, p.rounding, p.overflow)
    return total


def _coefficients(p: FixedPolynomial) -> tuple[float, ...]:
    return p.c0, p.c1, p.c2, p.c3, p.c4, p.c5, p.c6
