"""Component of a vector: output = vector[index]."""

from collections.abc import Iterator

from proofmass.blocks.declaration.declare import Block, Input, param


class VectorElement(Block):
    """Takes one component out of a vector: demultiplexer, one lag of an impulse response."""

    size: int = param("1", "Components of the vector.", default=3, at_least=1, at_most=4096)
    index: int = param("1", "Which of them, from 0.", default=0, at_least=0)
    unit: str = param("", "Unit of the components.", default="1")

    vector = Input("{unit}", "The vector.", shape=("size",))


@VectorElement.requires
def requires(p: VectorElement) -> Iterator[tuple[str, str]]:
    if p.index >= p.size:
        yield "index", f"less than size = {p.size}"


@VectorElement.output("{unit}")
def output(p: VectorElement, vector: list[float]) -> float:
    """The component."""
    return vector[p.index]
