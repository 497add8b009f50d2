"""Hall element: voltage = sensitivity current field + offset (Popovic, Hall Effect Devices, 2004, section 4.2)."""

from proofmass.blocks.declaration.declare import Block, Input, param


class HallElement(Block):
    """Plate whose voltage is the product of its current and the field; spinning the current takes its offset out."""

    sensitivity: float = param("V/(A*T)", "Voltage per current and field.", default=100.0)
    offset: float = param("V/A", "Voltage per current without a field.", default=0.0)

    current = Input("A", "Current through the plate.")
    field = Input("T", "Magnetic flux density across the plate.")


@HallElement.output("V")
def voltage(p: HallElement, current: float, field: float) -> float:
    """Hall voltage."""
    return (p.sensitivity * field + p.offset) * current
