"""Constant drift: value = nominal (1 + offset).

All drifts have this form, so that one may follow another: wire the `value` of one to `nominal` of
the next and the factors multiply, wire the last to a parameter and it moves.
"""

from proofmass.blocks.declaration.declare import Block, param


class DriftOffset(Block):
    """A parameter that is off its nominal value by a constant part: calibration error, tolerance, aged reference."""

    offset: float = param("1", "Relative deviation.", default=200.0e-6)
    nominal: float = param("{unit}", "Value without deviation.", default=1.0)
    unit: str = param("", "Unit of the value.", default="1")


@DriftOffset.output("{unit}")
def value(p: DriftOffset) -> float:
    """Nominal value with the deviation applied."""
    return p.nominal * (1.0 + p.offset)


@DriftOffset.output("1")
def deviation(p: DriftOffset) -> float:
    """The relative deviation."""
    return p.offset
