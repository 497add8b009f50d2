"""One-bit actuator: output = +level for a one, -level for a zero (Sarraf et al. 2012, section 2.1)."""

from proofmass.blocks.declaration.declare import Block, Input, param


class OneBitActuator(Block):
    """Turns the bits of a pseudorandom sequence into a force of two levels, or into a voltage with `unit` V."""

    level: float = param("{unit}", "Size of the output, whatever the bit.", default=1.0e-6, above=0.0)
    unit: str = param("", "Unit of the output.", default="N")

    bit = Input("1", "Bit to convert.", dtype=bool)


@OneBitActuator.output("{unit}")
def output(p: OneBitActuator, bit: bool) -> float:
    """The level, with the sign of the bit."""
    return p.level if bit else -p.level
