"""Blocks of a user's own: what may be declared, and what of it is told where the file is loaded or checked."""

from pathlib import Path

import numpy as np
import pytest

from proofmass import noise
from proofmass.blocks.declaration.catalog import load_own_blocks
from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.checks.check import check
from proofmass.graphs.files.toml_reader import read_graph, read_graph_text
from proofmass.runner.command_line import main
from proofmass.runner.run.simulate import simulate

FILE = """from __future__ import annotations

import math
from typing import NamedTuple

from proofmass import Block, Input, param


class Mine(Block):
    \"\"\"A block of the user's own.\"\"\"

    gain: float = param("1", "Gain.", default=2)
    taps: tuple[float, ...] = param("1", "Taps.", default=(0.5, 0.25))
    input = Input("1", "Input.")


@Mine.output("1")
def level(p, input: float) -> float:
    \"\"\"Level.\"\"\"
    return p.gain * input
"""
GRAPH = """name = "mine"
rate = "1 kHz"
samples = 5
wires = ["source.output -> mine.input"]
probes = ["mine.level"]
[blocks.source]
kind = "Constant"
value = 3.0
[blocks.mine]
kind = "Mine"
"""
STATEFUL = """

class State(NamedTuple):
    level: float
    count: int


class Constants(NamedTuple):
    weights: tuple[float, ...]
    places: tuple[int, ...]


@Mine.constants
def constants(p: Mine, period: float) -> Constants:
    return Constants(tuple(tap / 3.0 for tap in p.taps), (2, 0))


@Mine.output("1")
def level(c, x: State, input: float) -> float:
    \"\"\"Level.\"\"\"
    return x.level + c.weights[x.count % 2]


@Mine.update
def update(c, x: State, input: float) -> State:
    return State(input + c.places[x.count % 2], x.count + 1)
"""


def both(folder: Path, blocks: str, graph: str = GRAPH) -> list[float]:
    """The values in plain Python, which compiled code must have too."""
    (folder / "own.py").write_text(blocks)
    (folder / "own.toml").write_text(graph)
    read = read_graph(folder / "own.toml", load_own_blocks(folder / "own.py"))
    assert check(read) == []
    python, compiled = (simulate(read, engine=engine)["mine.level"].values for engine in ("python", "compiled"))  # type: ignore[arg-type]
    assert python.tobytes() == compiled.tobytes()
    return python.tolist()  # type: ignore[no-any-return]


@pytest.mark.defect(
    "S14", before="no attribute taps, though it is declared", after="a list is read as other parameters are"
)
def test_a_list_among_the_parameters_is_read_in_the_loop(tmp_path: Path) -> None:
    body = "    total = 0\n    for tap in p.taps:\n        total += tap * input\n    return total + p.taps[-1]"
    blocks = FILE.replace("    return p.gain * input", body)
    assert both(tmp_path, blocks) == [2.5] * 5
    changed = GRAPH + "taps = [1.0, 2.0, 3.0]\n"
    assert both(tmp_path, blocks, changed) == [21.0] * 5


def test_a_list_beside_a_parameter_that_is_driven(tmp_path: Path) -> None:
    blocks = FILE.replace("return p.gain * input", "return p.gain * p.taps[0]")
    assert both(tmp_path, blocks, GRAPH.replace("wires = [", 'wires = ["source.output -> mine.gain", ')) == [1.5] * 5


@pytest.mark.defect("H2", before="a tuple of floats in Constants: internal TypeError", after="it is held as declared")
def test_tuples_of_numbers_among_the_constants(tmp_path: Path) -> None:
    blocks = FILE[: FILE.index("@Mine.output")] + STATEFUL.lstrip()
    assert both(tmp_path, blocks) == [0.5 / 3.0, 5.0 + 0.25 / 3.0, 3.0 + 0.5 / 3.0, 5.0 + 0.25 / 3.0, 3.0 + 0.5 / 3.0]


def test_types_that_are_annotated_as_texts_are_types(tmp_path: Path) -> None:
    assert both(tmp_path, FILE) == [6.0] * 5


def told(folder: Path, capsys: pytest.CaptureFixture[str], old: str, new: str) -> str:
    """What `check` prints of the file with a change."""
    assert old in FILE
    (folder / "own.py").write_text(FILE.replace(old, new))
    (folder / "own.toml").write_text(GRAPH)
    assert main(["check", str(folder / "own.toml"), "--blocks", str(folder / "own.py")]) == 1
    return "".join(capsys.readouterr())


