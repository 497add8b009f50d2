"""Sign: output = 1 above zero, 0 at zero, -1 below."""

from proofmass.blocks.declaration.declare import Block, Input, param


class Sign(Block):
    """Ideal relay with a middle position: dry friction, a phase inverter. Comparator has two positions, and a bit."""

    unit: str = param("", "Unit of the input.", default="1")

    input = Input("{unit}", "Whose sign is taken.")


@Sign.output("1")
def output(p: Sign, input: float) -> float:
    """The sign of the input."""
    return 1.0 if input > 0.0 else -1.0 if input < 0.0 else 0.0


@Sign.corner
def above_zero(p: Sign, input: float) -> float:
    return input
