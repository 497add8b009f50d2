"""Dot product: output = weights[0] vector[0] + weights[1] vector[1] + ..., added in this order."""

from proofmass.blocks.declaration.declare import Block, Buffer, Input, param


class DotProduct(Block):
    """Weighted sum of the components of a vector: a matrix row, a correlation with a response."""

    weights: tuple[float, ...] = param(
        "({output_unit})/({input_unit})", "Weight of each component.", default=(1.0, 1.0, 1.0)
    )
    input_unit: str = param("", "Unit of the components.", default="1")
    output_unit: str = param("", "Unit of the output.", default="1")

    vector = Input("{input_unit}", "The vector.", shape=("weights",))

    factors = Buffer("The weights.", float, ("weights",))


@DotProduct.start
def start(p: DotProduct, factors: list[float]) -> None:
    factors[:] = p.weights


@DotProduct.output("{output_unit}")
def output(p: DotProduct, factors: list[float], vector: list[float]) -> float:
    """The sum."""
    total = 0.0
    for k in range(len(factors)):
        total += factors[k] * vector[k]
    return total
