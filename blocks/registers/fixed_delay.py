"""Fixed-point delay: output[n] = input[n - ticks], zero before, by as many registers: z^-ticks."""

from proofmass.blocks.arithmetic.fixed_point import Fixed, FixedValue
from proofmass.blocks.declaration.declare import Block, Buffer, Input, param


class FixedDelay(Block):
    """Registers in series: what goes beside a pipeline leaves with what went through it."""

    format: Fixed = param("1", "Format of input and output.", default=Fixed(16, 12))
    ticks: int = param("1", "Registers.", default=1, at_least=1, at_most=256)
    unit: str = param("", "Unit of input and output.", default="1")

    input = Input("{unit}", "Signal to delay.", dtype=FixedValue)

    held = Buffer("Inputs of the ticks before, newest first, zero in tick 0.", FixedValue, ("ticks",))


@FixedDelay.formats
def formats(p: FixedDelay) -> dict[str, Fixed]:
    return {"input": p.format, "held": p.format, "output": p.format}


@FixedDelay.output("{unit}")
def output(p: FixedDelay, held: list[FixedValue]) -> FixedValue:
    """The input so many ticks before."""
    return held[-1]


@FixedDelay.update
def update(p: FixedDelay, held: list[FixedValue], input: FixedValue) -> None:
    for i in range(len(held) - 1, 0, -1):
        held[i] = held[i - 1]
    held[0] = input
