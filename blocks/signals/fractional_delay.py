"""Delay of a fraction: y[n] = h0 v[n-k] + h1 v[n-k-1] + h2 v[n-k-2] + h3 v[n-k-3], Lagrange's interpolation.

h_i is the product of (d - j) / (i - j) over the j from 0 to 3 other than i, with d = delay - k
between 1 and 2: exact for cubic polynomials (Laakso et al., Splitting the unit delay, IEEE Signal
Processing Magazine 13, 1996, eq. 42).
"""

import math
from collections.abc import Iterator
from typing import NamedTuple

from proofmass.blocks.declaration.declare import Block, Buffer, Input, param


class FractionalDelay(Block):
    """Delay line of any length from 1 tick on: skew between channels, time alignment, a path of light or sound."""

    delay: float = param("1", "Delay in ticks of the block, for example 2.5.", default=2.5, at_least=1.0)
    longest: int = param("1", "Ticks that the line holds.", default=16, at_least=4, at_most=1_000_000)
    unit: str = param("", "Unit of input and output.", default="1")

    input = Input("{unit}", "Signal to delay.")

    line = Buffer("The last inputs, zero before tick 0.", float, ("longest",))


class State(NamedTuple):
    place: int  # in the line, of the next input


class Constants(NamedTuple):
    back: int
    h0: float
    h1: float
    h2: float
    h3: float


@FractionalDelay.requires
def requires(p: FractionalDelay) -> Iterator[tuple[str, str]]:
    if p.delay >= p.longest - 1:
        yield "delay", f"less than longest - 1 = {p.longest - 1}"


@FractionalDelay.constants
def constants(p: FractionalDelay, period: float) -> Constants:
    back = math.floor(p.delay) - 1
    d = p.delay - back
    a, b, c = d - 1.0, d - 2.0, d - 3.0
    return Constants(back, a * b * c / -6.0, 0.5 * d * b * c, -0.5 * d * a * c, d * a * b / 6.0)


@FractionalDelay.output("{unit}")
def output(c: Constants, x: State, line: list[float], input: float) -> float:
    """The input of the time before, between the samples."""
    i = x.place - c.back  # of v[n-k]; a negative place counts from the end
    size = len(line)
    newest = input if c.back == 0 else line[i % size]
    return c.h0 * newest + c.h1 * line[(i - 1) % size] + c.h2 * line[(i - 2) % size] + c.h3 * line[(i - 3) % size]


@FractionalDelay.update
def update(c: Constants, x: State, line: list[float], input: float) -> State:
    line[x.place] = input
    return State((x.place + 1) % len(line))
