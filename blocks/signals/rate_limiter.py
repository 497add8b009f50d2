"""Rate limiter: y[n] = y[n-1] + (u[n] - y[n-1] held between -falling T and rising T), T the period of the block."""

from typing import NamedTuple

from proofmass.blocks.arithmetic.rounding import clip
from proofmass.blocks.declaration.declare import Block, Input, param


class RateLimiter(Block):
    """Limits how fast a signal may move: the slew rate of an amplifier, a soft start."""

    rising: float = param("({unit})/s", "Largest slope upwards.", default=1000.0, above=0.0)
    falling: float = param("({unit})/s", "Largest slope downwards, a positive number.", default=1000.0, above=0.0)
    initial: float = param("{unit}", "Output before tick 0.", default=0.0)
    unit: str = param("", "Unit of input and output.", default="1")

    input = Input("{unit}", "Signal to follow.")


class State(NamedTuple):
    followed: float


class Constants(NamedTuple):
    up: float  # in a tick
    down: float


@RateLimiter.constants
def constants(p: RateLimiter, period: float) -> Constants:
    return Constants(p.rising * period, p.falling * period)


@RateLimiter.start
def start(p: RateLimiter) -> State:
    return State(p.initial)


@RateLimiter.output("{unit}")
def output(c: Constants, x: State, input: float) -> float:
    """The input, or as near to it as the slope allows."""
    return clip(input, x.followed - c.down, x.followed + c.up)


@RateLimiter.update
def update(c: Constants, x: State, input: float) -> State:
    return State(clip(input, x.followed - c.down, x.followed + c.up))
