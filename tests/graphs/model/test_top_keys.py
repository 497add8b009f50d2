"""Keys with plain values: one row serves reader, writer, schema and comparison."""

import re
from inspect import signature

import pytest
from jsonschema import Draft202012Validator

from proofmass.blocks import Constant
from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.files.toml_reader import read_graph_text
from proofmass.graphs.files.toml_writer import write_graph
from proofmass.graphs.model.build import Graph
from proofmass.graphs.model.differences import differences
from proofmass.graphs.model.keys import Integer, Text
from proofmass.graphs.model.top_keys import PLAIN_KEYS, TOP_KEYS
from tests.by_hand.graph_schema import SCHEMA

KEYS = pytest.mark.parametrize("key", PLAIN_KEYS)
TEXTS = [key for key, form in PLAIN_KEYS.items() if isinstance(form, Text)]
INTEGERS = [key for key, form in PLAIN_KEYS.items() if isinstance(form, Integer)]


def with_key(key: str, value: object) -> Graph:
    values: dict[str, object] = {"name": "plain", "blocks": {"one": Constant()}, "rate": "1 kHz", key: value}
    return Graph(**values)  # type: ignore[arg-type]


def value_of(key: str) -> str | int:
    return "two words" if key in TEXTS else 7


def problem(key: str, value: object) -> str:
    with pytest.raises(ModelError) as raised:
        with_key(key, value)
    (only,) = raised.value.problems
    assert only.key == key
    return str(only)


def test_every_key_is_a_field_that_the_constructor_takes() -> None:
    assert {"name", "description", "samples", "seed"} <= set(PLAIN_KEYS) < set(TOP_KEYS)
    assert set(TOP_KEYS) - {"study", "tune"} <= set(signature(Graph).parameters)


@KEYS
def test_a_value_is_kept_and_written_and_read_back(key: str) -> None:
    graph = with_key(key, value_of(key))
    assert getattr(graph, key) == value_of(key)
    text = write_graph(graph)
    assert re.search(rf'^{key} = "?{value_of(key)}"?$', text, re.MULTILINE)
    assert read_graph_text(text) == graph


@KEYS
def test_two_graphs_that_differ_in_it_differ(key: str) -> None:
    other = "others" if key in TEXTS else 8
    texts = [str(difference) for difference in differences(with_key(key, value_of(key)), with_key(key, other))]
    assert len(texts) == 1
    assert str(value_of(key)) in texts[0]
    assert str(other) in texts[0]


@pytest.mark.parametrize("key", TEXTS)
def test_a_text_is_refused_as_the_schema_refuses_it(key: str) -> None:
    assert "must be a string" in problem(key, 5)
    assert "longer than 10000 characters" in problem(key, "a" * 10_001)
    assert "holds half a character" in problem(key, "\ud800")
    validator = Draft202012Validator(SCHEMA["properties"][key])
    assert [validator.is_valid(value) for value in ("a" * 10_000, "a" * 10_001, 5)] == [True, False, False]


@pytest.mark.parametrize("key", INTEGERS)
def test_an_integer_is_refused_as_the_schema_refuses_it(key: str) -> None:
    form = PLAIN_KEYS[key]
    assert isinstance(form, Integer)
    assert "must be an integer" in problem(key, "5")
    assert f"write it without a point or an exponent: {key} = 5" in problem(key, 5.0)
    assert "out of range" in problem(key, form.lowest - 1)
    assert "out of range" in problem(key, form.highest + 1)
    validator = Draft202012Validator(SCHEMA["properties"][key])
    values = (form.lowest, form.highest, form.lowest - 1, form.highest + 1, "5")
    assert [validator.is_valid(value) for value in values] == [True, True, False, False, False]
