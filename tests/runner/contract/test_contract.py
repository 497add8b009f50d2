"""The checks of a block: each finds the fault that it is there for, and says where it is."""

import dataclasses
import textwrap
from pathlib import Path

import pytest

from proofmass.blocks import Integrator
from proofmass.blocks.declaration.catalog import load_own_blocks
from proofmass.runner.contract import engines, outcomes
from proofmass.runner.contract.cases import LANES, Case, cases
from proofmass.runner.contract.contract import RUN, STILL, check_block
from proofmass.runner.contract.foreign import C99, FOREIGN, ForeignError
from proofmass.runner.contract.outcomes import Outcome
from proofmass.runner.plan.memory import start
from tests.by_hand.gcc import needs_gcc

SOUND = '''
import math
from typing import NamedTuple

from proofmass import Block, Buffer, Input, param

CALLS = [0]


class Mine(Block):
    """A mean that forgets."""

    weight: float = param("1", "How fast it forgets.", default=0.25, above=0.0, below=1.0)
    input = Input("V", "What is averaged.")
    line = Buffer("The last inputs.", float, (3,))


class State(NamedTuple):
    mean: float
    place: int


class Constants(NamedTuple):
    weight: float


@Mine.constants
def constants(p, period: float) -> Constants:
    return Constants(p.weight)


@Mine.output("V")
def mean(c, x: State, line) -> float:
    """The mean."""
    return x.mean + line[x.place]


@Mine.update
def update(c, x: State, line, input: float) -> State:
    line[x.place] = input
    return State(x.mean + c.weight * (input - x.mean), (x.place + 1) % 3)
'''
FAULTS = {
    "no docstring": ('"""A mean that forgets."""', "pass", "documents", "class Mine", "it has no docstring"),
    "no sentence": ("A mean that forgets.", "A mean", "documents", "class Mine", "does not begin with a sentence"),
    "no words": ("How fast it forgets.", " ", "documents", "eight: float", "Mine.weight: it has no description"),
    "no words of an output": ('"""The mean."""', "pass", "documents", "def mean", "Mine.mean: it has no description"),
    "no words of a buffer": ("The last inputs.", "", "documents", "line = Buffer", "Mine.line: it has no description"),
    "a name in capitals": ("weight", "Weight", "documents", "eight: float", "not written as others are"),
    "no unit": ('param("1"', 'param(""', "units", "weight: float", "an empty unit"),
    "a unit that does not fill in": (
        'input = Input("V"',
        'unit: str = param("", "Unit.", default="H")\n    input = Input("{unit}z"',
        "units",
        "input = Input",
        "Mine.input",
    ),
    "a bound too wide": ("above=0.0", "at_least=0.0", "bounds", "weight: float", "ZeroDivisionError"),
    "not compiled": (
        "    line[x.place] = input",
        "    print(input)",
        "functions",
        "print(input)",
        "print() is not compiled",
    ),
    "not repeatable": ("Constants(p.weight)", "Constants(counted())", "purity", "def constants", "another result"),
}
COUNTED = "\n\ndef counted() -> float:\n    CALLS[0] += 1\n    return float(CALLS[0])\n"


@pytest.fixture(scope="module")
def case(tmp_path_factory: pytest.TempPathFactory) -> Case:
    """Runs of an integrator."""
    [made] = cases(Integrator, tmp_path_factory.mktemp("case"), hostile=False, sets=1)
    return dataclasses.replace(made, ticks=20)


@pytest.mark.exhaustive
def test_a_sound_block_passes_all_that_can_be_run(tmp_path: Path) -> None:
    (tmp_path / "mine.py").write_text(SOUND)
    report = check_block(load_own_blocks(tmp_path / "mine.py")["Mine"])
    assert [verdict.check for verdict in report.verdicts] == [*STILL, *RUN]
    lacking = {compiler.name for compiler in FOREIGN if compiler.lacks(_program(tmp_path))}
    assert {v.check for v in report.verdicts if v.status != "passed"} == lacking
    assert report.passed


