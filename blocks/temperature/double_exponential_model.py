"""Double-exponential model: value = a1 exp(b1 T) + a2 exp(b2 T) (Liu, Li, Shen, eq. 1), T a temperature or its voltage.

`proofmass fit` finds the coefficients. Taken off the output of a sensor by a Difference it is the
compensation in floating point.
"""

from proofmass.blocks.arithmetic.elementary import bounded_exponential
from proofmass.blocks.declaration.declare import Block, Input, param


class DoubleExponentialModel(Block):
    """The value that a fitted sum of two exponentials predicts at a temperature."""

    a1: float = param("{unit}", "First exponential at zero temperature.", default=0.1764237)
    b1: float = param("1/({temperature_unit})", "Exponent of the first exponential.", default=-6.0)
    a2: float = param("{unit}", "Second exponential at zero temperature.", default=3.239676e-4)
    b2: float = param("1/({temperature_unit})", "Exponent of the second exponential.", default=1.5)
    temperature_unit: str = param("", "Unit of the temperature: volts of a sensor, or kelvins.", default="V")
    unit: str = param("", "Unit of the value.", default="V")

    temperature = Input("{temperature_unit}", "Voltage of the temperature sensor, or the temperature.")


def double_exponential(a1: float, b1: float, a2: float, b2: float, temperature: float) -> float:
    """The sum of the two exponentials."""
    return a1 * bounded_exponential(b1 * temperature) + a2 * bounded_exponential(b2 * temperature)


@DoubleExponentialModel.output("{unit}")
def value(p: DoubleExponentialModel, temperature: float) -> float:
    """The predicted value."""
    return double_exponential(p.a1, p.b1, p.a2, p.b2, temperature)
