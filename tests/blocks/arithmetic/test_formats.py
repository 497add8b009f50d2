"""How a block says the formats of its fixed-point values, and what follows from them."""

from fractions import Fraction
from typing import Any, Literal, NamedTuple

import pytest

from proofmass.blocks.arithmetic.fixed_point import Fixed, FixedValue
from proofmass.blocks.declaration.catalog import facts
from proofmass.blocks.declaration.declare import Block, Buffer, Input, param
from proofmass.blocks.declaration.instance import format_of
from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.files.toml_reader import read_graph_text
from proofmass.graphs.files.toml_writer import write_graph
from proofmass.graphs.model.build import Graph
from proofmass.runner.output.describe import block_text


def average() -> type[Block]:
    """A moving average of a length, declared anew."""

    class Average(Block):
        """Mean of the last values."""

        word: Fixed = param("1", "Format.", default=Fixed(12, 8))
        ends: Literal["keep", "drop"] = param("", "What is done at the ends.", default="drop")
        gain: float = param("1", "Gain.", default=1.0)

        input = Input("1", "Values.", dtype=FixedValue)
        line = Buffer("Last values.", FixedValue, (4,))

    class State(NamedTuple):
        total: FixedValue
        chips: int

    @Average.formats
    def formats(p: Any) -> dict[str, Fixed]:
        return {"input": p.word, "line": p.word, "x": Fixed(14, 8), "c": Fixed(18, 16), "c.special": Fixed(2, 1)}

    @Average.output("1")
    def mean(c: Any, p: Any, x: State) -> FixedValue:
        """The mean."""
        return x.total >> 2

    return Average


def test_a_name_stands_for_all_fields_unless_one_has_its_own() -> None:
    block = average()(word="(10, 3)")
    assert [format_of(block, what) for what in ("input", "line", "x.total", "c.gain", "c.special")] == [
        Fixed(10, 3), Fixed(10, 3), Fixed(14, 8), Fixed(18, 16), Fixed(2, 1),
    ]  # fmt: skip
    with pytest.raises(
        ModelError, match=r'Average\.formats: the format of mean is not said\n.*"mean": Fixed\(16, 12\)'
    ):
        format_of(block, "mean")


def test_digital_blocks_have_formats_and_no_floating_point_port() -> None:
    kind = average()
    assert kind.has_formats()
    assert not kind.drivable("gain")

    @kind.output("1")
    def monitor(c: Any, input: Any) -> float:
        """The same as a number."""
        return float(input)

    assert not kind.has_formats()


def test_the_parameters_are_an_argument_only_behind_formats() -> None:
    class Plain(Block):
        """Nothing."""

        gain: float = param("1", "Gain.", default=1.0)

    def output(c: Any, p: Any) -> float:
        return float(p.gain)

    with pytest.raises(TypeError, match="cannot bind the argument"):
        Plain.output("1")(output)


def test_a_format_and_a_literal_as_facts_and_as_text() -> None:
    kind = average()
    known = facts(kind)
    assert known["parameters"]["word"] == {"type": "format", "unit": "1", "doc": "Format.", "default": "(12, 8)"}
    assert known["parameters"]["ends"]["choices"] == ["keep", "drop"]
    assert known["inputs"]["input"]["type"] == "fixed"
    assert '    word = "(12, 8)"' in block_text(kind)
    with pytest.raises(ModelError, match="expected: one of keep, drop"):
        kind(ends="hold")


def test_a_format_travels_through_toml() -> None:
    kind = average()
    graph = Graph(name="mean", rate=1, blocks={"mean": kind(word=Fixed(9, -2, signed=False))})
    text = write_graph(graph)
    assert 'word = "(9, -2) unsigned"' in text
    assert read_graph_text(text, own={"Average": kind}).blocks == graph.blocks


def test_the_most_bits() -> None:
    """The ends belong to the formats that there are."""
    for fraction in (512, -512):
        assert Fixed(512, fraction).resolution == Fraction(2) ** -fraction
    for width, fraction in ((0, 0), (513, 0), (8, 513), (8, -513)):
        with pytest.raises(ValueError, match="512"):
            Fixed(width, fraction)
