"""Coefficients of c0 + c1 T + ... + c6 T^6 (Liu, Li, Shen, tables 1 and 2)."""

from proofmass.blocks.declaration.declare import Block, param


class PolynomialCoefficients(Block):
    """Coefficients of a polynomial of order 1 to 6 in a temperature."""

    c0: float = param("{unit}", "Value at zero temperature.", default=0.0)
    c1: float = param("({unit})/({temperature_unit})", "Coefficient of the temperature.", default=1.0)
    c2: float = param("({unit})/({temperature_unit})^2", "Coefficient of its square.", default=0.0)
    c3: float = param("({unit})/({temperature_unit})^3", "Coefficient of its third power.", default=0.0)
    c4: float = param("({unit})/({temperature_unit})^4", "Coefficient of its fourth power.", default=0.0)
    c5: float = param("({unit})/({temperature_unit})^5", "Coefficient of its fifth power.", default=0.0)
    c6: float = param("({unit})/({temperature_unit})^6", "Coefficient of its sixth power.", default=0.0)
    temperature_unit: str = param("", "Unit of the temperature: volts of a sensor, or kelvins.", default="V")
    unit: str = param("", "Unit of the value.", default="V")
