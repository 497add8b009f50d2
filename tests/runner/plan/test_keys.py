"""Names of a user never meet those that the loop makes up: the bits are the same whatever things are called."""

import dataclasses
import itertools
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from proofmass.blocks import ConvergenceMonitor
from proofmass.blocks.declaration.catalog import load_own_blocks
from proofmass.graphs.files.toml_reader import read_graph
from proofmass.graphs.model.build import Graph
from proofmass.graphs.model.limits import NAME
from proofmass.runner.plan.keys import ConstantOf, DuplicateKeyError, Given, StreamOf, WireOf, variable
from proofmass.runner.planning.plan import plan
from proofmass.runner.program.slots import Slots
from proofmass.runner.program.tick import write_tick
from proofmass.runner.run.simulate import simulate
from proofmass.runner.targets.native_lanes import CompiledLanes, Lanes

HEAD = """
import math
from typing import NamedTuple

from proofmass import Block, Input, param
"""
NOISE = '''

class Constants(NamedTuple):
    stream: float


class Shaken(Block):
    """Noise about a constant that is called as a number of the loop is."""


@Shaken.constants
def constants(p, period: float) -> Constants:
    return Constants(3.0)


@Shaken.output("1")
def output(c: Constants, normal: float) -> float:
    """Noise about three."""
    return c.stream + normal
'''


def read(folder: Path, blocks: str, graph: str) -> Graph:
    (folder / "own.py").write_text(HEAD + blocks)
    (folder / "own.toml").write_text(f'name = "own"\nrate = "1 kHz"\n{graph}')
    return read_graph(folder / "own.toml", load_own_blocks(folder / "own.py"))


def same_everywhere(graph: Graph, samples: int, in_lanes: bool = True) -> dict[str, Any]:
    """Every probe in plain Python, bit for bit as compiled, and its last value in lanes."""
    python, compiled = (simulate(graph, samples=samples, engine=engine) for engine in ("python", "compiled"))  # type: ignore[arg-type]
    scalars = [name for name in python if python[name].values.ndim == 1]
    measures = {f"m_{i}": {"signal": name, "statistic": "last"} for i, name in enumerate(scalars)}
    for name in python:
        assert python[name].values.tobytes() == compiled[name].values.tobytes(), name
    if not in_lanes:
        return {name: python[name].values for name in python}
    planned = plan(dataclasses.replace(graph, probes=(), measures=measures))
    lanes = Lanes(CompiledLanes(planned, frozenset(), 16), graph.seed, np.zeros(16, dtype=np.int64), {})
    lanes.advance(samples)
    assert lanes.sound().all()
    for measure in planned.measures:
        last = lanes.value(WireOf(*measure.node))
        assert (last == python[measure.signal].values[-1]).all(), measure.signal
    return {name: python[name].values for name in python}


@pytest.mark.defect("S5", before="a constant named stream is lost: 0.6238", after="kept: 3.6238")
def test_a_constant_called_stream(tmp_path: Path) -> None:
    graph = read(tmp_path, NOISE, 'probes = ["noise.output"]\n[blocks.noise]\nkind = "Shaken"\n')
    values = same_everywhere(graph, 1000)["noise.output"]
    assert values.mean() == pytest.approx(3.0, abs=0.2)


@pytest.mark.exhaustive
@pytest.mark.defect("S5", before="a block named group_0 gets a tolerance of 0", after="its own")
def test_a_block_called_as_a_group_beside_one_that_is_stepped(tmp_path: Path) -> None:
    text = """
duration = "20 ms"
wires = [
    "push.output -> mass.force",
    "stiffness.output -> group_0.stiffness",
    "damping.output -> group_0.damping",
]
probes = ["mass.displacement", "group_0.OUT"]
[blocks.push]
kind = "Constant"
value = "1 uN"
unit = "N"
[blocks.mass]
kind = "MassBetweenStops"
[blocks.stiffness]
kind = "Ramp"
slope = "1 N/m/s"
unit = "N/m"
[blocks.damping]
kind = "Constant"
value = 1.0
unit = "kg/s"
[blocks.group_0]
kind = "ConvergenceMonitor"
""".replace("OUT", next(iter(ConvergenceMonitor.outputs)))
    graph = read(tmp_path, "", text)
    made = write_tick(plan(graph))
    assert set(made.constants.kinds) == set(made.constant_values)  # every number that is read is given
    assert ConstantOf("group_0", "tolerance") in made.constants.kinds
    same_everywhere(graph, 20, in_lanes=False)


WORDS = (
    *(
        "group_0",
        "lanes",
        "loop_0",
        "time",
        "tick",
        "period",
        "first",
        "last",
        "seed",
        "run",
        "runs",
        "lane",
        "numbers",
    ),
    *(
        "integers",
        "state_numbers",
        "scratch",
        "probe_0",
        "row_0",
        "not_finite",
        "refused",
        "watched",
        "context",
        "carray",
    ),
)
PORTS = (
    *("next", "next_", "lanes", "lanes_", "rates", "rates_", "then", "slope", "slope_", "c_", "x_", "c__0", "normal_"),
    *("period_", "stream", "tolerance", "overflow", "overflow_", "overflows_", "set", "fault_", "moved_", "group_0_x"),
    *("x__c_", "out_", "State", "Constants", "Parameters", "update", "failed", "refused", "lane"),
)
OUTPUT = '''
@{kind}.output("1")
def {port}({first}, x: {kind}State, input: float) -> float:
    """Output."""
    return {number} * input + {first}.{field} * x.{field}
'''


