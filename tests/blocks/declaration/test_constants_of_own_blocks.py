"""What `constants` of a user's own block may take, return and raise."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from proofmass import margins, read_graph, simulate
from proofmass.blocks.declaration.catalog import load_own_blocks
from proofmass.blocks.declaration.problem import ModelError
from proofmass.blocks.language.forms import problems_of
from proofmass.runner.command_line import main
from proofmass.runner.plan.memory import start
from proofmass.runner.planning.plan import plan, varied
from proofmass.runner.run.engine_table import EngineName
from proofmass.runner.targets.native import CompiledLoop, CompiledPlan

BLOCK = '''
from typing import NamedTuple

from proofmass import Block, Input, param


class Pair(NamedTuple):
    first: float
    second: int


class Constants(NamedTuple):
    table: tuple
    nested: tuple[tuple[float, int], ...]
    {field}


class Mine(Block):
    """A block of the user's own."""

    gain: float = param("1", "Gain.", default=2.0)
    input = Input("1", "Input.")


@Mine.constants
def constants({given}) -> Constants:
    return Constants((p.gain, 4.0 * p.gain), ((1.0, 2), (3.0, 4)), {value})


@Mine.output("1")
def level(c: Constants, input: float) -> float:
    """Level."""
    return {level}
'''
GRAPH = """
rate = "1 kHz"
samples = 3
wires = [
    "error.output -> mine.input", "mine.level -> delay.input", "delay.output -> error.second",
    "one.output -> error.first",
]
probes = ["mine.level"]
[blocks]
one = {kind = "Constant", value = 1.0}
error = {kind = "Difference"}
mine = {kind = "Mine", gain = 0.125}
delay = {kind = "UnitDelay"}
"""


def written(folder: Path, field: str = "more: float", value: str = "1.0", level: str = "", given: str = "p") -> Path:
    path = folder / "mine.py"
    text = BLOCK.format(field=field, value=value, level=level or "(c.table[0] + c.table[1]) * input", given=given)
    path.write_text(text)
    (folder / "loop.toml").write_text(GRAPH)
    return path


@pytest.mark.defect(
    "S740", before="constants(p) without period: an error inside proofmass", after="it is called as it is written"
)
def test_constants_without_a_period_are_called_as_they_are_written(tmp_path: Path) -> None:
    own = load_own_blocks(written(tmp_path, "pairs: tuple[int, float]", "(1, 0.5)"))
    graph = read_graph(tmp_path / "loop.toml", own)
    for engine in ("python", "compiled"):
        values = simulate(graph, engine=engine)["mine.level"].values
        assert list(values) == [0.625, 0.625 * (1.0 - 0.625), 0.625 * (1.0 - 0.625 * (1.0 - 0.625))]
    with_period = load_own_blocks(written(tmp_path, given="p, period"))
    assert list(simulate(read_graph(tmp_path / "loop.toml", with_period))["mine.level"].values) == list(values)
    loop = margins(graph)
    assert loop.gain_margin == pytest.approx(1.0 / 0.625)


def test_tables_that_follow_from_a_varied_parameter_are_made_anew(tmp_path: Path) -> None:
    graph = read_graph(tmp_path / "loop.toml", load_own_blocks(written(tmp_path)))
    planned = plan(graph)
    made = CompiledPlan(planned)
    for gain in (0.125, 0.0625, 0.1875):
        sensor = varied(planned, {"mine": dataclasses.replace(graph.blocks["mine"], gain=gain)})
        values, level = np.empty(3), 5.0 * gain
        assert CompiledLoop(sensor, 0, 0, start(sensor), made).advance(3, [values])
        assert list(values) == [level, level * (1.0 - level), level * (1.0 - level * (1.0 - level))]


@pytest.mark.parametrize("engine", ["python", "compiled"])
@pytest.mark.parametrize(
    ("field", "value", "level"),
    [
        ("pair: tuple[int, float]", "(7, 4.0 * p.gain)", "(c.pair[0] // 2 + c.pair[1]) * input"),
        ("pair: tuple[float, int]", "(4.0 * p.gain, 7)", "(c.pair[1] // 2 + c.pair[0]) * input"),
        (
            "three: tuple[int, float, bool]",
            "(7, 0.25, True)",
            "(c.three[0] // 2 + 2 * c.three[1] * c.three[2]) * input",
        ),
        ("many: tuple[int, ...]", "(7, 9, 1)", "(c.many[0] // 2 + c.many[2] / 2) * input"),
        ("more: float", "0.5", "(c.nested[0][1] + 1 + 0.5 * c.nested[0][0] ** c.nested[1][1]) * input"),
    ],
)
def test_entries_of_a_table_have_types_of_their_own(
    engine: EngineName, field: str, value: str, level: str, tmp_path: Path
) -> None:
    """The level is 3.5 times the input."""
    own = load_own_blocks(written(tmp_path, field, value, level))
    values = simulate(read_graph(tmp_path / "loop.toml", own), engine=engine)["mine.level"].values
    assert list(values) == [3.5, 3.5 * (1.0 - 3.5), 3.5 * (1.0 - 3.5 * (1.0 - 3.5))]


REFUSED = {
    "more: str": "'a'",
    "more: tuple[str, ...]": "('a', 'b')",
    "more: tuple[str, float]": "('a', 1.0)",
    "more: tuple[tuple[str, ...], ...]": "(('a',),)",
    "more: Pair": "Pair(1.0, 2)",
}


@pytest.mark.defect(
    "S741", before="a text among the constants of an own block: an error inside proofmass", after="named by check"
)
@pytest.mark.parametrize("field", REFUSED)
@pytest.mark.parametrize("level", ["c.more[0]", "c.more[0] if input > 0.0 else 1.0", "min(c.more[0], 1.0)", "input"])
def test_constants_that_no_engine_holds_are_named_once(field: str, level: str, tmp_path: Path) -> None:
    found = problems_of(load_own_blocks(written(tmp_path, field, REFUSED[field], level))["Mine"])
    assert [problem.message for problem in found if "no engine holds" in problem.message] == [
        "the field more of Constants has a type that no engine holds"
    ]


@pytest.mark.defect("S742", before="what an own block raises: an error inside proofmass", after="its file and line")
@pytest.mark.parametrize("command", [["check"], ["run"], ["margins"]])
def test_what_constants_raise_has_its_line(
    command: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = written(tmp_path, value="p.missing")
    line = path.read_text().splitlines().index(next(t for t in path.read_text().splitlines() if "p.missing" in t)) + 1
    assert main([*command, str(tmp_path / "loop.toml"), "--blocks", str(path)]) == 1
    told = capsys.readouterr().err
    assert (
        f"{path}:{line}: constants() of a block raises AttributeError: 'Mine' object has no attribute 'missing'" in told
    )
    assert "inside proofmass" not in told


def test_any_callable_may_be_asked_for_requirements(tmp_path: Path) -> None:
    path = written(tmp_path)
    text = "import functools\n\n\ndef above(least, p):\n    if p.gain <= least:\n"
    text += "        yield 'gain', f'more than {least}'\n\n\n"
    path.write_text(f"{path.read_text()}\n\n{text}Mine.requires(functools.partial(above, 0.1))\n")
    kind = load_own_blocks(path)["Mine"]
    assert problems_of(kind) == []
    with pytest.raises(ModelError, match=r"more than 0\.1"):
        kind(gain=0.1)


@pytest.mark.parametrize("role", ["requires", "start"])
def test_what_else_runs_once_has_its_line_too(role: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = written(tmp_path)
    path.write_text(path.read_text() + f"\n\n@Mine.{role}\ndef wrong(p) -> Pair:\n    return [][1]\n")
    assert main(["run", str(tmp_path / "loop.toml"), "--blocks", str(path)]) == 1
    line = len(path.read_text().splitlines())
    assert f"{path}:{line}: wrong() of a block raises IndexError: list index out of range" in capsys.readouterr().err
