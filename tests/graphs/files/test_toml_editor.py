"""Parameters set in a text: what was asked for is there, and nothing else has changed."""

import math
import tomllib
from pathlib import Path

import pytest

from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.files.toml_editor import edit_file, edited

TEXT = """\
name = "a graph"  # of two blocks
[blocks.model]    # fitted
kind = "DoubleExponentialModel"
a1 = 0.5          # in volts
b1 = "-3 1/V" # a "quoted" remark
a2=1_000.0

[blocks.other]
kind = "Gain"
gain = 2.0
"""


def test_changed_and_added_where_they_belong() -> None:
    result = edited(TEXT, {"model.a1": 0.25, "model.b1": "-4.5 1/V", "model.a2": "3e-05 V", "model.b2": 1.5})
    expected = TEXT.replace("a1 = 0.5          # in", "a1 = 0.25          # in").replace('"-3 1/V"', '"-4.5 1/V"')
    assert result == expected.replace("a2=1_000.0\n", 'a2="3e-05 V"\nb2 = 1.5\n')


@pytest.mark.parametrize("ending", ["\n", "\r\n"])
def test_line_endings_stay(ending: str) -> None:
    result = edited(TEXT.replace("\n", ending), {"other.gain": 3.0, "other.input_unit": "V"})
    assert result.count("\r") == (result.count("\n") if ending == "\r\n" else 0)
    assert tomllib.loads(result)["blocks"]["other"] == {"kind": "Gain", "gain": 3.0, "input_unit": "V"}


def test_a_last_line_without_end() -> None:
    assert edited(TEXT.rstrip("\n"), {"other.gain": 1e-9}).endswith("gain = 1e-09")


def test_every_digit_is_kept() -> None:
    value = 0.1 + 0.2
    assert tomllib.loads(edited(TEXT, {"model.a1": value}))["blocks"]["model"]["a1"] == value


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ('name = "g"\n[blocks]\nmodel = { kind = "DoubleExponentialModel", a1 = 2.0 }\n', 3),
        ('name = "g"\n[blocks]\nmodel = { kind = "DoubleExponentialModel" }\n', 3),
        ('name = "g"\nblocks.model.kind = "DoubleExponentialModel"\n', 2),
        ('name = "g"\n[blocks.model]\nkind = "DoubleExponentialModel"\na1 = """\n2 V"""\n', 4),
    ],
)
def test_what_cannot_be_edited_is_refused_with_its_line(text: str, line: int) -> None:
    with pytest.raises(ModelError, match="cannot be edited in place") as caught:
        edited(text, {"model.a1": 1.0}, "graph.toml")
    assert str(caught.value).startswith(f"graph.toml:{line}: blocks.model")


def test_values_and_what_lies_inside_a_graph_that_is_a_block() -> None:
    text = '[values]\nmass = "5 ug"  # m\n[blocks.axis]\ngraph = "axis.toml"\n"adc.reference" = "5 V"  # of it\n'
    changes: dict[str, float | str] = {"mass": "6 ug", "axis.adc.reference": "4 V", "axis.adc.offset": 0.5}
    written = edited(text, changes)
    assert 'mass = "6 ug"  # m' in written
    assert '"adc.reference" = "4 V"  # of it' in written
    assert '"adc.offset" = 0.5' in written
    with pytest.raises(ModelError):
        edited(text, {"other.gain": 2.0})


@pytest.mark.defect(
    "S707",
    before='a text with a quotation mark was refused: "write every parameter on its own line"',
    after="it is written as TOML has it",
)
@pytest.mark.parametrize("text", ['5 "V"', "a\\b", "two\nlines"])
def test_a_text_is_written_whatever_is_in_it(text: str) -> None:
    assert tomllib.loads(edited(TEXT, {"model.b1": text}))["blocks"]["model"]["b1"] == text


@pytest.mark.parametrize("changes", [{"model.a1": math.nan}, {"model.a b": 1.0}])
def test_a_text_that_would_not_say_what_was_asked_for_is_not_written(changes: dict[str, float]) -> None:
    with pytest.raises(ModelError, match=r"graph\.toml: cannot be edited in place"):
        edited(TEXT, changes, "graph.toml")


def test_a_file_is_not_written(tmp_path: Path) -> None:
    file = tmp_path / "graph.toml"
    file.write_bytes(TEXT.replace("\n", "\r\n").encode())
    assert edit_file(file, {"other.gain": 3.0}) == TEXT.replace("gain = 2.0", "gain = 3.0").replace("\n", "\r\n")
    assert file.read_bytes() == TEXT.replace("\n", "\r\n").encode()
