"""Time-to-digital converter: code = floor(t / resolution), t the time from a rising edge of start to the next of stop.

An edge is where the signal rises through zero; its instant is that of the straight line between two
samples, so that times are resolved far below a tick. A start while time runs is ignored (Kalisz,
Metrologia 41, 2004).
"""

from typing import NamedTuple

from proofmass.blocks.arithmetic.rounding import round_down
from proofmass.blocks.declaration.declare import Block, Input, param


class TimeToDigital(Block):
    """Time between the rising edges of two signals as a code: phase meters, time of flight."""

    resolution: float = param("s", "Time of one step of the code.", default=100e-12, above=0.0)
    bits: int = param("bit", "Width of the code; longer times give the last.", default=32, at_least=1, at_most=48)
    unit: str = param("", "Unit of both signals.", default="1")

    begin = Input("{unit}", "Signal whose rising edge begins a measurement.")
    end = Input("{unit}", "Signal whose rising edge ends it.")


class State(NamedTuple):
    begin: float  # the signals in the tick before
    end: float
    running: bool
    elapsed: float  # ticks from the edge to the tick before
    code: int
    finished: int


class Constants(NamedTuple):
    steps: float  # of the code in a tick
    resolution: float
    last: float


@TimeToDigital.constants
def constants(p: TimeToDigital, period: float) -> Constants:
    return Constants(period / p.resolution, p.resolution, float((1 << p.bits) - 1))


@TimeToDigital.output("1")
def code(c: Constants, x: State) -> int:
    """The last finished measurement; zero before the first."""
    return x.code


@TimeToDigital.output("s")
def interval(c: Constants, x: State) -> float:
    """The code times the resolution."""
    return float(x.code) * c.resolution


@TimeToDigital.output("1")
def measurements(c: Constants, x: State) -> int:
    """Number of finished measurements."""
    return x.finished


def edge(before: float, now: float) -> float:
    """Part of the tick after which a signal rises through zero, from 0 to 1; 2 if it does not."""
    return before / (before - now) if before < 0.0 <= now else 2.0


@TimeToDigital.update
def update(c: Constants, x: State, begin: float, end: float) -> State:
    a, b = edge(x.begin, begin), edge(x.end, end)
    since = x.elapsed if x.running else -a  # ticks from the edge that began it to the tick before
    ends = b <= 1.0 and (x.running or a <= b)
    if not ends:
        running = x.running or a <= 1.0
        return State(begin, end, running, since + 1.0 if running else 0.0, x.code, x.finished)
    steps = (since + b) * c.steps
    code = round_down(steps if steps < c.last else c.last)
    again = x.running and b < a <= 1.0
    return State(begin, end, again, 1.0 - a if again else 0.0, code, x.finished + 1)
