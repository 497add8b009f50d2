"""Ports and parameters whose names are words of the declaration of blocks: from files, in Python, in every engine."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from proofmass import Graph, block, param, simulate
from proofmass.blocks import Ramp
from proofmass.blocks.declaration.catalog import load_own_blocks
from proofmass.graphs.files.toml_reader import read_graph, read_graph_text
from proofmass.graphs.files.toml_writer import write_graph
from tests.by_hand.words_of_blocks import OF_OUTPUTS, WORDS_OF_BLOCKS

OF_REGISTERS = tuple(word for word in WORDS_OF_BLOCKS if word != "start")
OF_CONTINUOUS = tuple(word for word in WORDS_OF_BLOCKS if word != "linear")
SUM = " + ".join(f"{number}.0 * {{0}}{word}" for number, word in enumerate(WORDS_OF_BLOCKS, 1))


def lines(text: str, words: tuple[str, ...] = WORDS_OF_BLOCKS) -> str:
    """A line for each of the words, which are numbered from 1."""
    return "\n".join(text.format(word=word, number=number) for number, word in enumerate(words, 1))


OWN = f'''
from typing import Any, NamedTuple

from proofmass import Block, Buffer, Input, param
from proofmass.blocks.arithmetic.fixed_point import Fixed, FixedValue

class State(NamedTuple):
    total: float

class Constants(NamedTuple):
    start: float

class Parameters(Block):
    """A parameter of each name."""
{lines('    {word}: float = param("1", "A number.", default=1.0)')}

@Parameters.output("1")
def result(p: Any) -> float:
    """Their sum."""
    return {SUM.format("p.")}

class Inputs(Block):
    """An input of each name."""
{lines('    {word} = Input("1", "A number.", default=1.0)')}

@Inputs.output("1")
def result(p: Any, {", ".join(f"{word}: float" for word in WORDS_OF_BLOCKS)}) -> float:
    """Their sum."""
    return {SUM.format("")}

class Buffers(Block):
    """A buffer of each name."""
    moved = Input("1", "A number.")
{lines('    {word} = Buffer("A number.", float, (1,))')}

@Buffers.start
def begin(p: Any, {", ".join(WORDS_OF_BLOCKS)}) -> State:
{lines("    {word}[0] = {number}.0")}
    return State(0.0)

@Buffers.output("1")
def result(p: Any, x: State) -> float:
    """The sum of the tick before."""
    return x.total

@Buffers.update
def after(p: Any, x: State, {", ".join(WORDS_OF_BLOCKS)}, moved: float) -> State:
{lines("    {word}[0] = {word}[0] + moved")}
    return State({" + ".join(f"{word}[0]" for word in WORDS_OF_BLOCKS)})

class Outputs(Block):
    """An output of each name, a start, constants and an update."""
    moved = Input("1", "A number.")

@Outputs.start
def begin(p: Any) -> State:
    return State(0.5)

@Outputs.constants
def known(p: Any, period: float) -> Constants:
    return Constants(period)

@Outputs.update
def after(c: Constants, x: State, moved: float) -> State:
    return State(x.total + moved)

{
    lines(
        """
@Outputs.output("1")
def {word}(c: Constants, x: State, moved: float) -> float:
    'A number.'
    return {number}.0 * moved + x.total + c.start