def words(kind: str, ports: tuple[str, ...], *, constants: bool) -> str:
    """A block whose outputs, parameters or constants, and fields of its state all have such names."""
    first = "c" if constants else "p"
    usable = [f for f in ports if f not in ("update", "State", "Constants", "Parameters")]
    text = f"\n\nclass {kind}State(NamedTuple):\n" + "".join(f"    {f}: float\n" for f in usable)
    text += f'\n\nclass {kind}(Block):\n    """Words."""\n\n'
    if constants:
        text += '    input = Input("1", "Input.")\n'
        text += f"\n\nclass {kind}Constants(NamedTuple):\n" + "".join(f"    {f}: float\n" for f in usable)
        given = ", ".join(f"{i}.5" for i in range(len(usable)))
        text += f"\n\n@{kind}.constants\ndef constants(p, period: float) -> {kind}Constants:\n"
        text += f"    return {kind}Constants({given})\n"
    else:
        names = [f"k_{f}" for f in usable]
        text += "".join(f'    {n}: float = param("1", "P.", default={i}.5)\n' for i, n in enumerate(names))
        text += '    input = Input("1", "Input.")\n'
    for number, port in enumerate(p for p in ports if p != "update"):
        field = usable[number % len(usable)]
        made = OUTPUT.format(kind=kind, port=port, first=first, number=number, field=field)
        text += made if constants else made.replace(f"p.{field}", f"p.k_{field}")
    values = ", ".join(f"0.5 * x.{f} + {i}.0 * input" for i, f in enumerate(usable))
    text += f"\n\n@{kind}.update\ndef update({first}, x: {kind}State, input: float) -> {kind}State:\n"
    return f"{text}    return {kind}State({values})\n"


@pytest.mark.exhaustive
@pytest.mark.defect("S5", before="names of a user meet those of the loop", after="the same bits by any name")
def test_blocks_fields_and_ports_called_as_the_loops_own_words(tmp_path: Path) -> None:
    few = ("next", "c_")
    blocks = (
        words("Few", few, constants=True)
        + words("Many", PORTS, constants=True)
        + words("Set", PORTS[:9], constants=False)
    )
    chain = ["source", *WORDS, "many", "given"]
    ports = {"source": "output", "many": "next", "given": "next"} | dict.fromkeys(WORDS, "next")
    wires = [f"{a}.{ports[a]} -> {b}.input" for a, b in itertools.pairwise(chain)]
    probes = [f"{name}.{port}" for name in WORDS[::4] for port in few if NAME.fullmatch(port)]
    probes += [f"many.{port}" for port in PORTS if NAME.fullmatch(port) and port != "update"]
    probes += [f"given.{port}" for port in PORTS[:9] if NAME.fullmatch(port)]
    text = f"wires = {wires}\nprobes = {probes}\n".replace("'", '"')
    text += '[blocks.source]\nkind = "Sine"\namplitude = 1e-3\nfrequency = "100 Hz"\n[blocks.many]\nkind = "Many"\n'
    text += '[blocks.given]\nkind = "Set"\n' + "".join(f'[blocks.{name}]\nkind = "Few"\n' for name in WORDS)
    graph = read(tmp_path, blocks, text)
    found = same_everywhere(graph, 20)
    plain = {f"block_{i}": name for i, name in enumerate(WORDS)}
    for new, old in plain.items():
        text = (
            text.replace(f'"{old}.', f'"{new}.')
            .replace(f"-> {old}.", f"-> {new}.")
            .replace(f"blocks.{old}]", f"blocks.{new}]")
        )
    (tmp_path / "own.toml").write_text(f'name = "own"\nrate = "1 kHz"\n{text}')
    renamed = simulate(
        read_graph(tmp_path / "own.toml", load_own_blocks(tmp_path / "own.py")), samples=20, engine="python"
    )
    for name, values in found.items():
        block, _, port = name.rpartition(".")
        new = next((n for n, old in plain.items() if old == block), block)
        assert renamed[f"{new}.{port}"].values.tobytes() == values.tobytes()


def test_a_place_is_given_once() -> None:
    slots = Slots[Given]()
    slots.add(StreamOf("noise"), int)
    slots.add(ConstantOf("noise", "stream"), float)
    with pytest.raises(DuplicateKeyError):
        slots.add(StreamOf("noise"), int)


def test_different_ports_have_different_variables() -> None:
    names = [*PORTS, *(f"{port}_0" for port in PORTS), *(f"{port}__0" for port in PORTS)]
    made = {variable(("a.b", name)) for name in names}
    assert len(made) == len(set(names))
