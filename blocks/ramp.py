"""Ramp source: output = offset + slope (t - start_time), held at the offset before the start."""

from proofmass.blocks.declare import Block, param


class Ramp(Block):
    """A value that grows linearly with time: a reference that drifts, a swept input."""

    offset: float = param(0.0, "{unit}", "Value until the start.")
    slope: float = param(1.0, "({unit})/s", "Growth per second after the start.")
    start_time: float = param(0.0, "s", "When the growth begins.", at_least=0.0)
    unit: str = param("1", "", "Unit of the output.")


@Ramp.output("{unit}")
def output(p: Ramp, time: float) -> float:
    """The ramp."""
    elapsed = time - p.start_time
    return p.offset + p.slope * (elapsed if elapsed > 0.0 else 0.0)
