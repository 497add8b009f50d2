"""Dead zone: output = input - highest above it, input - lowest below it, 0 between (Gelb and Vander Velde, 1968)."""

from collections.abc import Iterator

from proofmass.blocks.arithmetic.rounding import clip
from proofmass.blocks.declaration.declare import Block, Input, param


class DeadZone(Block):
    """Nothing until a threshold is passed, then what goes beyond it: crossover distortion, play of a valve."""

    lowest: float = param("{unit}", "Lower end of the zone.", default=-0.5)
    highest: float = param("{unit}", "Upper end of the zone.", default=0.5)
    unit: str = param("", "Unit of input and output.", default="1")

    input = Input("{unit}", "Signal to pass through the zone.")


@DeadZone.requires
def requires(p: DeadZone) -> Iterator[tuple[str, str]]:
    if p.lowest > p.highest:
        yield "lowest", f"at most highest = {p.highest:g}"


@DeadZone.output("{unit}")
def output(p: DeadZone, input: float) -> float:
    """Input less the edge of the zone; zero within it."""
    return input - clip(input, p.lowest, p.highest)


@DeadZone.corner
def above_lowest(p: DeadZone, input: float) -> float:
    return input - p.lowest


@DeadZone.corner
def above_highest(p: DeadZone, input: float) -> float:
    return input - p.highest
