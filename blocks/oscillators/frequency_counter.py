"""Frequency counter: reciprocal frequency = cycles / time between their edges; gated frequency = edges / gate.

Clocked by the ticks of the block, T: a reciprocal count is right to T / gate, a gated one to 1 /
gate in Hz (Kalisz, Review of methods for time interval measurements with picosecond resolution,
Metrologia 41, 2004). The first rise may be that of a start, not the end of a period: reciprocal
counts begin at the second, the first gate after the first.
"""

import math
from typing import NamedTuple

from proofmass.blocks.declaration.declare import Block, Input, param


class FrequencyCounter(Block):
    """Frequency of a square wave by its rises after the first; a reciprocal count ends with an edge after the gate."""

    gate: float = param("s", "Time of a measurement.", default=0.01, above=0.0)
    reciprocal: bool = param("", "Whether whole cycles are timed instead of counting edges.", default=True)

    signal = Input("1", "The square wave, as of a Comparator.", dtype=bool)


class State(NamedTuple):
    before: bool
    edges: int  # since the count began; below zero until it begins
    ticks: int
    frequency: float
    finished: int


class Constants(NamedTuple):
    gate: int
    period: float
    reciprocal: bool


@FrequencyCounter.constants
def constants(p: FrequencyCounter, period: float) -> Constants:
    ticks = math.floor(p.gate / period + 0.5)
    return Constants(ticks if ticks > 1 else 1, period, p.reciprocal)


@FrequencyCounter.start
def start(p: FrequencyCounter) -> State:
    return State(True, -2 if p.reciprocal else -1, 0, 0.0, 0)


@FrequencyCounter.output("Hz")
def frequency(c: Constants, x: State) -> float:
    """The last finished measurement; zero before the first, and for a signal that stands still."""
    return x.frequency


@FrequencyCounter.output("1")
def measurements(c: Constants, x: State) -> int:
    """Number of finished measurements."""
    return x.finished


@FrequencyCounter.update
def update(c: Constants, x: State, signal: bool) -> State:
    edge = signal and not x.before
    edges, ticks = x.edges + (1 if edge else 0), x.ticks + 1
    if x.edges < 0:  # time begins with the edge that makes it zero
        return State(signal, edges, 0, x.frequency, x.finished)
    if ticks >= c.gate and (edge or not c.reciprocal):
        return State(signal, 0, 0, float(edges) / (float(ticks) * c.period), x.finished + 1)
    return State(signal, edges, ticks, x.frequency, x.finished)
