"""Voltage-to-current converter: current = voltage / R (digital quartz accelerometer, section II.C.2, eq. 10)."""

from proofmass.blocks.declaration.declare import Block, Input, param


class VoltageToCurrent(Block):
    """Current through a coil, forced by the voltage across a sampling resistor that may drift."""

    resistance: float = param("ohm", "Sampling resistor.", default=342.0, above=0.0)

    voltage = Input("V", "Voltage that the current follows.")


@VoltageToCurrent.output("A")
def current(p: VoltageToCurrent, voltage: float) -> float:
    """The current."""
    return voltage / p.resistance