FAULTS = {
    'Mine.output("1")|Mine.output("Volt")': ("own.py:17: ", "Mine.level: unknown unit 'Volt'"),
    'Input("1", "Input.")|Input("Volt", "Input.")': ("own.py:9: ", "Mine.input: unknown unit 'Volt'"),
    "default=2)|default=-10.0, at_least=0.0)": ("own.py:9: ", "Mine.gain: its default -10.0 must be >= 0"),
    'default=2)|default="two")': ("own.py:9: ", "Mine.gain: its default 'two'"),
    "    gain: float|    c: float": (
        "own.py:9: ",
        "Mine.c: the name is taken; c is the constants, the first argument of functions",
    ),
    "    input = Input|    taps = Input": ("own.py:", "taps"),
    "def level(p|def input(p": (
        "own.py:17: ",
        "Mine.input: the name is taken; it is the name of an input of the block",
    ),
    "def level(p, input|def level(input": ("own.py:17: ", "Mine.level: the first argument is the constants"),
    "class Mine(Block)|class Gain(Block)": ("own.py:9: ", "the library has a block of this name"),
}


@pytest.mark.defect(
    "S14", before="a unit Volt, a default out of bounds, a class Gain are taken in silence", after="told by check"
)
@pytest.mark.parametrize("fault", FAULTS)
@pytest.mark.friendly(18, "what is declared wrong is told with its line")
def test_what_is_declared_wrong_is_told_with_its_line(
    fault: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    old, new = fault.split("|")
    blocks = told(tmp_path, capsys, old, new) if "Gain" not in fault else _as_gain(tmp_path, capsys)
    for part in FAULTS[fault]:
        assert part in blocks


def _as_gain(folder: Path, capsys: pytest.CaptureFixture[str]) -> str:
    (folder / "own.py").write_text(FILE.replace("Mine", "Gain"))
    (folder / "own.toml").write_text(GRAPH.replace("Mine", "Gain"))
    assert main(["check", str(folder / "own.toml"), "--blocks", str(folder / "own.py")]) == 1
    return "".join(capsys.readouterr())


@pytest.mark.friendly(20, "breakpoint() stops in the block")
def test_breakpoint_is_of_plain_python(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    stopped = list[int]()
    monkeypatch.setattr("sys.breakpointhook", lambda: stopped.append(1))
    assert both(tmp_path, FILE.replace("    return p.gain", "    breakpoint()\n    return p.gain")) == [6.0] * 5
    assert len(stopped) == 5


def test_a_file_that_is_edited_after_it_was_loaded_changes_nothing(tmp_path: Path) -> None:
    (tmp_path / "own.py").write_text(FILE)
    (tmp_path / "own.toml").write_text(GRAPH)
    graph = read_graph(tmp_path / "own.toml", load_own_blocks(tmp_path / "own.py"))
    (tmp_path / "own.py").write_text(FILE.replace("p.gain * input", "p.gain + input"))
    assert simulate(graph, engine="python")["mine.level"].values.tolist() == [6.0] * 5
    (tmp_path / "own.py").unlink()
    assert simulate(graph, engine="python")["mine.level"].values.tolist() == [6.0] * 5


@pytest.mark.defect("S640", before="plain Python computes it anew for each entry: 6 for 3", after="once")
def test_a_value_for_several_entries_is_computed_once(tmp_path: Path) -> None:
    buffered = FILE.replace("from proofmass import Block,", "from proofmass import Block, Buffer,").replace(
        "    input = Input", "    line = Buffer('Line.', float, (2,))\n    input = Input"
    )
    functions = """

@Mine.output("1")
def level(p, line, input: float) -> float:
    \"\"\"Level.\"\"\"
    return line[1]


class State(NamedTuple):
    count: int


@Mine.update
def update(p, x: State, line, input: float) -> State:
    line[0] = line[1] = line[0] + input
    return x
"""
    head = buffered.partition("@Mine.output")[0]
    assert both(tmp_path, head + functions) == [0.0, 3.0, 6.0, 9.0, 12.0]


BEGINNING = """from typing import NamedTuple

from proofmass import Block, Buffer


class Mine(Block):
    \"\"\"What it begins with.\"\"\"

    last = Buffer("Integers.", int, (2,))


class State(NamedTuple):
    count: int = 5
    level: float = 2


@Mine.output("1")
def level(p, x: State, last) -> float:
    \"\"\"Level.\"\"\"
    return x.level + x.count + 100.0 * last[0]


@Mine.update
def update(p, x: State, last) -> State:
    return State(x.count + 1)
"""
ALONE = 'name = "own"\nrate = "1 kHz"\nsamples = 3\nprobes = ["mine.level"]\nblocks.mine = { kind = "Mine" }\n'


@pytest.mark.defect(
    "S1018", before="the defaults of a state's fields were left out: it began at zero", after="with them"
)
def test_a_state_begins_with_the_defaults_of_its_fields(tmp_path: Path) -> None:
    assert both(tmp_path, BEGINNING, ALONE) == [7.0, 8.0, 9.0]
    assert both(tmp_path, BEGINNING.replace("count: int = 5", "count: int"), ALONE) == [2.0, 3.0, 4.0]


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("    return State(5.7, 0.0)", "count must be of type int, and is 5.7"),
        ("    return State(None, 0.0)", "count must be of type int, and is None"),
        ("    return State((1, 2), 0.0)", r"count must be of type int, and is \(1, 2\)"),
        ("    return State(1, '0.0')", "level must be of type float, and is '0.0'"),
        ("    last[0] = 2.5\n    return State()", "last must be of type int, and is 2.5"),
        ("    last.append(1)\n    return State()", "last must keep its 2 entries, and has 3"),
    ],
)
@pytest.mark.defect("S1019", before="5.7 for an integer of a state or of constants was 5", after="refused, with a cure")
@pytest.mark.defect(
    "S1020", before="2.5 in a buffer of integers was 2.5 in plain Python, 2 in machine code", after="refused"
)
@pytest.mark.defect("C892", before="None in a state ended in an error inside proofmass", after="refused")
def test_a_start_is_of_the_types_that_are_declared(tmp_path: Path, line: str, said: str) -> None:
    (tmp_path / "own.py").write_text(f"{BEGINNING}\n\n@Mine.start\ndef start(p: Mine, last) -> State:\n{line}\n")
    graph = read_graph_text(ALONE, own=load_own_blocks(tmp_path / "own.py"))
    with pytest.raises(ModelError, match=said):
        simulate(graph, engine="python")


