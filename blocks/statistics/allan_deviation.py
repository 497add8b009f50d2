"""Overlapping Allan deviation at one averaging time: s^2 = sum (mean of m samples - mean of the m before)^2 / (2 k).

All k = n - 2 m + 1 places of the two windows in n samples count (IEEE Std 1139-2008, annex A;
Riley, "Handbook of frequency stability analysis", NIST SP 1065 (2008), section 5.2.4).
"""

import math
from typing import NamedTuple

from proofmass.blocks.declaration.declare import Block, Buffer, Input, param


class AllanDeviation(Block):
    """Scatter of adjacent averages, over all samples before the tick; zero until there are 2 m."""

    averaging: int = param("1", "Samples of an average: averaging time by rate.", default=1, at_least=1, at_most=10**6)
    skip: int = param("1", "Ticks left out at the start, while a loop settles.", default=0, at_least=0)
    until: int = param("1", "Tick from which on nothing counts; 0 for no end.", default=0, at_least=0)
    unit: str = param("", "Unit of the input.", default="1")

    input = Input("{unit}", "Signal to average: a rate, an acceleration, a voltage.")

    recent = Buffer("The last samples, less the first of all, in a ring.", float, (lambda p: 2 * p.averaging,))


class State(NamedTuple):
    samples: int
    place: int  # in the ring, of the oldest sample
    first: float
    difference: float  # sum of the newer window less that of the older
    squares: float


@AllanDeviation.output("{unit}")
def deviation(p: AllanDeviation, x: State) -> float:
    """The Allan deviation at the averaging time."""
    places = x.samples - 2 * p.averaging + 1
    return math.sqrt(0.5 * x.squares / float(places)) / float(p.averaging) if places > 0 else 0.0


@AllanDeviation.output("1")
def count(p: AllanDeviation, x: State) -> int:
    """Number of samples."""
    return x.samples


@AllanDeviation.update
def update(p: AllanDeviation, x: State, recent: list[float], tick: int, input: float) -> State:
    if tick < p.skip or 0 < p.until <= tick:
        return x
    first = 1.0 * input if x.samples == 0 else x.first  # measures read codes and bits too
    u = 1.0 * input - first
    if x.samples < p.averaging:
        difference = x.difference - u
    elif x.samples < 2 * p.averaging:
        difference = x.difference + u
    else:
        half = x.place + p.averaging if x.place < p.averaging else x.place - p.averaging
        difference = x.difference + (u - recent[half]) - (recent[half] - recent[x.place])
    recent[x.place] = u
    samples = x.samples + 1
    place = x.place + 1 if x.place + 1 < 2 * p.averaging else 0
    counted = difference if samples >= 2 * p.averaging else 0.0
    return State(samples, place, first, difference, x.squares + counted * counted)
