"""Faults in functions of own blocks end a run in every engine, in the same tick, with the same words."""

import dataclasses
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from proofmass.blocks.declaration.catalog import load_own_blocks
from proofmass.graphs.files.toml_reader import read_graph
from proofmass.runner.contract.foreign import FOREIGN, Foreign
from proofmass.runner.contract.outcomes import Sensor, foreign_differences, outcome
from proofmass.runner.plan.keys import WireOf
from proofmass.runner.planning.plan import plan
from proofmass.runner.run.engine_table import EngineName
from proofmass.runner.run.simulate import RunError, simulate
from proofmass.runner.targets.native import CompiledPlan
from proofmass.runner.targets.native_lanes import CompiledLanes, Lanes

ENGINES: list[EngineName] = ["python", "compiled"]


def root_of(negative: float) -> str:
    """Python's words, which differ from version to version, for a root that is not real."""
    with pytest.raises(ValueError) as refused:  # noqa: PT011 its words are what is asked for
        math.sqrt(negative)
    return str(refused.value)


FILE = '''
import math
from typing import NamedTuple

from proofmass import Block, Buffer, Input, param


class State(NamedTuple):
    count: int
    level: float


def cooled(a: float, times: int) -> float:
    """Halved so often."""
    if times > 100:
        raise ValueError("too often")
    for _ in range(times):
        a = a / 2.0
    return a


'''
BLOCK = '''
class {name}(Block):
    """Fails in tick 60."""

    limit: float = param("1", "Limit.", default=60.0)
    input = Input("1", "A ramp of 1 a tick.")
    line = Buffer("Line.", float, (60,))


@{name}.output("1")
def level(p, x: State, line, input: float) -> float:
    """Level."""
    {output}


@{name}.update
def update(p, x: State, line, input: float) -> State:
    {update}
    return State(x.count + 1, input)


'''
FAULTS = {
    "raised": (
        'if input >= p.limit:\n        raise ValueError(f"at {input}")\n    return input',
        "pass",
        "level",
        "ValueError: at 60.0",
    ),
    "asserted": ('assert input < p.limit, "too large"\n    return input', "pass", "level", "AssertionError: too large"),
    "called": ("return cooled(input, x.count * 2 - 19)", "pass", "level", "ValueError: too often"),
    "divided": ("return 1.0 / (1.0 / (input - p.limit))", "pass", "level", "ZeroDivisionError"),
    "whole": ("return input", "a = 7 // (60 - x.count)", "update", "ZeroDivisionError"),
    "beyond": (
        "return input",
        "a = 153722867280912931 * x.count",
        "update",
        "OverflowError: an integer does not fit 64 bits",
    ),
    "entry": ("return line[x.count]", "pass", "level", "IndexError: there is no entry 60 among 60"),
    "stored": ("return input", "line[x.count] = input", "update", "IndexError: there is no entry 60 among 60"),
    "shift": ("return float(1 << (59 - x.count))", "pass", "level", "ValueError: a negative shift or power"),
    "root": ("return min(math.sqrt(59.5 - input), 3.0)", "pass", "level", f"ValueError: {root_of(-0.5)}"),
    "long": (
        "for i in range(x.count * 279621):\n        if i > 9:\n            break\n    return input",
        "pass",
        "level",
        "RuntimeError: a range of over 16,777,216",
    ),
    "endless": (
        "while input >= p.limit:\n        input = input + 0.0\n    return input",
        "pass",
        "level",
        "RuntimeError: a loop of over 16,777,216 turns",
    ),
    "converted": (
        "return float(int(1e17 * input * (1.0 if x.count < 60 else 10.0)))",
        "pass",
        "level",
        "OverflowError",
    ),
}


def own(folder: Path) -> dict[str, Any]:
    """A block for each fault, all in one file."""
    path = folder / "faults.py"
    text = FILE
    for name, (output, update, _, _) in FAULTS.items():
        text += BLOCK.format(name=name.title(), output=output, update=update)
    path.write_text(text)
    return load_own_blocks(path)


def graph_of(folder: Path, *names: str, limit: float | None = None) -> Any:
    wires = [f'"ramp.output -> {name}.input"' for name in names]
    probes = [f'"{name}.level"' for name in names]
    text = f'name = "faults"\nrate = "1 Hz"\nwires = [{", ".join(wires)}]\nprobes = [{", ".join(probes)}]\n'
    text += '[blocks.ramp]\nkind = "Ramp"\nslope = "1 1/s"\n'
    for name in names:
        text += f'[blocks.{name}]\nkind = "{name.title()}"\n' + (f"limit = {limit}\n" if limit else "")
    (folder / "faults.toml").write_text(text)
    return read_graph(folder / "faults.toml", own(folder))


@pytest.mark.exhaustive("endless")
@pytest.mark.defect(
    "S14", before="n // 0, overflow, an index beyond the end pass compiled code", after="the run ends, in every engine"
)
@pytest.mark.parametrize("name", FAULTS)
def test_the_tick_and_the_block_are_named(name: str, tmp_path: Path) -> None:
    _, _, function, told = FAULTS[name]
    graph, texts = graph_of(tmp_path, name), set[str]()
    for engine in ENGINES if name in ("raised", "beyond", "stored") else ENGINES[:1]:
        with pytest.raises(RunError) as caught:
            simulate(graph, samples=200, engine=engine)
        texts.add(str(caught.value))
    assert len(texts) == 1
    [text] = texts
    assert f"{name}.{function}: failed in tick 60, t = 60 s" in text
    assert told in text
    assert "faults.py:" in text
    assert "unstable" not in text


