"""Switch: output = input while closed, else the leakage; closed while `control` is true, or false if normally closed.

As M1 of the digital quartz accelerometer, which adds the constant current to that of the coil
(section III.B, Fig. 7).
"""

from proofmass.blocks.declaration.declare import Block, Input, param


class AnalogSwitch(Block):
    """Lets a signal through on command."""

    leakage: float = param("{unit}", "Output while open.", default=0.0)
    normally_closed: bool = param("", "Whether the command opens it instead of closing it.", default=False)
    unit: str = param("", "Unit of input and output.", default="1")

    input = Input("{unit}", "Signal to switch.")
    control = Input("1", "The command.", dtype=bool, default=False)


@AnalogSwitch.output("{unit}")
def output(p: AnalogSwitch, input: float, control: bool) -> float:
    """The input, or the leakage."""
    return input if control != p.normally_closed else p.leakage
