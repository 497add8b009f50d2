"""Running range: lowest = min(u_0 ... u_n), highest = max(u_0 ... u_n)."""

from typing import NamedTuple

from proofmass.blocks.declaration.declare import Block, Input, param


class RunningRange(Block):
    """Smallest and largest of all samples before the tick; zero until there is one."""

    skip: int = param("1", "Ticks left out at the start, while a loop settles.", default=0, at_least=0)
    until: int = param("1", "Tick from which on nothing counts; 0 for no end.", default=0, at_least=0)
    unit: str = param("", "Unit of the input.", default="1")

    input = Input("{unit}", "Signal to watch.")


class State(NamedTuple):
    lowest: float
    highest: float


@RunningRange.output("{unit}")
def minimum(p: RunningRange, x: State) -> float:
    """Smallest sample."""
    return x.lowest


@RunningRange.output("{unit}")
def maximum(p: RunningRange, x: State) -> float:
    """Largest sample."""
    return x.highest


@RunningRange.output("{unit}")
def peak_to_peak(p: RunningRange, x: State) -> float:
    """Largest less smallest sample."""
    return x.highest - x.lowest


@RunningRange.update
def update(p: RunningRange, x: State, tick: int, input: float) -> State:
    if tick < p.skip or 0 < p.until <= tick:
        return x
    input = 1.0 * input  # measures read codes and bits too
    first = tick == p.skip
    lowest = input if first or input < x.lowest else x.lowest
    highest = input if first or input > x.highest else x.highest
    return State(lowest, highest)
