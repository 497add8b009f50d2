"""Polynomial model: value = c0 + c1 T + ... + c6 T^6 by Horner's rule (Liu, Li, Shen, tables 1 and 2, orders 3 and 4).

`proofmass fit` finds the coefficients; those above the order are zero.
"""

from proofmass.blocks.declaration.declare import Block, Input, param


class PolynomialModel(Block):
    """The value that a fitted polynomial of order 1 to 6 predicts at a temperature."""

    c0: float = param("{unit}", "Value at zero temperature.", default=0.0)
    c1: float = param("({unit})/({temperature_unit})", "Coefficient of the temperature.", default=1.0)
    c2: float = param("({unit})/({temperature_unit})^2", "Of its square.", default=0.0)
    c3: float = param("({unit})/({temperature_unit})^3", "Of its third power.", default=0.0)
    c4: float = param("({unit})/({temperature_unit})^4", "Of its fourth power.", default=0.0)
    c5: float = param("({unit})/({temperature_unit})^5", "Of its fifth power.", default=0.0)
    c6: float = param("({unit})/({temperature_unit})^6", "Of its sixth power.", default=0.0)
    temperature_unit: str = param("", "Unit of the temperature: volts of a sensor, or kelvins.", default="V")
    unit: str = param("", "Unit of the value.", default="V")

    temperature = Input("{temperature_unit}", "Voltage of the temperature sensor, or the temperature.")


@PolynomialModel.output("{unit}")
def value(p: PolynomialModel, temperature: float) -> float:
    """The predicted value."""
    high = p.c3 + temperature * (p.c4 + temperature * (p.c5 + temperature * p.c6))
    return p.c0 + temperature * (p.c1 + temperature * (p.c2 + temperature * high))
