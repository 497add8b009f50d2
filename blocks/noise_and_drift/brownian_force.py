"""Brownian force: white, of one-sided power density 4 k T damping (Gabrielson, IEEE Trans. Electron Devices 40, 1993).

k is Boltzmann's constant. In every tick the force is sqrt(2 k T damping fs) n, n standard normal,
fs the block's rate.
"""

import math
from typing import NamedTuple

from proofmass.blocks.declaration.declare import Block, param

BOLTZMANN = 1.380649e-23  # J/K, exact in the SI


class BrownianForce(Block):
    """Force of gas and suspension on a proof mass: the thermomechanical noise of its damping."""

    damping: float = param("kg/s", "Damping of the motion.", default=3.4e-3, at_least=0.0)
    temperature: float = param("K", "Absolute temperature.", default=300.0, at_least=0.0)


class Constants(NamedTuple):
    deviation: float


@BrownianForce.constants
def constants(p: BrownianForce, period: float) -> Constants:
    return Constants(math.sqrt(2.0 * BOLTZMANN * p.temperature * p.damping / period))


@BrownianForce.output("N")
def force(c: Constants, normal: float) -> float:
    """The force."""
    return c.deviation * normal
