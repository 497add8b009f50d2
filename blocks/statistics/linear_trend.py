"""Least-squares slope of all samples: b = sum (t - mean t) (u - mean u) / sum (t - mean t)^2.

Both sums by the recurrence of Welford (1962), its mean compensated (Kahan 1965); of equally spaced
times, sum (t - mean t)^2 = T^2 n (n^2 - 1) / 12.
"""

from typing import NamedTuple

from proofmass.blocks.declaration.declare import Block, Input, param


class LinearTrend(Block):
    """Pace at which a signal drifts, over all samples before the tick; zero until there are two."""

    skip: int = param("1", "Ticks left out at the start, while a loop settles.", default=0, at_least=0)
    until: int = param("1", "Tick from which on nothing counts; 0 for no end.", default=0, at_least=0)
    unit: str = param("", "Unit of the input.", default="1")

    input = Input("{unit}", "Signal that drifts.")


class State(NamedTuple):
    samples: int
    mean: float
    rest: float  # of the mean, beyond its digits: small steps of a large mean count
    products: float  # of the deviations of time, in ticks, and of the input


class Constants(NamedTuple):
    skip: int
    until: int
    period: float


@LinearTrend.constants
def constants(p: LinearTrend, period: float) -> Constants:
    return Constants(p.skip, p.until, period)


@LinearTrend.output("({unit})/s")
def slope(c: Constants, x: State) -> float:
    """Slope of the straight line."""
    n = float(x.samples)
    return 12.0 * x.products / (n * (n * n - 1.0) * c.period) if x.samples > 1 else 0.0


@LinearTrend.output("1")
def count(c: Constants, x: State) -> int:
    """Number of samples."""
    return x.samples


@LinearTrend.update
def update(c: Constants, x: State, tick: int, input: float) -> State:
    if tick < c.skip or 0 < c.until <= tick:
        return x
    samples = x.samples + 1
    input = 1.0 * input  # measures read codes and bits too
    step = ((input - x.mean) - x.rest) / float(samples) + x.rest
    mean = x.mean + step
    rest = step - (mean - x.mean)
    # The new time is n/2 ticks after the mean of those before.
    return State(samples, mean, rest, x.products + 0.5 * float(samples) * ((input - mean) - rest))
