"""Gain: output = gain * input, with units of its own."""

from proofmass.blocks.declaration.declare import Block, Input, param


class Gain(Block):
    """Linear gain between any two units: an amplifier, a torquer, a resistor that turns voltage into current."""

    gain: float = param("({output_unit})/({input_unit})", "Output per input.", default=1.0)
    input_unit: str = param("", "Unit of the input.", default="1")
    output_unit: str = param("", "Unit of the output.", default="1")

    input = Input("{input_unit}", "Signal to amplify.")


@Gain.output("{output_unit}")
def output(p: Gain, input: float) -> float:
    """The input times the gain."""
    return p.gain * input
