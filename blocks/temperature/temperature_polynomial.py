"""Temperature coefficients: value = nominal (1 + tc1 (T - T0) + tc2 (T - T0)^2), T0 the reference temperature."""

from proofmass.blocks.declaration.declare import Block, Input, param


class TemperaturePolynomial(Block):
    """A parameter that follows the temperature by its data-sheet coefficients."""

    tc1: float = param("1/K", "Relative deviation per kelvin.", default=11.0e-6)
    tc2: float = param("1/K^2", "Relative deviation per square kelvin.", default=0.0)
    reference_temperature: float = param("K", "Temperature without deviation, on the input's scale.", default=298.15)
    nominal: float = param("{unit}", "Value without deviation.", default=1.0)
    unit: str = param("", "Unit of the value.", default="1")

    temperature = Input("K", "The temperature; in degrees Celsius too, if the reference is.")


def deviation_at(p: TemperaturePolynomial, temperature: float) -> float:
    """Relative deviation at a temperature."""
    above = temperature - p.reference_temperature
    return (p.tc1 + p.tc2 * above) * above


@TemperaturePolynomial.output("{unit}")
def value(p: TemperaturePolynomial, temperature: float) -> float:
    """Nominal value with the deviation applied."""
    return p.nominal * (1.0 + deviation_at(p, temperature))


@TemperaturePolynomial.output("1")
def deviation(p: TemperaturePolynomial, temperature: float) -> float:
    """The relative deviation."""
    return deviation_at(p, temperature)
