"""Saturation: output = input held between lowest and highest."""

from collections.abc import Iterator

from proofmass.blocks.arithmetic.rounding import clip
from proofmass.blocks.declaration.declare import Block, Input, param


class Saturation(Block):
    """Limits of a signal: the supply rails of an amplifier, the range of an actuator."""

    lowest: float = param("{unit}", "Lower limit.", default=-1.0)
    highest: float = param("{unit}", "Upper limit.", default=1.0)
    unit: str = param("", "Unit of input and output.", default="1")

    input = Input("{unit}", "Signal to limit.")


@Saturation.requires
def requires(p: Saturation) -> Iterator[tuple[str, str]]:
    if p.lowest >= p.highest:
        yield "lowest", f"less than highest = {p.highest:g}"


@Saturation.output("{unit}")
def output(p: Saturation, input: float) -> float:
    """The input within the limits."""
    return clip(input, p.lowest, p.highest)


@Saturation.corner
def above_lowest(p: Saturation, input: float) -> float:
    return input - p.lowest


@Saturation.corner
def above_highest(p: Saturation, input: float) -> float:
    return input - p.highest
