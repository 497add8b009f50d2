"""Weighted elements of a converter, w_i = 2^i (1 + error_i): capacitors or current sources that do not match."""

from collections.abc import Iterator

from proofmass.blocks.declaration.declare import Buffer, param
from proofmass.blocks.parameter_sets.specimen import Specimen


class WeightedElements(Specimen):
    """Errors of the elements of a converter: typed, from a file, or drawn for a specimen."""

    bits: int = param("bit", "Resolution.", default=12, at_least=2, at_most=24)
    bit_errors: tuple[float, ...] = param("1", "Relative error of each weight, the highest bit first.", default=(0.0,))
    mismatch: float = param("1", "Standard deviation of a unit element, relative.", default=0.0, at_least=0.0)

    weights = Buffer("Weights in steps, the highest first.", float, ("bits",))


@WeightedElements.requires
def requires(p: WeightedElements) -> Iterator[tuple[str, str]]:
    if len(p.bit_errors) > p.bits:
        yield "bit_errors", f"at most {p.bits} numbers, as there are bits"
