"""Linear drift: value = nominal (1 + slope (t - start_time)), the nominal value before."""

from proofmass.blocks.declaration.declare import Block, param


class DriftRamp(Block):
    """A parameter that drifts away from its nominal value at a constant pace."""

    slope: float = param(
        "1/s",
        "Relative deviation per second.",
        default=1.0e-6,
        not_driven="a slope that moves would move the drift before too: take a DiscreteIntegrator, and "
        "wire it to the offset of a DriftOffset",
    )
    start_time: float = param("s", "Time at which the drift begins.", default=0.0, at_least=0.0)
    nominal: float = param("{unit}", "Value without deviation.", default=1.0)
    unit: str = param("", "Unit of the value.", default="1")


def deviation_at(p: DriftRamp, time: float) -> float:
    """Relative deviation at a time."""
    elapsed = time - p.start_time
    return p.slope * (elapsed if elapsed > 0.0 else 0.0)


@DriftRamp.output("{unit}")
def value(p: DriftRamp, time: float) -> float:
    """Nominal value with the deviation applied."""
    return p.nominal * (1.0 + deviation_at(p, time))


@DriftRamp.output("1")
def deviation(p: DriftRamp, time: float) -> float:
    """The relative deviation."""
    return deviation_at(p, time)


@DriftRamp.corner
def begun(p: DriftRamp, time: float) -> float:
    return time - p.start_time
