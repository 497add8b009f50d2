"""Polynomial model: value = c0 + c1 T + ... + c6 T^6 by Horner's rule (Liu, Li, Shen, tables 1 and 2, orders 3 and 4).

`proofmass fit` finds the coefficients; those above the order are zero.
"""

from proofmass.blocks.declaration.declare import Input
from proofmass.blocks.parameter_sets.polynomial_coefficients import PolynomialCoefficients


class PolynomialModel(PolynomialCoefficients):
    """The value that a fitted polynomial of order 1 to 6 predicts at a temperature."""

    temperature = Input("{temperature_unit}", "Voltage of the temperature sensor, or the temperature.")


@PolynomialModel.output("{unit}")
def value(p: PolynomialModel, temperature: float) -> float:
    """The predicted value."""
    high = p.c3 + temperature * (p.c4 + temperature * (p.c5 + temperature * p.c6))
    return p.c0 + temperature * (p.c1 + temperature * (p.c2 + temperature * high))
