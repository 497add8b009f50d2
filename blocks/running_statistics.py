"""Running statistics by Welford's recurrence: m += (u - m) / n, S += (u - m_before) (u - m) (Welford 1962)."""

import math
from typing import NamedTuple

from proofmass.blocks.declare import Block, Input, param


class RunningStatistics(Block):
    """Mean, standard deviation and range of all samples before the tick; all zero until there is one."""

    skip: int = param("1", "Ticks left out at the start, while a loop settles.", default=0, at_least=0)
    unit: str = param("", "Unit of the input.", default="1")

    input = Input("{unit}", "What is summed up.")


class State(NamedTuple):
    samples: int
    mean: float
    squares: float
    lowest: float
    highest: float


@RunningStatistics.output("1")
def count(p: RunningStatistics, x: State) -> int:
    """Number of samples."""
    return x.samples


@RunningStatistics.output("{unit}")
def mean(p: RunningStatistics, x: State) -> float:
    """Mean of the samples."""
    return x.mean


@RunningStatistics.output("{unit}")
def standard_deviation(p: RunningStatistics, x: State) -> float:
    """Standard deviation of the samples about their mean, with n - 1; zero for one sample."""
    return math.sqrt(x.squares / float(x.samples - 1)) if x.samples > 1 else 0.0


@RunningStatistics.output("{unit}")
def minimum(p: RunningStatistics, x: State) -> float:
    """Smallest sample."""
    return x.lowest


@RunningStatistics.output("{unit}")
def maximum(p: RunningStatistics, x: State) -> float:
    """Largest sample."""
    return x.highest


@RunningStatistics.output("{unit}")
def peak_to_peak(p: RunningStatistics, x: State) -> float:
    """Largest less smallest sample."""
    return x.highest - x.lowest


@RunningStatistics.output("{unit}")
def root_mean_square(p: RunningStatistics, x: State) -> float:
    """Square root of the mean of the squares."""
    return math.sqrt(x.mean * x.mean + x.squares / float(x.samples)) if x.samples > 0 else 0.0


@RunningStatistics.update
def update(p: RunningStatistics, x: State, tick: int, input: float) -> State:
    if tick < p.skip:
        return x
    input = 1.0 * input  # measures read codes and bits too
    if x.samples == 0:
        return State(1, input, 0.0, input, input)
    samples = x.samples + 1
    mean = x.mean + (input - x.mean) / float(samples)
    squares = x.squares + (input - x.mean) * (input - mean)
    lowest = input if input < x.lowest else x.lowest
    highest = input if input > x.highest else x.highest
    return State(samples, mean, squares, lowest, highest)
