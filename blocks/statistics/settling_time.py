"""Settling time: t = delay + T (1 + number of the last sample with |u - target| > within), the first being sample 0."""

from typing import NamedTuple

from proofmass.blocks.declaration.declare import Block, Input, param


class SettlingTime(Block):
    """Time after which a signal has stayed near a target, over all samples before the tick."""

    target: float = param("{unit}", "Value at which the signal settles.", default=0.0)
    within: float = param("{unit}", "Largest distance from the target.", default=1.0, above=0.0)
    delay: float = param("s", "Time of the first sample, since the signal is to settle.", default=0.0, at_least=0.0)
    skip: int = param("1", "Ticks left out at the start.", default=0, at_least=0)
    until: int = param("1", "Tick from which on nothing counts; 0 for no end.", default=0, at_least=0)
    unit: str = param("", "Unit of the input.", default="1")

    input = Input("{unit}", "Signal that settles.")


class State(NamedTuple):
    samples: int
    settled: int  # number of the first sample after the last one outside


class Constants(NamedTuple):
    target: float
    within: float
    skip: int
    until: int
    period: float
    delay: float


@SettlingTime.constants
def constants(p: SettlingTime, period: float) -> Constants:
    return Constants(p.target, p.within, p.skip, p.until, period, p.delay)


@SettlingTime.output("s")
def time_to_settle(c: Constants, x: State) -> float:
    """Time to the first sample after the last one outside; all the time if that is the last."""
    return float(x.settled) * c.period + c.delay


@SettlingTime.output("1")
def settled(c: Constants, x: State) -> bool:
    """True while the last sample is near the target."""
    return x.settled < x.samples


@SettlingTime.update
def update(c: Constants, x: State, tick: int, input: float) -> State:
    if tick < c.skip or 0 < c.until <= tick:
        return x
    near = -c.within <= 1.0 * input - c.target <= c.within  # measures read codes and bits too
    return State(x.samples + 1, x.settled if near else x.samples + 1)
