"""The nine mistakes that everybody makes: the message names block, port, file, line and the cure, word by word."""

from pathlib import Path

import pytest

from proofmass import Graph
from proofmass.blocks import Constant, Gain
from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.checks.check import check, checked
from proofmass.graphs.files.toml_reader import read_graph
from tests.by_hand.graph_texts import SMALL, changed, said_about

MISTAKES = {
    "misspelt parameter": (
        [("bits = 16", "bist = 16")],
        """\
model.toml:27: blocks.adc.bist: AnalogToDigital has no such parameter
  got:      'bist'
  hint:     did you mean bits?""",
    ),
    "unconnected input": (
        [('    "push.output -> mass.force",\n', "")],
        """\
model.toml:15: blocks.mass: the input force is not connected
  expected: a wire that carries a number in N: Force on the proof mass.
  hint:     add "push.output -> mass.force" to wires""",
    ),
    "two sources on one input": (
        [
            (
                '    "push.output -> mass.force",\n',
                '    "push.output -> mass.force",\n    "pull.output -> mass.force",\n',
            ),
            ("[blocks.mass]", '[blocks.pull]\nkind = "Constant"\nunit = "N"\n\n[blocks.mass]'),
        ],
        """\
model.toml:6: wires: pull.output -> mass.force: mass.force is driven twice
  got:      push.output and pull.output
  expected: one wire
  hint:     remove one of the wires, or add the signals with a Sum and wire its output""",
    ),
    "algebraic loop": (
        [
            (
                '"mass.displacement -> readout.input",',
                '"mass.displacement -> total.first",\n    "total.output -> readout.input",\n'
                '    "total.output -> back.input",\n    "back.output -> total.second",',
            ),
            ("[blocks.adc]", '[blocks.total]\nkind = "Sum"\nunit = "m"\n\n[blocks.adc]'),
            ("[blocks.adc]", '[blocks.back]\nkind = "Negation"\nunit = "m"\n\n[blocks.adc]'),
        ],
        """\
model.toml:8: wires: algebraic loop: each of these outputs needs the one before it within the same tick
  got:      back.output -> total.second, total.output -> back.input
  expected: at least one block in the loop whose output does not depend on its input in the same tick
  hint:     put a UnitDelay into one of these wires, for example into total.output -> back.input; \
or have the loop solved: algebraic_loops = "newton" under [integration]""",
    ),
    "unknown port": (
        [('"readout.output -> adc.voltage"', '"readout.output -> adc.volts"')],
        """\
model.toml:7: wires: readout.output -> adc.volts: adc.volts is neither an input nor a parameter
  hint:     did you mean voltage?""",
    ),
    "vector into a scalar input": (
        [
            (
                '"readout.output -> adc.voltage",',
                '"readout.output -> adc.voltage",\n    "adc.code -> cells.code",\n    "chips.bit -> cells.bit",\n'
                '    "cells.impulse_response -> gain.input",',
            ),
            ("[blocks.adc]", '[blocks.cells]\nkind = "Correlator"\n\n[blocks.adc]'),
            ("[blocks.adc]", '[blocks.chips]\nkind = "ShiftRegister"\n\n[blocks.gain]\nkind = "Gain"\n\n[blocks.adc]'),
        ],
        """\
model.toml:10: wires: cells.impulse_response -> gain.input: the shapes do not match
  got:      a vector of 16 entries
  expected: a single value
  hint:     record a vector in probes, or wire it to an input that takes a vector of the same length""",
    ),
    "block wired but not declared": (
        [('[blocks.push]\nkind = "Constant"\nvalue = "1 uN"\nunit = "N"\n', "")],
        """\
model.toml:5: wires: push.output -> mass.force: there is no block push
  hint:     the blocks: adc, mass, readout. Otherwise declare it: [blocks.push] and below it its kind""",
    ),
    "NaN": (
        [("bits = 16", "reference = nan")],
        """\
model.toml:27: blocks.adc.reference: must be finite
  got:      nan V
  expected: a number > 0, in V""",
    ),
    "a rate of 0": (
        [('"10 kHz"', "0")],
        """\
model.toml:2: rate: must be above 0 Hz
  got:      0
  hint:     write it as "50 kHz" or as the period "20 us\"""",
    ),
    "a negative rate": (
        [("bits = 16", 'rate = "-1 Hz"')],
        """\
model.toml:27: blocks.adc.rate: must be above 0 Hz
  got:      '-1 Hz'
  hint:     write it as "50 kHz" or as the period "20 us\"""",
    ),
    "a time step of 0": (
        [('"10 kHz"', '"0 s"')],
        """\
model.toml:2: rate: must be above 0 Hz
  got:      '0 s'
  hint:     write it as "50 kHz" or as the period "20 us\"""",
    ),
}


