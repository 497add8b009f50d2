"""Ranges of plain integers in registers, against those that they really reach; and what has none."""

import random
from typing import NamedTuple

import pytest

from proofmass.blocks import CalibrationSequencer, ChipCounter, MeasurementSlots, ShiftRegister
from proofmass.blocks.declaration.declare import Block, Buffer, Input, param
from proofmass.blocks.declaration.problem import ModelError
from proofmass.runner.rtl.machine.words import Word
from tests.by_hand.modules import Reference, module_of


class State(NamedTuple):
    up: int
    down: int
    on: bool


class Counters(Block):
    """Integers that a mask, a condition or a bound holds."""

    last: int = param("1", "Where the first starts again.", default=99, at_least=1)

    step = Input("1", "What the second is moved by.", dtype=int)

    line = Buffer("A delay line.", int, (3,))


@Counters.start
def start(p: Counters, line: list[int]) -> State:
    line[1] = 9
    return State(0, -3, True)


@Counters.output("1")
def up(p: Counters, x: State) -> int:
    """The first."""
    return x.up


@Counters.output("1")
def kept(p: Counters, line: list[int]) -> int:
    """The end of the line."""
    return line[2]


@Counters.update
def update(p: Counters, x: State, line: list[int], step: int) -> State:
    line[2] = line[1]
    line[1] = line[0]
    line[0] = step
    down = x.down + step
    return State(0 if x.up == p.last else x.up + 1, max_of(min_of(down, 40), -50), not x.on)


def min_of(a: int, b: int) -> int:
    return a if a < b else b


def max_of(a: int, b: int) -> int:
    return a if a > b else b


@pytest.mark.parametrize("last", [1, 2, 99, 255, 256, 1022])
def test_a_counter_has_the_bits_of_its_last_number(last: int) -> None:
    module = module_of(Counters(last=last), {"step": Word(-7, 12)})
    words = {register.text: register.word for register in module.registers}
    assert words["x.up"] == Word(0, last)
    assert words["x.down"] == Word(-50, 40)
    assert words["x.on"] == Word(0, 1)
    assert {words[f"line[{k}]"] for k in range(3)} == {Word(-7, 12)}  # one range for all entries, the 9 among them
    assert {port.text: port.word for port in module.outputs} == {"up": Word(0, last), "kept": Word(-7, 12)}


@pytest.mark.parametrize(
    ("block", "words"),
    [
        (ShiftRegister(), {"x.cells": Word(0, 1023)}),
        (ShiftRegister(length=24, taps=0xE10000, seed=1), {"x.cells": Word(0, 2**24 - 1)}),
        (ChipCounter(chips=1023), {"x.chip": Word(0, 1022)}),
        (ChipCounter(chips=5, first=1, last=2), {"x.chip": Word(0, 4)}),
    ],
    ids=repr,
)
def test_registers_of_shipped_blocks(block: Block, words: dict[str, Word]) -> None:
    assert {register.text: register.word for register in module_of(block).registers} == words


@pytest.mark.exhaustive
@pytest.mark.parametrize("block", [CalibrationSequencer(), MeasurementSlots()], ids=repr)
def test_what_plain_python_reaches_is_inside(block: Block) -> None:
    module = module_of(block)
    reached = {register.text: {register.start} for register in module.registers}
    reference, draws = Reference(module), random.Random(2)
    for _ in range(1200):
        reference.tick({port.name: draws.random() < 0.9998 for port in module.inputs})
        for text, value in reference.held.items():
            reached[text].add(value)
    for register in module.registers:
        assert register.word.holds(min(reached[register.text]), max(reached[register.text]))
        assert register.word.width == Word(min(reached[register.text]), max(reached[register.text])).width


class Total(NamedTuple):
    total: int


class Growing(Block):
    """A sum that nothing holds."""

    on = Input("1", "Whether to add.", dtype=bool)


@Growing.output("1")
def total(p: Growing, x: Total) -> int:
    """The sum."""
    return x.total


@Growing.update
def grow(p: Growing, x: Total, on: bool) -> Total:
    return Total(x.total - 3 if on else x.total)


def test_what_grows_without_bound_is_refused_with_line_and_remedy() -> None:
    with pytest.raises(ModelError) as caught:
        module_of(Growing())
    (problem,) = caught.value.problems
    assert problem.message == "x.total grows without bound"
    assert (problem.file, problem.line) == ("test_ranges.py", grow.__code__.co_firstlineno + 2)
    assert problem.key == "block: x.total"
    assert problem.got == f"[{-(2**62) - 3}, -3] after a step from [{-(2**62)}, 0]"
    assert "hold it with clip() or a mask" in problem.hint
    assert "a FixedValue with a format" in problem.hint
