"""Programs as PTX: a kernel without fused arithmetic; what a GPU has not is refused."""

import re
from pathlib import Path

import pytest

from proofmass.blocks.declaration.problem import ModelError
from proofmass.runner.program.form import FLOAT, Call, External, Function, Line, Storage, Value
from proofmass.runner.targets.gpu import KERNEL, ptx_text
from proofmass.runner.targets.lane_text import LanesOf
from tests.by_hand.hostile_operations import operations_program
from tests.by_hand.programs import Writer, program
from tests.by_hand.ptxas import assembled, needs_ptxas
from tests.by_hand.random_programs import RandomProgram
from tests.by_hand.small_programs import SMALL

FUSED = re.compile(r"^\s+(@%p\d+ )?(fma|mad)\b.*f64", re.MULTILINE)
NOTHING = LanesOf(frozenset(), frozenset(), {})


def test_nothing_is_fused() -> None:
    x, gain, state = Value(FLOAT, "x"), Value(FLOAT, "gain"), Storage(FLOAT, 1, True, "state")
    w = Writer("entry", x, gain, state)
    w.store(state, 0, w.do("add", w.do("multiply", w.load(state, 0), gain), w.do("divide", x, gain)))
    text = ptx_text(program(w.function), LanesOf(frozenset({gain}), frozenset(), {}))
    assert {"mul.rn.f64", "add.rn.f64", "div.rn.f64"} <= set(re.findall(r"[a-z]+\.rn\.f64", text))
    assert not FUSED.search(text)
    assert f".entry {KERNEL}(" in text


@pytest.mark.parametrize("made", [operations_program, *(lambda c=c: c()[0] for c in SMALL.values())])
def test_everything_can_be_written(made: object) -> None:
    text = ptx_text(made(), NOTHING)  # type: ignore[operator]
    assert ".version" in text
    assert not FUSED.search(text)
    assert not re.search(r"\.extern \.func", text)


@pytest.mark.parametrize("seed", range(5))
def test_random_programs(seed: int) -> None:
    made = RandomProgram(seed)
    text = ptx_text(made.program, LanesOf(frozenset({made.number}), frozenset({made.table}), {}))
    assert not FUSED.search(text)


@pytest.mark.exhaustive("operations_program")
@needs_ptxas
@pytest.mark.parametrize("made", [operations_program, *(lambda c=c: c()[0] for c in SMALL.values())])
def test_nvidia_assembles_it(made: object, tmp_path: Path) -> None:
    assert assembled(ptx_text(made(), NOTHING), tmp_path).startswith(b"\x7fELF")  # type: ignore[operator]


@needs_ptxas
def test_the_assembler_refuses_what_is_no_ptx(tmp_path: Path) -> None:
    text = ptx_text(operations_program(), NOTHING).replace("add.rn.f64", "add.rn.s64", 1)
    with pytest.raises(AssertionError, match="error"):
        assembled(text, tmp_path)


def test_functions_of_libm_are_refused_with_their_line() -> None:
    x = Value(FLOAT, "x")
    line = Line("my_blocks.py", 7)
    sine = Call((Value(FLOAT),), External("sin", (FLOAT,), FLOAT), (x,), line)
    with pytest.raises(ModelError) as caught:
        ptx_text(program(Function("entry", (x,), (), [sine], origin="my_blocks.output")), NOTHING)
    [problem] = caught.value.problems
    assert problem.message == "a GPU has no function sin"
    assert (problem.file, problem.line, problem.key) == ("my_blocks.py", 7, "my_blocks.output")
