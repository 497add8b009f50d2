"""Modules of single blocks: ports, registers, what they share, and steps that are no hardware."""

from typing import NamedTuple

import pytest

from proofmass.blocks import FixedCoefficientMemory, FixedRangeReducer, FixedStiffnessController
from proofmass.blocks.arithmetic.fixed_point import Fixed, FixedValue
from proofmass.blocks.declaration.declare import Block, Buffer, Input, param
from proofmass.blocks.declaration.problem import ModelError
from proofmass.runner.rtl.machine.words import Word
from tests.by_hand.modules import module_of

WORD = Fixed(8, 4)


def test_ports_and_registers_bear_the_ranges_of_their_formats() -> None:
    module = module_of(FixedStiffnessController(initial=3.0))
    assert {port.name: port.word for port in module.inputs} == {
        "measured": Word(-(2**15), 2**15 - 1, 12),
        "modelled": Word(-(2**15), 2**15 - 1, 12),
        "window": Word(0, 1),
    }
    assert {port.name: str(port.word) for port in module.outputs} == {"stiffness": "(20, 12)"}
    assert [(r.name, r.text, str(r.word), r.start) for r in module.registers] == [
        ("correction", "x.correction", "(16, 12)", 0),
        ("error", "x.error", "(20, 12)", 0),
    ]


def test_constants_are_folded_and_what_functions_share_is_there_once() -> None:
    module = module_of(FixedStiffnessController())
    operations = [operation.kind for operation in module.live]
    assert operations.count("multiply") == 1  # in the output and in the update
    assert {operation.name for operation in module.live if operation.kind == "input"} == set(module.sources)
    memory = module_of(FixedCoefficientMemory())
    assert not memory.registers
    assert not memory.clocked
    assert all(operation.constant is not None for operation in memory.results.values())


def test_two_outputs_of_one_product_share_it() -> None:
    module = module_of(FixedRangeReducer())
    wide = [operation for operation in module.live if operation.kind == "multiply" and operation.high > 2**36]
    assert len(wide) == 1


class Ticking(Block):
    """Counts without end."""


@Ticking.output("1")
def count(p: Ticking, tick: int) -> int:
    """The number of the tick."""
    return tick


def test_the_number_of_a_tick_is_no_register() -> None:
    with pytest.raises(ModelError) as caught:
        module_of(Ticking())
    (problem,) = caught.value.problems
    assert problem.message == "tick is not a register"
    assert problem.hint == "count in the state, up to a number that it starts again from"


class Echo(Block):
    """Adds to what it gave before."""

    length: int = param("1", "Entries.", default=2, at_least=1)

    input = Input("1", "Input.", dtype=FixedValue)

    held = Buffer("Entries.", FixedValue, ("length",))


@Echo.formats
def formats(p: Echo) -> dict[str, Fixed]:
    return {"input": WORD, "held": WORD, "given": WORD}


@Echo.output("1", shape=("length",), dtype=FixedValue)
def given(p: Echo, held: list[FixedValue], input: FixedValue, out: list[FixedValue]) -> None:
    """The entries and the input."""
    for k in range(len(out)):
        out[k] = (held[k] + input).to(WORD)


@Echo.update
def update(p: Echo, held: list[FixedValue], input: FixedValue) -> None:
    for k in range(len(held) - 1, 0, -1):
        held[k] = held[k - 1]
    held[0] = input


def test_vectors_are_ports_and_registers_of_their_own() -> None:
    module = module_of(Echo(length=3))
    assert [(port.name, port.text) for port in module.outputs] == [(f"given_{k}", f"given[{k}]") for k in range(3)]
    assert [register.text for register in module.registers] == ["held[0]", "held[1]", "held[2]"]


def test_an_output_that_is_read_begins_with_zeros_and_is_no_register() -> None:
    class Growing(Echo):
        """Reads its output."""

    Growing.formats(formats)

    @Growing.output("1", shape=("length",), dtype=FixedValue)
    def sums(p: Growing, input: FixedValue, out: list[FixedValue]) -> None:
        """Sums of a tick, that are kept nowhere."""
        out[0] = (out[0] + input).to(WORD)

    @Growing.formats
    def more(p: Growing) -> dict[str, Fixed]:
        return formats(p) | {"sums": WORD}  # type: ignore[arg-type]

    module = module_of(Growing())
    assert not [operation.name for operation in module.live if operation.name.startswith("out[")]
    result = module.results["sums_0"]
    assert (result.kind, result.name) == ("input", "input")


class Kept(NamedTuple):
    held: FixedValue


class Refusing(Block):
    """A cast that refuses, of values that may not fit or always do."""

    wide: bool = param("1", "Whether the value may not fit.", default=True)

    input = Input("1", "Input.", dtype=FixedValue)


@Refusing.formats
def refusing_formats(p: Refusing) -> dict[str, Fixed]:
    return {"input": WORD, "half": Fixed(7, 4)}


@Refusing.output("1")
def half(p: Refusing, input: FixedValue) -> FixedValue:
    """The input, or half of it."""
    value = input if p.wide else FixedValue(input.mantissa >> 1, 4)
    return value.to(Fixed(7, 4), overflow="refuse")


def test_a_cast_that_refuses_is_proved_by_its_range_or_refused() -> None:
    assert not module_of(Refusing(wide=False)).clocked
    with pytest.raises(ModelError, match="the value does not fit its register") as caught:
        module_of(Refusing())
    (problem,) = caught.value.problems
    assert problem.file == "test_modules.py"
    assert problem.got == "[-128, 127]"
