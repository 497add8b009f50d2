"""Switch: output = first while `choose_first` is true, else second."""

from proofmass.blocks.declaration.declare import Block, Input, param


class Switch(Block):
    """Selector of one of two signals by a bit. AnalogSwitch is the part, with leakage."""

    unit: str = param("", "Unit of signals and output.", default="1")

    first = Input("{unit}", "Signal while the bit is true.")
    second = Input("{unit}", "Signal while the bit is false.")
    choose_first = Input("1", "Which one.", dtype=bool)


@Switch.output("{unit}")
def output(p: Switch, first: float, second: float, choose_first: bool) -> float:
    """The chosen signal."""
    return first if choose_first else second
