"""Temperature cycle: T = low + min(pace t, S) - clip(pace (t - U), 0, S), S = high - low, U = S / pace + soak_time.

t counts from the start of each cycle: up, soak, down, soak. A cycle takes 2 U.
"""

from collections.abc import Iterator
from typing import NamedTuple

from proofmass.blocks.arithmetic.rounding import clip, nearest_integer
from proofmass.blocks.declaration.declare import Block, param

_CYCLES = "the cycles before would move too: take a DiscreteIntegrator of the pace, with limits"


class TemperatureCycle(Block):
    """A climatic chamber that cycles between two temperatures, with ramps of constant pace and soaks at both ends."""

    low: float = param("K", "Lower temperature, where it starts.", default=233.15, above=0.0)
    high: float = param("K", "Upper temperature.", default=358.15, above=0.0)
    pace: float = param("K/s", "Pace of the temperature.", default=1.0 / 60.0, above=0.0, not_driven=_CYCLES)
    soak_time: float = param("s", "Time that it stays at either end.", default=3600.0, at_least=0.0, not_driven=_CYCLES)


class Constants(NamedTuple):
    low: float
    span: float
    pace: float
    half: float  # s


@TemperatureCycle.requires
def requires(p: TemperatureCycle) -> Iterator[tuple[str, str]]:
    if p.high <= p.low:
        yield "high", "above low"


@TemperatureCycle.constants
def constants(p: TemperatureCycle, period: float) -> Constants:
    span = p.high - p.low
    return Constants(p.low, span, p.pace, span / p.pace + p.soak_time)


def elapsed_at(c: Constants, time: float) -> float:
    """Time since the start of the cycle."""
    cycles = time / (2.0 * c.half)
    part = cycles - nearest_integer(cycles)
    return (part if part >= 0.0 else part + 1.0) * (2.0 * c.half)


@TemperatureCycle.output("K")
def temperature(c: Constants, time: float) -> float:
    """The temperature."""
    elapsed = elapsed_at(c, time)
    return c.low + (clip(c.pace * elapsed, 0.0, c.span) - clip(c.pace * (elapsed - c.half), 0.0, c.span))


@TemperatureCycle.corner
def bends(c: Constants, time: float) -> int:
    elapsed = elapsed_at(c, time)
    halves = int(clip(nearest_integer((time - elapsed) / c.half), 0.0, 1e15)) + (1 if elapsed >= c.half else 0)
    return 2 * halves + (1 if c.pace * (elapsed - (c.half if elapsed >= c.half else 0.0)) >= c.span else 0)
