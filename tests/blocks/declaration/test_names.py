"""Names of parameters and ports: which are free, which are refused, and by what they are taken."""

import dataclasses
import re
from collections.abc import Callable
from typing import Any

import pytest

from proofmass.blocks.declaration.declare import Block, Buffer, Input, param
from tests.by_hand.fresh_blocks import fresh_block
from tests.by_hand.functions import drive
from tests.by_hand.words_of_blocks import OF_OUTPUTS, WORDS_OF_BLOCKS


@pytest.mark.parametrize(
    ("name", "by"),
    [
        ("p", "p is the parameters"),
        ("c", "c is the constants"),
        ("x", "x is the state"),
        ("time", "time is seconds since the start"),
        ("tick", "tick is ticks of the block"),
        ("normal", "normal is a fresh standard normal deviate"),
        ("out", "out is where an output with a shape writes"),
        ("period", "period is seconds between ticks, an argument of `constants` and `start`"),
        ("rate", "rate is a key of a block in a graph file"),
        ("kind", "kind is a key of a block in a graph file"),
        ("graph", "graph is a key of a block in a graph file"),
        ("lambda", "lambda is a word of Python"),
        ("None", "None is a word of Python"),
    ],
)
def test_reserved_names_are_refused_by_what_has_them(name: str, by: str) -> None:
    words = re.escape(f"Taken.{name}: the name is taken; {by}")
    with pytest.raises(TypeError, match=words):
        type("Taken", (Block,), {name: param("1", "A factor.", default=1.0), "__annotations__": {name: float}})
    for port in (Input("1", "In."), Buffer("Cells.", float, (2,))):
        with pytest.raises(TypeError, match=words):
            type("Taken", (Block,), {name: port})
    with pytest.raises(TypeError, match=words.replace("Taken", "Fresh")):
        fresh_block().output("1")(_called(name))


@pytest.mark.parametrize("name", ["_hidden", "__repr__", "__declaration__", "two words", "1st", ""])
def test_names_begin_with_a_letter(name: str) -> None:
    words = f"{re.escape(name)}: a name begins with a letter and has letters, digits and _ only"
    with pytest.raises(TypeError, match=words):
        type("Wrong", (Block,), {name: param("1", "A factor.", default=1.0), "__annotations__": {name: float}})
    with pytest.raises(TypeError, match=words):
        type("Wrong", (Block,), {name: Input("1", "In.")})
    with pytest.raises(TypeError, match=words):
        fresh_block().output("1")(_called(name))


def _called(name: str) -> Callable[..., float]:
    def function(p: Any) -> float:
        return 1.0

    function.__name__ = name
    return function


@pytest.mark.parametrize("name", WORDS_OF_BLOCKS)
def test_words_of_blocks_are_free_for_parameters_and_ports(name: str) -> None:
    kind: Any = type("Free", (Block,), {name: param("1", "A.", default=1.0), "__annotations__": {name: float}})
    kind.output("1")(_reading(name))
    assert drive(kind(**{name: 3}), [{}]) == [{"value": 3.0}]
    assert repr(kind(**{name: 3})) == f"Free({name}=3.0)"
    assert dataclasses.replace(kind(), **{name: 4.0}) == kind(**{name: 4.0})
    kind = type("Free", (Block,), {name: Input("1", "In.", default=2.0)})
    assert kind.inputs[name].default == 2.0
    assert not hasattr(kind(), name)
    kind = type("Free", (Block,), {name: Buffer("Cells.", float, (2,))})
    assert [*kind.buffers] == [name]
    if name in OF_OUTPUTS:
        kind = type("Free", (Block,), {})
        kind.output("1")(_called(name))
        assert drive(kind(), [{}]) == [{name: 1.0}]


def _reading(name: str) -> Callable[..., float]:
    def value(p: Any) -> float:
        return float(getattr(p, name))

    return value


@pytest.mark.parametrize(
    ("name", "gives"), [("update", "the state of the next tick"), ("derivative", "the rates of the")]
)
def test_an_output_is_not_called_as_a_function_that_moves_the_state(name: str, gives: str) -> None:
    with pytest.raises(TypeError, match=f"{name}: the name is taken; {name} is the function that gives {gives}"):
        fresh_block().output("1")(_called(name))


@pytest.mark.parametrize("name", ["output", "inputs", "mro"])
def test_an_attribute_that_is_no_port_hides_nothing(name: str) -> None:
    with pytest.raises(TypeError, match=f"Hiding.{name}: the name is taken; every block has {name}"):
        type("Hiding", (Block,), {name: lambda self: None})


@pytest.mark.parametrize(
    ("name", "what"),
    [("factor", "a parameter"), ("voltage", "an input"), ("cells", "a buffer"), ("early", "an output")],
)
def test_an_output_has_a_name_of_its_own(name: str, what: str) -> None:
    kind = fresh_block()
    kind.output("1")(_called("early"))
    with pytest.raises(TypeError, match=f"Fresh.{name}: the name is taken; it is the name of {what} of the block"):
        kind.output("1")(_called(name))
