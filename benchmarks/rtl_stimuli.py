"""Integers at random for the inputs of a block, and a graph that plays them to it from a recording."""

import random
from collections.abc import Iterator, Mapping
from fractions import Fraction
from itertools import islice
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from proofmass.blocks import AnalogToDigital, FixedQuantiser, RecordedSignal
from proofmass.blocks.arithmetic.fixed_point import Fixed, FixedValue
from proofmass.blocks.declaration import declare
from proofmass.blocks.declaration.declare import Block, Port
from proofmass.blocks.declaration.instance import format_of, unit_of
from proofmass.graphs.model.build import Graph
from proofmass.graphs.model.graph import Place

Column = NDArray[np.int64]

TESTED = "tested"  # name of the block in its graph
GIVEN = "given_"  # and the name of an input: the block that gives it
INTEGER = Fixed(6)  # format of what is played to an input for plain integers
STRETCHES = [1 << power for power in range(4, 13)]  # clocks in which an input is drawn in one way
FILE = "stimuli.csv"


@declare.block("1", input="1")
def truth(p: Block, input: float) -> bool:
    """Whether a number is not 0."""
    return input != 0.0


def drawn(block: Block, clocks: int) -> dict[str, Column]:
    """A column for each input: stretches of any number, of small ones, of any size, of one that is held."""
    draws = random.Random(repr(block))
    return {name: _column(draws, *_range(block, port), clocks) for name, port in type(block).inputs.items()}


def played(block: Block, rate: Fraction, columns: Mapping[str, Column], folder: Path) -> Graph:
    """The block with a recording at each input and a probe on each output; writes the recording into the folder."""
    blocks: dict[str, Block] = {TESTED: block}
    wires = []
    table = {"time": np.arange(max(map(len, columns.values()), default=1)) / float(rate)}
    for name, port in type(block).inputs.items():
        converter, entrance, exit_ = _converter(block, port)
        unit = unit_of(converter, type(converter).inputs[entrance])
        blocks |= {f"recorded_{name}": RecordedSignal(file=FILE, column=name, unit=unit), GIVEN + name: converter}
        wires += [f"recorded_{name}.output -> {GIVEN}{name}.{entrance}", f"{GIVEN}{name}.{exit_} -> {TESTED}.{name}"]
        fraction = format_of(block, name).fraction if port.dtype is FixedValue else 0
        table[name] = np.ldexp(columns[name].astype(float), -fraction)
    head = ",".join(["time [s]", *columns])
    np.savetxt(folder / FILE, np.column_stack(list(table.values())), "%.17g", ",", header=head, comments="")
    probes = [f"{TESTED}.{name}" for name in type(block).outputs]
    return Graph(name="played", rate=rate, blocks=blocks, wires=wires, probes=probes, place=Place(folder=str(folder)))


def _converter(block: Block, port: Port) -> tuple[Block, str, str]:
    """A block that makes what the input takes from numbers that stand for it exactly; with its input and output."""
    if port.dtype is bool:
        return truth(), "input", "truth"
    if port.dtype is int:
        return AnalogToDigital(bits=INTEGER.width, reference=float(INTEGER.highest + 1)), "voltage", "code"
    return FixedQuantiser(output_format=format_of(block, port.name), unit=unit_of(block, port)), "input", "output"


def _range(block: Block, port: Port) -> tuple[int, int]:
    if port.dtype is bool:
        return 0, 1
    format = format_of(block, port.name) if port.dtype is FixedValue else INTEGER
    return format.lowest, format.highest


def _column(draws: random.Random, low: int, high: int, clocks: int) -> Column:
    column: list[int] = []
    while len(column) < clocks:
        ways = _truths(draws) if (low, high) == (0, 1) else _numbers(draws, low, high)
        column += islice(ways, draws.choice(STRETCHES))
    return np.array(column[:clocks])


def _truths(draws: random.Random) -> Iterator[int]:
    """A truth value that is true never, seldom, half of the time, almost always, always."""
    often = draws.choice((0.0, 0.02, 0.5, 0.98, 1.0))
    while True:
        yield int(draws.random() < often)


def _numbers(draws: random.Random, low: int, high: int) -> Iterator[int]:
    way = draws.choice(("any", "small", "any size", "held"))
    constant = draws.choice((low, high, draws.randint(low, high)))
    while True:
        if way == "any":
            yield draws.choice((low, high, draws.randint(low, high), draws.randint(low, high)))
        elif way == "small":
            yield draws.randint(low // 64, high // 64)
        elif way == "any size":
            yield (high if draws.random() < 0.5 else low) >> draws.randrange(high.bit_length() + 1)
        else:
            yield constant
