"""Vector of signals: output = (first, second, third, fourth), as many of them as `size` says."""

from proofmass.blocks.declaration.declare import Block, Input, param


class VectorJoin(Block):
    """Joins up to four signals of one unit to a vector: multiplexer, components of a field."""

    size: int = param("1", "Components.", default=3, at_least=1, at_most=4)
    unit: str = param("", "Unit of the components.", default="1")

    first = Input("{unit}", "First component.")
    second = Input("{unit}", "Second component.", default=0.0)
    third = Input("{unit}", "Third component.", default=0.0)
    fourth = Input("{unit}", "Fourth component.", default=0.0)


@VectorJoin.output("{unit}", shape=("size",), dtype=float)
def output(p: VectorJoin, first: float, second: float, third: float, fourth: float, out: list[float]) -> None:
    """The vector."""
    for k in range(len(out)):
        out[k] = first if k == 0 else second if k == 1 else third if k == 2 else fourth
