"""Exclusive-or phase detector: output = level if the bits differ, else -level.

Of two square waves d rad apart its mean is level (2 |d| / pi - 1): zero in quadrature, 2 level / pi
per rad (Gardner, Phaselock Techniques, 2005, chapter 10).
"""

from proofmass.blocks.declaration.declare import Block, Input, param


class XorPhaseDetector(Block):
    """Phase detector of two square waves with a duty of one half."""

    level: float = param("{unit}", "Output while the bits differ.", default=1.0)
    unit: str = param("", "Unit of the output.", default="V")

    first = Input("1", "First square wave.", dtype=bool)
    second = Input("1", "Second square wave.", dtype=bool)


@XorPhaseDetector.output("{unit}")
def output(p: XorPhaseDetector, first: bool, second: bool) -> float:
    """The level, or its negative."""
    return p.level if first != second else -p.level
