"""Data flip-flop: output[n+1] = data[n] where clock[n] is true and clock[n-1] was not, else output[n]."""

from typing import NamedTuple

from proofmass.blocks.declaration.declare import Block, Input, param


class DataFlipFlop(Block):
    """Register of one bit that takes its data at the rising edge of a clock; a chain shifts."""

    initially_on: bool = param("", "Output in tick 0.", default=False)

    data = Input("1", "Bit to take.", dtype=bool)
    clock = Input("1", "Clock: its rising edge takes the bit.", dtype=bool)


class State(NamedTuple):
    kept: bool
    clock: bool


@DataFlipFlop.start
def start(p: DataFlipFlop) -> State:
    return State(p.initially_on, False)


@DataFlipFlop.output("1")
def output(p: DataFlipFlop, x: State) -> bool:
    """The bit taken at the last edge before this tick."""
    return x.kept


@DataFlipFlop.update
def update(p: DataFlipFlop, x: State, data: bool, clock: bool) -> State:
    return State(data if clock and not x.clock else x.kept, clock)
