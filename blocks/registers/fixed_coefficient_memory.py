"""Coefficient memory: four words, each = round(coefficient 2^f), for a1 exp(b1 T) + a2 exp(b2 T).

Figure 1 of Liu, Li and Shen has it beside the compensation. `proofmass fit --write` fills it with
physical values; the words are what the formats make of them. Where a factor is preloaded into a
CORDIC (FixedCordicScaledExponential), its word is divided by the growth of the rotations.
"""

from typing import NamedTuple

from proofmass.blocks.arithmetic.fixed_point import Fixed, FixedValue, fixed
from proofmass.blocks.declaration.declare import Block, param


class FixedCoefficientMemory(Block):
    """The memory of a digital temperature compensation: coefficients of a fit, as words."""

    a1: float = param("{unit}", "First exponential at zero temperature.", default=0.1764237)
    b1: float = param("1/({temperature_unit})", "Exponent of the first exponential.", default=-6.0)
    a2: float = param("{unit}", "Second exponential at zero temperature.", default=3.239676e-4)
    b2: float = param("1/({temperature_unit})", "Exponent of the second exponential.", default=1.5)
    growth: float = param("1", "Divisor of the factors: K = 0.82816 to preload.", default=1.0, above=0.0)
    factor_format: Fixed = param("1", "Format of a1 and a2.", default=Fixed(25, 24))
    exponent_format: Fixed = param("1", "Format of b1 and b2.", default=Fixed(21, 16))
    temperature_unit: str = param("", "Unit of the temperature: volts of a sensor, or kelvins.", default="V")
    unit: str = param("", "Unit of the sum of the exponentials.", default="V")


class Constants(NamedTuple):
    first_factor: FixedValue
    first_exponent: FixedValue
    second_factor: FixedValue
    second_exponent: FixedValue


@FixedCoefficientMemory.formats
def formats(p: FixedCoefficientMemory) -> dict[str, Fixed]:
    words = {"first_factor": p.factor_format, "first_exponent": p.exponent_format}
    words |= {"second_factor": p.factor_format, "second_exponent": p.exponent_format}
    return words | {f"c.{name}": word for name, word in words.items()}


@FixedCoefficientMemory.constants
def constants(p: FixedCoefficientMemory, period: float) -> Constants:
    factors = [fixed(a / p.growth, p.factor_format, "half_even") for a in (p.a1, p.a2)]
    exponents = [fixed(b, p.exponent_format, "half_even") for b in (p.b1, p.b2)]
    return Constants(factors[0], exponents[0], factors[1], exponents[1])


@FixedCoefficientMemory.output("{unit}")
def first_factor(c: Constants) -> FixedValue:
    """a1, divided by the growth."""
    return c.first_factor


@FixedCoefficientMemory.output("1/({temperature_unit})")
def first_exponent(c: Constants) -> FixedValue:
    """b1."""
    return c.first_exponent


@FixedCoefficientMemory.output("{unit}")
def second_factor(c: Constants) -> FixedValue:
    """a2, divided by the growth."""
    return c.second_factor


@FixedCoefficientMemory.output("1/({temperature_unit})")
def second_exponent(c: Constants) -> FixedValue:
    """b2."""
    return c.second_exponent
