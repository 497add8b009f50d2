"""First-order Gauss-Markov process: value = nominal (1 + d), d' = -d / correlation_time + white noise.

Exactly discretised (Brown and Hwang, Introduction to Random Signals and Applied Kalman Filtering,
ch. 4), with T the period of the block: d[n] = a d[n-1] + standard_deviation sqrt(1 - a^2) n, a =
exp(-T / correlation_time).
"""

import math
from typing import NamedTuple

from proofmass.blocks.arithmetic.elementary import exponential, exponential_less_one
from proofmass.blocks.declaration.declare import Block, param


class GaussMarkov(Block):
    """Parameter that wanders about its nominal value and forgets: an Ornstein-Uhlenbeck process."""

    standard_deviation: float = param(
        "1", "Standard deviation of the relative deviation, once settled.", default=10.0e-6, at_least=0.0
    )
    correlation_time: float = param("s", "Time in which the correlation falls to 1/e.", default=100.0, above=0.0)
    stationary: bool = param("", "Whether it starts settled; otherwise it starts at the nominal value.", default=True)
    nominal: float = param("{unit}", "Value without deviation.", default=1.0)
    unit: str = param("", "Unit of the value.", default="1")


class State(NamedTuple):
    before: float  # the part of the deviation that the ticks before have made


class Constants(NamedTuple):
    decay: float
    step: float
    first_step: float
    nominal: float


@GaussMarkov.constants
def constants(p: GaussMarkov, period: float) -> Constants:
    ticks = period / p.correlation_time
    step = p.standard_deviation * math.sqrt(-exponential_less_one(-2.0 * ticks))
    return Constants(exponential(-ticks), step, p.standard_deviation if p.stationary else 0.0, p.nominal)


def deviation_at(c: Constants, x: State, tick: int, normal: float) -> float:
    """Relative deviation in a tick."""
    return x.before + (c.step if tick > 0 else c.first_step) * normal


@GaussMarkov.output("{unit}")
def value(c: Constants, x: State, tick: int, normal: float) -> float:
    """Nominal value with the deviation applied."""
    return c.nominal * (1.0 + deviation_at(c, x, tick, normal))


@GaussMarkov.output("1")
def deviation(c: Constants, x: State, tick: int, normal: float) -> float:
    """The relative deviation."""
    return deviation_at(c, x, tick, normal)


@GaussMarkov.update
def update(c: Constants, x: State, tick: int, normal: float) -> State:
    return State(c.decay * deviation_at(c, x, tick, normal))
