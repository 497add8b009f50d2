"""Stages of operations and registers behind cuts, and cuts that are refused."""

from typing import NamedTuple

import pytest

from proofmass.blocks.arithmetic.fixed_point import Fixed, FixedValue
from proofmass.blocks.arithmetic.pipeline import pipe
from proofmass.blocks.declaration.declare import Block, Buffer, Input
from proofmass.blocks.declaration.problem import ModelError
from tests.by_hand.modules import module_of

WORD = Fixed(8, 4)


class State(NamedTuple):
    first: FixedValue
    second: FixedValue


class Chain(Block):
    """Two registers, the second fed by the first through a cut."""

    a = Input("1", "Input.", dtype=FixedValue)


@Chain.formats
def formats(p: Chain) -> dict[str, Fixed]:
    return {"a": WORD, "x": WORD, "early": WORD, "late": WORD}


@Chain.output("1")
def early(p: Chain, x: State) -> FixedValue:
    """The first register."""
    return x.first


@Chain.output("1")
def late(p: Chain, x: State, a: FixedValue) -> FixedValue:
    """The second register and the input."""
    return (x.second + a).to(WORD)


@Chain.update
def update(p: Chain, x: State, a: FixedValue) -> State:
    return State((x.first + a).to(WORD), (x.second + pipe(pipe(x.first) - a)).to(WORD))


def test_a_register_is_as_late_as_what_it_takes() -> None:
    pipeline = module_of(Chain()).pipeline
    assert pipeline.registers == {"first": 0, "second": 2}
    assert (pipeline.latency, pipeline.waits) == (2, 2)
    delays = {node.name: delay for node, delay in pipeline.delays.items()}
    assert delays == {"a": 2, "x.first": 2}  # for the second register and output, and for the first output


def test_without_cuts_nothing_is_late() -> None:
    class Plain(Chain):
        """No cut."""

    Plain.formats(formats)
    Plain.output("1")(early)

    @Plain.update
    def move(p: Plain, x: State, a: FixedValue) -> State:
        return State(a, x.first)

    pipeline = module_of(Plain()).pipeline
    assert (pipeline.latency, pipeline.waits, pipeline.delays) == (0, 0, {})


def test_a_cut_in_a_feedback_is_refused_with_its_line_and_registers() -> None:
    class Round(Chain):
        """The first register comes back by way of the second, cut."""

        line = Buffer("A delay.", FixedValue, (2,))

    @Round.formats
    def round_formats(p: Round) -> dict[str, Fixed]:
        return formats(p) | {"line": WORD}  # type: ignore[arg-type]

    Round.output("1")(early)

    @Round.update
    def move(p: Round, x: State, line: list[FixedValue], a: FixedValue) -> State:
        line[1] = line[0]
        line[0] = pipe(x.second)
        return State((line[1] + a).to(WORD), (x.first + x.second).to(WORD))

    with pytest.raises(ModelError) as caught:
        module_of(Round())
    (problem,) = caught.value.problems
    assert problem.message == "a pipeline cut in the feedback of line[0] and x.first and x.second"
    assert (problem.file, problem.line) == ("test_pipeline.py", move.__code__.co_firstlineno + 3)
    assert problem.expected == "cuts in paths that do not come back to the register that they start from"
    assert "cut what does not come back to it" in problem.hint
