"""Delay of n ticks: y[n] = u[n - ticks], z^-ticks, with a given value before."""

from typing import NamedTuple

from proofmass.blocks.declaration.declare import Block, Buffer, Input, param


class Delay(Block):
    """Delay line of whole ticks: the latency of a converter or a bus, a transport time."""

    ticks: int = param("1", "Length of the line.", default=10, at_least=1, at_most=1_000_000)
    initial: float = param("{unit}", "Output in the first ticks.", default=0.0)
    unit: str = param("", "Unit of input and output.", default="1")

    input = Input("{unit}", "Signal to delay.")

    line = Buffer("The last inputs.", float, ("ticks",))


class State(NamedTuple):
    oldest: int  # its place in the line


@Delay.start
def start(p: Delay, line: list[float]) -> State:
    for i in range(p.ticks):
        line[i] = p.initial
    return State(0)


@Delay.output("{unit}")
def output(p: Delay, x: State, line: list[float]) -> float:
    """The input so many ticks before."""
    return line[x.oldest]


@Delay.update
def update(p: Delay, x: State, line: list[float], input: float) -> State:
    line[x.oldest] = input
    return State(x.oldest + 1 if x.oldest + 1 < p.ticks else 0)
