"""Mean of the absolute values, by the recurrence m += (|u| - m) / n (Welford 1962), compensated (Kahan 1965)."""

from typing import NamedTuple

from proofmass.blocks.declaration.declare import Block, Input, param


class MeanAbsolute(Block):
    """Mean absolute value of all samples before the tick; zero until there is one."""

    skip: int = param("1", "Ticks left out at the start, while a loop settles.", default=0, at_least=0)
    until: int = param("1", "Tick from which on nothing counts; 0 for no end.", default=0, at_least=0)
    unit: str = param("", "Unit of the input.", default="1")

    input = Input("{unit}", "Signal whose size is averaged.")


class State(NamedTuple):
    mean: float
    rest: float  # of the mean, beyond its digits: small steps of a large mean count


@MeanAbsolute.output("{unit}")
def mean_absolute(p: MeanAbsolute, x: State) -> float:
    """Mean of the absolute values."""
    return x.mean


@MeanAbsolute.update
def update(p: MeanAbsolute, x: State, tick: int, input: float) -> State:
    if tick < p.skip or 0 < p.until <= tick:
        return x
    size = abs(1.0 * input)  # measures read codes and bits too
    share = 1.0 / float(tick - p.skip + 1)  # the same for all runs of a study
    step = ((size - x.mean) - x.rest) * share + x.rest
    mean = x.mean + step
    return State(mean, step - (mean - x.mean))