""",
        OF_OUTPUTS,
    )
}

class Continuous(Block):
    """An input of each name but that of the output; the sum is integrated."""
{lines('    {word} = Input("1", "A number.", default=1.0)', OF_CONTINUOUS)}

@Continuous.derivative(linear=True)
def rate(p: Any, x: State, {", ".join(f"{word}: float" for word in OF_CONTINUOUS)}) -> State:
    return State({" + ".join(OF_CONTINUOUS)})

@Continuous.output("s")
def linear(p: Any, x: State) -> float:
    """The integral."""
    return x.total

class Registers(Block):
    """An input of each name but one, in fixed point, and an output and a field of the state of this name."""
{lines('    {word} = Input("1", "A number.", FixedValue)', OF_REGISTERS)}

class Totals(NamedTuple):
    start: FixedValue

@Registers.formats
def widths(p: Any) -> dict[str, Fixed]:
    return dict.fromkeys([*{list(WORDS_OF_BLOCKS)}, "x"], Fixed(16, 8))

@Registers.start
def begin(p: Any) -> Totals:
    return Totals(FixedValue(0, 8))

@Registers.output("1")
def start(c: Any, x: Totals) -> FixedValue:
    """The last of the tick before."""
    return x.start

@Registers.update
def after(c: Any, {", ".join(f"{word}: FixedValue" for word in OF_REGISTERS)}) -> Totals:
    return Totals({OF_REGISTERS[-1]})
'''
GRAPH = f"""
rate = "1 kHz"
probes = ["parameters.result", "inputs.result", "buffers.result", "continuous.linear", "registers.start"]
wires = [
{lines('    "ramp.output -> continuous.{word}",', OF_CONTINUOUS)}
{lines('    "quantiser.output -> registers.{word}",', OF_REGISTERS)}
{lines('    "outputs.{word} -> inputs.{word}",', OF_OUTPUTS)}
    "ramp.output -> parameters.{WORDS_OF_BLOCKS[0]}",
    "ramp.output -> quantiser.input",
    "ramp.output -> buffers.moved",
    "ramp.output -> outputs.moved",
]

[blocks]
ramp = {{kind = "Ramp", slope = 1000.0}}
quantiser = {{kind = "FixedQuantiser", output_format = "(16, 8)"}}
inputs = {{kind = "Inputs"}}
buffers = {{kind = "Buffers"}}
outputs = {{kind = "Outputs"}}
continuous = {{kind = "Continuous"}}
registers = {{kind = "Registers"}}

[blocks.parameters]
kind = "Parameters"
{lines("{word} = {number}.0")}
"""


@pytest.fixture
def graph(tmp_path: Path) -> Graph:
    (tmp_path / "own.py").write_text(OWN, encoding="utf-8")
    (tmp_path / "graph.toml").write_text(GRAPH, encoding="utf-8")
    return read_graph(tmp_path / "graph.toml", load_own_blocks(tmp_path / "own.py"))


@pytest.mark.exhaustive("compiled")
@pytest.mark.parametrize("engine", ["python", "compiled"])
def test_one_of_each_name(graph: Graph, engine: Any) -> None:
    assert read_graph_text(write_graph(graph), own={type(b).__name__: type(b) for b in graph.blocks.values()}) == graph
    ticks = np.arange(20.0)
    before = np.cumsum(ticks) - ticks
    factors = np.arange(1.0, len(WORDS_OF_BLOCKS) + 1)
    result = simulate(graph, samples=20, engine=engine)
    values = {name: result[name].values for name in result}
    assert values["parameters.result"].tolist() == (np.sum(factors[1:] ** 2) + ticks).tolist()
    numbers = [OF_OUTPUTS.index(word) + 1.0 if word in OF_OUTPUTS else 0.0 for word in WORDS_OF_BLOCKS]
    outputs = np.outer(ticks, numbers) + (0.5 + before + 1e-3)[:, None]
    outputs[:, [n for n, word in enumerate(WORDS_OF_BLOCKS) if word not in OF_OUTPUTS]] = 1.0
    assert values["inputs.result"] == pytest.approx(outputs @ factors, rel=1e-12)
    assert values["buffers.result"].tolist() == [0.0, *(factors.sum() + len(factors) * np.cumsum(ticks))[:-1]]
    assert values["continuous.linear"] == pytest.approx(1e-3 * len(OF_CONTINUOUS) * before, rel=1e-12)
    assert values["registers.start"].tolist() == [0.0, *ticks[:-1]]


@block("1", inputs="1", size="1", start=param("1", "A factor.", default=1.0), event=param("1", "More.", default=0.0))
def output(p: Any, inputs: float, size: float) -> float:
    """A sum."""
    return p.start * inputs + size + p.event


@pytest.mark.parametrize("engine", ["python", "compiled"])
def test_a_block_of_one_function(engine: Any) -> None:
    kind: Any = output
    blocks = {"ramp": Ramp(slope=1.0), "block": kind(start=2.0, event=3.0)}
    wires = ["ramp.output -> block.inputs", "ramp.output -> block.size"]
    graph = Graph(name="sum", rate="1 Hz", blocks=blocks, wires=wires, probes=["block.output"])
    assert simulate(graph, samples=4, engine=engine)["block.output"].values.tolist() == [3.0, 6.0, 9.0, 12.0]