@pytest.mark.parametrize("fault", FAULTS)
def test_a_fault_is_found_by_its_check_with_its_line(fault: str, tmp_path: Path) -> None:
    old, new, check, line, message = FAULTS[fault]
    text = SOUND.replace(old, new) + (COUNTED if "counted" in new else "")
    if fault == "a bound too wide":
        text = text.replace("Constants(p.weight)", "Constants(1.0 / (p.weight / 1.0))")
    (tmp_path / "mine.py").write_text(text)
    kind = load_own_blocks(tmp_path / "mine.py")["Mine"]
    verdicts = {name: still(kind) for name, still in STILL.items()}
    assert {name for name, verdict in verdicts.items() if verdict.status == "FAILED"} == {check}
    problem = verdicts[check].problems[0]
    assert Path(problem.file).name == "mine.py"
    assert line in text.splitlines()[problem.line - 1]
    assert message in str(problem)


def test_what_no_engine_can_run_is_not_run(tmp_path: Path) -> None:
    (tmp_path / "mine.py").write_text(SOUND.replace("    line[x.place] = input", "    print(input)"))
    report = check_block(load_own_blocks(tmp_path / "mine.py")["Mine"])
    assert not report.passed
    assert {v.check for v in report.verdicts if v.status == "not run"} == set(RUN)
    data = report.as_data()
    assert data["passed"] is False
    assert [check["check"] for check in data["checks"] if check["problems"]] == ["functions"]


@pytest.mark.exhaustive
def test_a_difference_is_found_in_every_engine(case: Case) -> None:
    """What plain Python is said to give is changed in one bit."""
    wrong = [_one_bit_off(expected) for expected in case.outcomes]
    sensors, given, right = case.sensors, case.given, case.outcomes
    assert not list(outcomes.native_differences(case.compiled, sensors, right))
    assert not list(outcomes.lane_differences(sensors, right, given, LANES))
    assert not list(outcomes.resumed_differences(case.compiled, sensors, right))
    for texts in (
        outcomes.native_differences(case.compiled, sensors, wrong),
        outcomes.lane_differences(sensors, wrong, given, LANES),
        outcomes.resumed_differences(case.compiled, sensors, wrong),
    ):
        assert len({text.partition(":")[0] for text in texts}) == LANES
    late = [dataclasses.replace(expected, fault="there is one") for expected in right]
    assert all("no fault in tick 20" in text for text in outcomes.native_differences(case.compiled, sensors, late))
    assert any("no fault in tick 20" in text for text in outcomes.lane_differences(sensors, late, given, LANES))


@pytest.mark.exhaustive
@pytest.mark.parametrize("compiler", FOREIGN, ids=lambda compiler: compiler.name)
def test_a_difference_of_another_compiler_is_found(compiler: type, case: Case, monkeypatch: pytest.MonkeyPatch) -> None:
    run, compiled = engines.foreign, case.compiled
    if compiler.lacks(compiled.written.program):
        pytest.skip(compiler.lacks(compiled.written.program))
    assert run(Integrator, [case], compiler).status == "passed"
    other = type(compiler).run

    def one_more_tick(self: object, program: object, calls: list, folder: Path) -> None:  # type: ignore[type-arg]
        other(self, program, [([first, last - 1, *rest], arrays) for (first, last, *rest), arrays in calls], folder)

    monkeypatch.setattr(type(compiler), "run", one_more_tick)
    assert run(Integrator, [case], compiler).status == "FAILED"


@needs_gcc
def test_a_compiler_that_fails_says_so(case: Case, tmp_path: Path) -> None:
    program = case.compiled.written.program
    with pytest.raises(ForeignError, match=r"gcc fails: .*nonsense"):
        C99().compiled(program, tmp_path, ("--nonsense",))


def test_digests_tell_signs_of_zero_and_no_two_nan_apart(case: Case) -> None:
    planned = case.sensors[0].plan
    memory = start(planned)
    node = next(node for node, value in memory.wires.items() if isinstance(value, float))
    digests = set()
    for value in (0.0, -0.0, float("nan"), -float("nan")):
        memory.wires[node] = value
        digests.add(Outcome(0, (), memory.copy()).digest())
    assert len(digests) == 3


def _one_bit_off(expected: Outcome) -> Outcome:
    memory = expected.memory.copy()
    name, state = next((n, x) for n, x in memory.states.items() if x is not None and n == "tested")
    memory.states[name] = type(state)(*(value + 1 for value in state))
    return dataclasses.replace(expected, memory=memory)


def _program(folder: Path) -> object:
    text = textwrap.dedent(SOUND).replace("Mine", "Other")
    (folder / "other.py").write_text(text)
    [made] = cases(load_own_blocks(folder / "other.py")["Other"], folder, hostile=False, sets=1)
    return made.compiled.written.program
