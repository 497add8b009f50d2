"""Ramp source: output = offset + slope (t - start_time), held at the offset before the start."""

from proofmass.blocks.declaration.declare import Block, param


class Ramp(Block):
    """A value that grows linearly with time: a reference that drifts, a swept input."""

    offset: float = param("{unit}", "Value until the start.", default=0.0)
    slope: float = param(
        "({unit})/s",
        "Growth per second after the start.",
        default=1.0,
        not_driven="a slope that moves would move the growth before too: take a DiscreteIntegrator, which adds it up",
    )
    start_time: float = param("s", "Time at which the growth begins.", default=0.0, at_least=0.0)
    unit: str = param("", "Unit of the output.", default="1")


@Ramp.output("{unit}")
def output(p: Ramp, time: float) -> float:
    """The ramp."""
    elapsed = time - p.start_time
    return p.offset + p.slope * (elapsed if elapsed > 0.0 else 0.0)


@Ramp.corner
def begun(p: Ramp, time: float) -> float:
    return time - p.start_time