@pytest.mark.defect("S1021", before="of two `update` of a block the first was left out without a word", after="refused")
@pytest.mark.parametrize("role", ["update", "start"])
def test_a_block_has_one_function_of_each_role(tmp_path: Path, role: str) -> None:
    blocks = BEGINNING
    for name in ("first", "second"):
        blocks += f"\n\n@Mine.{role}\ndef {name}(p, x: State) -> State:\n    return State()\n"
    (tmp_path / "own.py").write_text(blocks.replace("p, x: State)", "p)") if role == "start" else blocks)
    with pytest.raises(TypeError, match=f"Mine.{role}: there is one already"):
        load_own_blocks(tmp_path / "own.py")


HOLDING = '''from proofmass import Block, Input


class Mine(Block):
    """Writes an entry now and then."""

    input = Input("1", "What is written.")
    gate = Input("1", "Above zero it is.")


@Mine.output("1", shape=(2,), dtype=float)
def entries(p, input: float, gate: float, out) -> None:
    """Entries."""
    out[0] = input
    if gate > 0.0:
        out[1] = input
'''
HELD = """name = "held"
rate = "1 kHz"
samples = 4000
wires = ["noise.output -> mine.input", "gate.output -> mine.gate", "mine.entries -> pick.vector"]
probes = ["pick.output"]
blocks.noise = { kind = "WhiteNoise", density = "0.1 1/sqrt(Hz)", unit = "1" }
blocks.gate = { kind = "Pulse", repetition = "4 ms", duty = 0.25, amplitude = 2.0, offset = -1.0 }
blocks.mine = { kind = "Mine" }
blocks.pick = { kind = "DotProduct", weights = [0.0, 1.0] }
"""


@pytest.mark.defect("S1022", before="a sum of all ticks: 22.4 rms in the budget, 25.8 in a run", after="of this one")
@pytest.mark.defect("S1035", before="an entry kept: 1.118 rms in the noise budget, 2.25 in a run", after="zero")
@pytest.mark.parametrize("written", ["out[1] = input", "out[1] += 0.5 * input\n        out[1] *= 2.0"])
def test_an_output_begins_each_tick_with_zeros(tmp_path: Path, written: str) -> None:
    """White noise of 0.1 / sqrt(Hz) is sqrt(5) rms at 1 kHz; one value in four is half of that."""
    (tmp_path / "own.py").write_text(HOLDING.replace("out[1] = input", written))
    graph = read_graph_text(HELD, own=load_own_blocks(tmp_path / "own.py"))
    values = simulate(graph, engine="compiled")["pick.output"].values
    assert np.array_equal(values[:64], simulate(graph, engine="python", samples=64)["pick.output"].values)
    assert not values.reshape(-1, 4)[:, 1:].any()
    expected = 0.5 * np.sqrt(5.0)
    assert np.sqrt(np.mean(values**2)) == pytest.approx(expected, rel=0.05)
    assert noise(graph, "pick.output").rms == pytest.approx(expected, rel=1e-9)
