"""White noise source: output = density sqrt(fs / 2) n, where n is standard normal and fs the rate of the block.

The density is one-sided: the power between two frequencies below fs / 2 is density^2 times their
difference.
"""

import math
from typing import NamedTuple

from proofmass.blocks.declaration.declare import Block, param


class WhiteNoise(Block):
    """Gaussian noise, independent from tick to tick and from block to block."""

    density: float = param("({unit})/sqrt(Hz)", "One-sided spectral density of amplitude.", default=1.0, at_least=0.0)
    unit: str = param("", "Unit of the output.", default="1")


class Constants(NamedTuple):
    deviation: float


@WhiteNoise.constants
def constants(p: WhiteNoise, period: float) -> Constants:
    return Constants(p.density * math.sqrt(0.5 / period))


@WhiteNoise.output("{unit}")
def output(c: Constants, normal: float) -> float:
    """The noise."""
    return c.deviation * normal
