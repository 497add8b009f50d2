"""Temperature law of two exponentials: value = nominal (1 + a1 exp(b1 V) + a2 exp(b2 V)), V of a temperature sensor.

With b1 < 0 < b2 it fits the bias of inertial sensors from cold to hot better than a polynomial of
third degree.
"""

from proofmass.blocks.declaration.declare import Block, Input, param
from proofmass.blocks.temperature.double_exponential_model import double_exponential


class TemperatureDoubleExponential(Block):
    """A parameter whose deviation is a falling and a rising exponential of the temperature sensor's voltage."""

    a1: float = param("1", "Relative deviation of the first exponential at 0 V.", default=4.82e-3)
    b1: float = param("1/V", "Exponent of the first exponential.", default=-6.0)
    a2: float = param("1", "Relative deviation of the second exponential at 0 V.", default=0.23e-3)
    b2: float = param("1/V", "Exponent of the second exponential.", default=1.5)
    nominal: float = param("{unit}", "Value without deviation.", default=1.0)
    unit: str = param("", "Unit of the value.", default="1")

    sensor_voltage = Input("V", "Voltage of the temperature sensor.")


def deviation_at(p: TemperatureDoubleExponential, voltage: float) -> float:
    """Relative deviation at a voltage of the sensor."""
    return double_exponential(p.a1, p.b1, p.a2, p.b2, voltage)


@TemperatureDoubleExponential.output("{unit}")
def value(p: TemperatureDoubleExponential, sensor_voltage: float) -> float:
    """Nominal value with the deviation applied."""
    return p.nominal * (1.0 + deviation_at(p, sensor_voltage))


@TemperatureDoubleExponential.output("1")
def deviation(p: TemperatureDoubleExponential, sensor_voltage: float) -> float:
    """The relative deviation."""
    return deviation_at(p, sensor_voltage)
