"""Temperature sensor: voltage = V0 + s (T - T0) (Liu, Li, Shen, section 1; the figures are assumed).

Its noise is a WhiteNoise beside it.
"""

from proofmass.blocks.declaration.declare import Block, Input, param


class TemperatureSensor(Block):
    """A sensor whose voltage is proportional to the temperature, as on an accelerometer chip."""

    reference_voltage: float = param("V", "V0, voltage at the reference temperature.", default=1.2)
    slope: float = param("V/K", "s, voltage per temperature.", default=5.0e-3)
    reference_temperature: float = param("K", "T0, on the input's scale.", default=298.15)

    temperature = Input("K", "The temperature; in degrees Celsius too, if the reference is.")


@TemperatureSensor.output("V")
def voltage(p: TemperatureSensor, temperature: float) -> float:
    """Voltage of the sensor."""
    return p.reference_voltage + p.slope * (temperature - p.reference_temperature)
