"""Wires between fixed-point ports: equal formats only, and the converter that is missing is named."""

from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.checks.check import check
from proofmass.graphs.drawing.text_forms import mermaid
from proofmass.graphs.files.toml_reader import read_graph_text

GRAPH = """
name = "fixed point"
rate = "1 kHz"
wires = [
    "source.output -> quantiser.input",
    "quantiser.output -> gain.input",
    WIRES
]
probes = ["gain.output"]
[blocks.source]
kind = "Constant"
[blocks.quantiser]
kind = "FixedQuantiser"
[blocks.gain]
kind = "FixedGain"
input_format = "(16, 12)"
[blocks.cast]
kind = "FixedCast"
[blocks.number]
kind = "Gain"
[blocks.chips]
kind = "ShiftRegister"
[blocks.bit]
kind = "OneBitActuator"
"""


def problems(*wires: str) -> str:
    text = GRAPH.replace("WIRES", ", ".join(f'"{wire}"' for wire in wires))
    return "\n\n".join(map(str, check(read_graph_text(text))))


def test_formats_must_be_equal() -> None:
    text = problems("quantiser.output -> cast.input")
    assert "wires: quantiser.output -> cast.input: the formats do not match" in text
    assert "got:      (16, 12)" in text
    assert "expected: (24, 18)" in text
    assert 'put a FixedCast with input_format = "(16, 12)", output_format = "(24, 18)" between' in text
    assert "formats" not in problems("gain.output -> number.input")


def test_nothing_is_converted_in_silence() -> None:
    text = problems("gain.output -> number.input", "source.output -> cast.input", "gain.output -> bit.bit")
    assert "got:      fixed\n  expected: float\n  hint:     a FixedToNumber makes numbers of fixed-point values" in text
    assert (
        "got:      float\n  expected: fixed\n  hint:     a FixedQuantiser makes fixed-point values of numbers" in text
    )
    assert "got:      fixed\n  expected: bool" in text


def test_an_input_without_a_wire_says_its_format_and_only_what_fits() -> None:
    text = problems()
    assert "expected: a wire that carries a value in (24, 18) fixed-point: Value to convert." in text
    assert '"block.output -> cast.input"' in text


def test_a_gain_between_units_is_one_in_fixed_point() -> None:
    text = GRAPH.replace("WIRES", "").replace('input_format = "(16, 12)"', 'input_unit = "V"')
    found = "\n".join(map(str, check(read_graph_text(text))))
    assert 'put a FixedGain with input_unit = "1" and output_unit = "V" between' in found


def test_a_parameter_cannot_be_driven_and_a_format_must_be_one() -> None:
    assert "gain.gain cannot be driven\n  hint:     it is a parameter of a fixed-point block" in problems(
        "source.output -> gain.gain"
    )
    try:
        read_graph_text(GRAPH.replace("WIRES", "").replace('"(16, 12)"', '"16.12"'))
    except ModelError as error:
        text = str(error)
    assert "blocks.gain.input_format: is not a format" in text
    assert 'expected: a format such as "(16, 12)": bits in all, bits of the fraction' in text


def test_diagrams_show_the_blocks() -> None:
    assert "FixedQuantiser" in mermaid(read_graph_text(GRAPH.replace("WIRES", "")))
