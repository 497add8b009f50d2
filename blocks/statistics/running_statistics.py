"""Running mean and scatter by Welford's recurrence: m += (u - m) / n, S += (u - m_before) (u - m) (Welford 1962).

The mean is compensated (Kahan 1965).
"""

import math
from typing import NamedTuple

from proofmass.blocks.declaration.declare import Block, Input, param


class RunningStatistics(Block):
    """Mean, standard deviation and root mean square of all samples before the tick; all zero until there is one."""

    skip: int = param("1", "Ticks left out at the start, while a loop settles.", default=0, at_least=0)
    until: int = param("1", "Tick from which on nothing counts; 0 for no end.", default=0, at_least=0)
    unit: str = param("", "Unit of the input.", default="1")

    input = Input("{unit}", "Signal to sum up.")


class State(NamedTuple):
    mean: float
    rest: float  # of the mean, beyond its digits: small steps of a large mean count
    squares: float


def counted(p: RunningStatistics, tick: int) -> int:
    """Number of samples before a tick."""
    return (p.until if 0 < p.until < tick else tick) - p.skip


@RunningStatistics.output("1")
def count(p: RunningStatistics, tick: int) -> int:
    """Number of samples."""
    return max(0, counted(p, tick))


@RunningStatistics.output("{unit}")
def mean(p: RunningStatistics, x: State) -> float:
    """Mean of the samples."""
    return x.mean


@RunningStatistics.output("{unit}")
def standard_deviation(p: RunningStatistics, x: State, tick: int) -> float:
    """Standard deviation of the samples about their mean, with n - 1; zero for one sample."""
    samples = counted(p, tick)
    return math.sqrt(x.squares / float(samples - 1)) if samples > 1 else 0.0


@RunningStatistics.output("{unit}")
def root_mean_square(p: RunningStatistics, x: State, tick: int) -> float:
    """Square root of the mean of the squares."""
    samples = counted(p, tick)
    return math.sqrt(x.mean * x.mean + x.squares / float(samples)) if samples > 0 else 0.0


@RunningStatistics.update
def update(p: RunningStatistics, x: State, tick: int, input: float) -> State:
    if tick < p.skip or 0 < p.until <= tick:
        return x
    input = 1.0 * input  # measures read codes and bits too
    share = 1.0 / float(tick - p.skip + 1)  # the same for all sensors of a study
    before = (input - x.mean) - x.rest
    step = before * share + x.rest
    mean = x.mean + step
    rest = step - (mean - x.mean)
    return State(mean, rest, x.squares + before * ((input - mean) - rest))
