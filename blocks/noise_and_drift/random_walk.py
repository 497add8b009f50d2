"""Random walk: value = nominal (1 + w), w[0] = 0, w[n+1] = w[n] + coefficient sqrt(T) n, with standard normal n.

T is the period of the block. The deviation has variance coefficient^2 t and Allan deviation
coefficient sqrt(tau / 3) (IEEE Std 952, annex C, with K for the coefficient).
"""

import math
from typing import NamedTuple

from proofmass.blocks.declaration.declare import Block, param


class RandomWalk(Block):
    """A parameter that wanders off without bound: bias instability over long times, a clock."""

    coefficient: float = param("1/sqrt(s)", "Standard deviation after one second.", default=1.0e-6, at_least=0.0)
    nominal: float = param("{unit}", "Value without deviation.", default=1.0)
    unit: str = param("", "Unit of the value.", default="1")


class State(NamedTuple):
    deviation: float


class Constants(NamedTuple):
    step: float
    nominal: float


@RandomWalk.constants
def constants(p: RandomWalk, period: float) -> Constants:
    return Constants(p.coefficient * math.sqrt(period), p.nominal)


@RandomWalk.output("{unit}")
def value(c: Constants, x: State) -> float:
    """Nominal value with the deviation applied."""
    return c.nominal * (1.0 + x.deviation)


@RandomWalk.output("1")
def deviation(c: Constants, x: State) -> float:
    """The relative deviation."""
    return x.deviation


@RandomWalk.update
def update(c: Constants, x: State, normal: float) -> State:
    return State(x.deviation + c.step * normal)
