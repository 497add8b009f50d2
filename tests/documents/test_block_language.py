"""Every example of `docs/block-language.md` runs in every engine, with the same bits, and as Python itself has it."""

import math
import re
import struct
from pathlib import Path
from typing import Any

import pytest

from proofmass.blocks.declaration.catalog import load_own_blocks
from proofmass.blocks.language.operations import INSTEAD
from proofmass.runner.contract.cases import TESTED, cases
from proofmass.runner.contract.contract import check_block
from proofmass.runner.reference.interpret import Interpreter
from proofmass.runner.run.recorder import room

PAGE = (Path(__file__).parents[2] / "docs" / "block-language.md").read_text(encoding="utf-8")
HEAD = '''
import enum
import math
from typing import NamedTuple

from proofmass import Block, Buffer, Input, param

GAIN, TABLE = 2.5, (0.5, -1.25, 3.0)


class Pair(NamedTuple):
    first: float
    second: float


class Mode(enum.IntEnum):
    WAIT = 3
    RUN = 7


ORIGIN = Pair(0.25, -0.5)
CELLS = (Pair(1.0, 2.0), Pair(3.0, 4.0))


def half(a: float) -> float:
    return 0.5 * a


def scaled(a: float, factor: float = 2.0) -> float:
    return factor * a


class State(NamedTuple):
    level: float
    count: int


class Examples(Block):
    """The examples of a table."""

    taps: tuple[float, ...] = param("1", "Some weights.", default=(0.5, 0.25))
    first = Input("1", "A number.")
    second = Input("1", "Another.")
    whole = Input("1", "An integer.", int)
    other = Input("1", "Another.", int)
    bit = Input("1", "True or false.", bool)
    line = Buffer("Some samples.", float, (4,))


@Examples.update
def update(p, x: State, line, first: float) -> State:
    line[x.count % 4] = first
    return State(0.5 * x.level + first, x.count + 1)
'''
OUTPUT = '''

@Examples.output("1")
def example_{number}(p, x: State, line, first: float, second: float, whole: int, other: int, bit: bool) -> float:
    """`{text}`."""
    a, b, n, t = first, second, whole, bit
    u, k, m = 0.001 + abs(a) / 6.0, n % 7, 1 + other % 9
    return float({text})
'''


def examples(table: int) -> list[str]:
    """What stands in the first column of a table, one after the other."""
    [tables] = re.findall(r"^## Expressions$(.*?)^## Statements$", PAGE, re.DOTALL | re.MULTILINE)
    rows = re.split(r"^\| write \| for \|$", tables, flags=re.MULTILINE)[1:][table]
    cells = re.findall(r"^\| (`.*?) \|", rows.replace("\\|", "\0"), re.MULTILINE)
    found = [text.replace("\0", "|") for cell in cells for text in re.findall(r"`([^`]+)`", cell)]
    found += [
        text
        for text in re.findall(r"`([^`]+)`", "".join(re.findall(r"^\| `.*? \| (.*) \|$", rows, re.MULTILINE)))
        if re.fullmatch(r"[nm-].*[nm]", text)
    ]
    return found


def block_of(table: int, folder: Path, apart: int = 1) -> Any:
    """A block that has an output for each example of a table, or for every `apart`-th."""
    outputs = (OUTPUT.format(number=number, text=text) for number, text in enumerate(examples(table)[::apart]))
    (folder / "examples.py").write_text(HEAD + "".join(outputs))
    return load_own_blocks(folder / "examples.py")["Examples"]


@pytest.mark.exhaustive
@pytest.mark.parametrize("table", [0, 1])
@pytest.mark.parametrize("apart", [8, pytest.param(1, marks=pytest.mark.exhaustive)])
def test_expressions_in_every_engine(table: int, apart: int, tmp_path: Path) -> None:
    assert len(examples(table)) > (25 if table else 60)
    report = check_block(block_of(table, tmp_path, apart), sets=1)
    assert report.passed, report
    assert "0 of 8 runs end early" in report.verdicts[-1].detail
    elsewhere = [verdict.check for verdict in report.verdicts if "with other last bits" in verdict.detail]
    assert elsewhere == (["WebAssembly"] if table else [])


@pytest.mark.parametrize("table", [0, 1])
def test_expressions_mean_what_python_means(table: int, tmp_path: Path) -> None:
    """The functions as Python runs them, with nothing of this package between."""
    kind = block_of(table, tmp_path)
    [case] = cases(kind, tmp_path, hostile=False, sets=1)
    planned, line = case.sensors[0].plan, [0.0] * 4
    drivers = {port: source for (block, port), source in planned.schedule.drivers.items() if block == TESTED}
    engine, x = Interpreter(planned, planned.graph.seed), planned.starts[TESTED]
    for tick in range(40):
        engine.advance(tick + 1, room(planned, 0, tick + 1))
        wires = engine.memory().wires
        for name, behaviour in kind.output_functions.items():
            given = (wires[drivers[argument]] for argument in behaviour.arguments[2:])
            value = behaviour.function(planned.constants[TESTED], x, line, *given)
            assert bits(value) == bits(wires[TESTED, name]), behaviour.function.__doc__
        x = kind.functions["update"].function(None, x, line, wires[drivers["first"]])


def bits(value: float) -> bytes:
    """The bits of a number; of NaN one is as good as another."""
    return b"nan" if math.isnan(value) else struct.pack("d", value)


@pytest.mark.exhaustive
def test_statements_in_every_engine(tmp_path: Path) -> None:
    fences = re.findall(r"^```python\n(.*?)^```$", PAGE, re.DOTALL | re.MULTILINE)
    assert fences
    for number, text in enumerate(fences):
        path = tmp_path / f"blocks_{number}.py"
        path.write_text(text)
        for kind in load_own_blocks(path).values():
            report = check_block(kind, sets=1)
            assert report.passed, report
            assert {v.check for v in report.verdicts if v.status == "not run" and "brings" in v.detail} == set()


def test_what_is_refused_is_on_the_page() -> None:
    refused = PAGE.partition("## What it may not contain")[2]
    named = {function.__name__ for function in INSTEAD if function not in (isinstance, str, list, dict, eval, exec)}
    assert [name for name in sorted(named) if name not in refused] == []
