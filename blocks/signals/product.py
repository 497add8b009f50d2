"""Product of two signals: output = first * second."""

from proofmass.blocks.declaration.declare import Block, Input, param


class Product(Block):
    """Multiplier: a mixer, a modulator, a gain that is itself a signal."""

    first_unit: str = param("", "Unit of the first factor.", default="1")
    second_unit: str = param("", "Unit of the second factor.", default="1")

    first = Input("{first_unit}", "First factor.")
    second = Input("{second_unit}", "Second factor.")


@Product.output("({first_unit})*({second_unit})")
def output(p: Product, first: float, second: float) -> float:
    """The product."""
    return first * second