@pytest.mark.exhaustive
@pytest.mark.defect(
    "C4", before="raise in a block, compiled: an error inside proofmass, status 1", after="block, tick, line and words"
)
def test_compiled_code_notes_each_fault_in_its_tick(tmp_path: Path) -> None:
    """All blocks in one loop, which runs to the tick before the fault and not through it."""
    simulate(graph_of(tmp_path, *FAULTS), samples=60, engine="compiled")
    with pytest.raises(RunError, match="failed in tick 60"):
        simulate(graph_of(tmp_path, *FAULTS), samples=61, engine="compiled")


@pytest.mark.exhaustive
@pytest.mark.parametrize("compiler", FOREIGN, ids=lambda compiler: compiler.name)
def test_c_and_webassembly_note_each_fault_in_its_tick(compiler: Foreign, tmp_path: Path) -> None:
    names = ["raised", "whole", "beyond", "entry", "shift", "root"]
    for name in names:
        planned = plan(graph_of(tmp_path, name))
        loop, sensor = CompiledPlan(planned), Sensor(planned)
        if compiler.lacks(loop.written.program):
            pytest.skip(compiler.lacks(loop.written.program))
        expected = outcome(sensor, 200)
        assert (expected.ticks, FAULTS[name][3] in expected.fault) == (60, True)
        assert list(foreign_differences(compiler, loop, [sensor], [expected])) == []


def test_lanes_note_the_faults_of_each_run(tmp_path: Path) -> None:
    """Lanes with other limits: some fail, the others are what they are alone."""
    planned = plan(dataclasses.replace(graph_of(tmp_path, "raised", "whole"), probes=()))
    node = ("raised", "limit")
    compiled = CompiledLanes(planned, frozenset({node}), 16)
    limits = [30.0 + 2.0 * lane for lane in range(16)]
    lanes = Lanes(compiled, 0, range(16), {node: np.array(limits)})
    lanes.advance(50)
    assert lanes.sound().tolist() == [limit > 49.0 for limit in limits]
    assert lanes.value(WireOf("raised", "level")).tolist()[10:] == [49.0] * 6
    lanes.advance(61)
    assert not lanes.sound().any()


TANKS = '''
import math
from typing import NamedTuple

from proofmass import Block, Input


class Flow(NamedTuple):
    height: float


class Tank(Block):
    """height' = sqrt(2.5 - input) - height."""

    input = Input("1", "Pressure.")


@Tank.output("1")
def height(p, x: Flow) -> float:
    """Height."""
    return x.height


@Tank.derivative(linear=False)
def derivative(p, x: Flow, input: float) -> Flow:
    return Flow(min(math.sqrt(2.5 - input), 1.0) - x.height)


class Bucket(Block):
    """height' = input until the height is 2: then it is the root of 2 less the input."""

    input = Input("1", "Flow.")


@Bucket.output("1")
def level(p, x: Flow) -> float:
    """Height."""
    return x.height


@Bucket.derivative(linear=False)
def filling(p, x: Flow, input: float) -> Flow:
    return Flow(input)


def emptied(p, x: Flow, input: float) -> Flow:
    return Flow(math.sqrt(2.0 - input))


@Bucket.event(then=emptied)
def full(p, x: Flow) -> float:
    return 2.0 - x.height
'''
BETWEEN_TICKS = {
    "derivative": ("Tank", "height", '"ramp.output -> tank.input"', 3),
    "derivatives": ("Tank", "height", '"ramp.output -> tank.input", "tank.height -> next.input"', 3),
    "full": ("Bucket", "level", '"ramp.output -> tank.input"', 3),
}


@pytest.mark.parametrize("function", BETWEEN_TICKS)
def test_a_fault_between_ticks_ends_the_run(function: str, tmp_path: Path) -> None:
    """The input of tick n is n and held: the bucket is full in tick 2, which leaves 0, and in tick 3, which fails."""
    kind, port, wires, tick = BETWEEN_TICKS[function]
    (tmp_path / "faults.py").write_text(TANKS)
    text = f'rate = "1 Hz"\nwires = [{wires}]\nprobes = ["tank.{port}"]\n[blocks.tank]\nkind = "{kind}"\n'
    text += '[integration]\nmethod = "runge_kutta_4"\n' * (kind == "Tank")
    text += '[blocks.ramp]\nkind = "Ramp"\nslope = "1 1/s"\n' + '[blocks.next]\nkind = "Tank"\n' * ("next" in wires)
    (tmp_path / "tank.toml").write_text(text)
    graph, texts = read_graph(tmp_path / "tank.toml", load_own_blocks(tmp_path / "faults.py")), set[str]()
    for engine in ENGINES:
        assert math.isfinite(simulate(graph, samples=tick, engine=engine)[f"tank.{port}"].values[-1])
        with pytest.raises(RunError) as caught:
            simulate(graph, samples=20, engine=engine)
        texts.add(str(caught.value))
    assert len(texts) == 1
    text = texts.pop()
    assert f"tank.{function.rstrip('s')}: failed in tick {tick}" in text
    raising = "math.sqrt(2.0 - input)" if kind == "Bucket" else "math.sqrt(2.5 - input)"
    line = next(number for number, line in enumerate(TANKS.splitlines(), 1) if raising in line)
    assert f"faults.py:{line} raises it" in text