@pytest.mark.parametrize("mistake", MISTAKES)
def test_what_is_said(mistake: str, tmp_path: Path) -> None:
    changes, expected = MISTAKES[mistake]
    text = SMALL
    for old, new in changes:
        text = changed(text, old, new)
    file = tmp_path / "model.toml"
    file.write_text(text, encoding="utf-8")
    assert said_about(file) == expected
    with pytest.raises(ModelError):
        checked(read_graph(file))


def test_the_graph_that_the_mistakes_are_made_in_is_right(tmp_path: Path) -> None:
    file = tmp_path / "model.toml"
    file.write_text(SMALL, encoding="utf-8")
    assert said_about(file) == ""


def test_the_cure_of_the_unconnected_input_works(tmp_path: Path) -> None:
    without = changed(SMALL, '    "push.output -> mass.force",\n', "")
    file = tmp_path / "model.toml"
    file.write_text(without, encoding="utf-8")
    cure = said_about(file).split("hint:     add ")[1].split(" to wires")[0]
    file.write_text(changed(without, "wires = [\n", f"wires = [\n    {cure},\n"), encoding="utf-8")
    assert said_about(file) == ""


def test_the_cure_of_the_algebraic_loop_is_a_block_that_exists() -> None:
    from proofmass.blocks.declaration.catalog import find

    delay = find("UnitDelay")
    assert delay is not None
    assert delay.feedthrough("output") == ()


def test_a_mistake_in_a_block_and_one_in_its_wiring_are_said_together(tmp_path: Path) -> None:
    text = changed(SMALL, "bits = 16", "bist = 16")
    text = changed(text, '"push.output -> mass.force"', '"push.ouput -> mass.force"')
    text = changed(text, 'kind = "Gain"', 'kind = "Gian"')
    file = tmp_path / "model.toml"
    file.write_text(text, encoding="utf-8")
    assert (
        said_about(file)
        == """\
model.toml:5: wires: push.ouput -> mass.force: push.ouput is not an output
  hint:     did you mean output?
model.toml:20: blocks.readout.kind: there is no such kind of block
  got:      'Gian'
  hint:     did you mean Gain? `proofmass blocks` lists all kinds.
model.toml:27: blocks.adc.bist: AnalogToDigital has no such parameter
  got:      'bist'
  hint:     did you mean bits?"""
    )


@pytest.mark.defect("S917", before="a wire from 2 rad/s made a frequency of 2 Hz of it", after="refused")
@pytest.mark.parametrize(
    ("source", "target", "fits"), [("rad/s", "Hz", False), ("Hz", "rad/s", False), ("1/s", "Hz", True)]
)
def test_a_wire_takes_no_angle_for_turns(source: str, target: str, fits: bool) -> None:
    graph = Graph(
        name="two",
        rate="1 kHz",
        blocks={"from": Constant(value=2.0, unit=source), "to": Gain(input_unit=target)},
        wires=["from.output -> to.input"],
        probes=["to.output"],
    )
    found = [problem for problem in check(graph) if not problem.note]
    assert [problem.message for problem in found] == ["the units do not match"] * (not fits)
    assert all("one turn is 2 pi rad" in problem.hint for problem in found)
