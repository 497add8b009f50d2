"""Every kind of problem of a wiring, its exact text, and all of them at once."""

import time
from typing import Any

import pytest

from proofmass.blocks import (
    AnalogToDigital,
    Constant,
    Gain,
    MassSpringDamper,
    Product,
    ShiftRegister,
    SquareRoot,
)
from proofmass.blocks.declaration.declare import Block, Input, param
from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.checks.check import check, checked
from proofmass.graphs.files.toml_reader import read_graph
from proofmass.graphs.model.build import Graph
from proofmass.graphs.model.exports import runs_alone
from proofmass.graphs.model.flatten import flatten
from proofmass.graphs.model.limits import PROBLEMS
from tests.by_hand.graph_texts import LIBRARY, SMALL, changed, problems_of

READOUT = '"readout.output -> adc.voltage",'


def said(*changes: tuple[str, str], text: str = SMALL) -> str:
    for old, new in changes:
        text = changed(text, old, new)
    return "\n".join(map(str, problems_of(text)))


def with_wire(wire: str, *changes: tuple[str, str]) -> str:
    return said((READOUT, f'{READOUT}\n    "{wire}",'), *changes)


def with_block(kind: str, name: str = "more") -> tuple[str, str]:
    return ("[blocks.adc]", f'[blocks.{name}]\nkind = "{kind}"\n\n[blocks.adc]')


@pytest.mark.parametrize("path", LIBRARY, ids=lambda path: path.stem)
def test_the_library_has_no_problems(path: Any) -> None:
    graph = read_graph(path)
    if not runs_alone(flatten(graph)):  # a part of others
        assert [problem.message for problem in check(graph) if not problem.note] == []
        with pytest.raises(ModelError, match="cannot run alone"):
            checked(graph)
    else:
        assert check(graph) == []
        assert checked(graph) is graph


def test_units_of_another_dimension() -> None:
    assert (
        said(('value = "1 uN"\nunit = "N"', 'value = "1 A"\nunit = "A"'))
        == """\
model.toml:5: wires: push.output -> mass.force: the units do not match
  got:      A
  expected: N
  hint:     A is not m*kg/s^2; put a Gain with input_unit = "A" and output_unit = "N" between"""
    )


def test_units_that_differ_by_a_factor() -> None:
    assert (
        said(('gain = "1e6 V/m"', 'gain = "1e6 mV/m"'), ('output_unit = "V"', 'output_unit = "mV"'))
        == """\
model.toml:7: wires: readout.output -> adc.voltage: the units differ by a factor of 0.001
  got:      mV
  expected: V
  hint:     set output_unit = "V" under [blocks.readout], \
or put a Gain with input_unit = "mV" and output_unit = "V" between"""
    )


def test_units_written_in_another_way_are_the_same() -> None:
    assert said(('unit = "N"', 'unit = "kg*m/s^2"')) == ""


def test_a_type_is_not_converted_in_silence() -> None:
    assert (
        with_wire("adc.code -> more.input", with_block("Gain"), ('probes = ["adc.code"]', 'probes = ["more.output"]'))
        == """\
model.toml:8: wires: adc.code -> more.input: the types do not match
  got:      int
  expected: float
  hint:     its output number has that type"""
    )
    assert "hint:     an AnalogToDigital makes codes of numbers" in said(
        (READOUT, f'{READOUT} "push.output -> more.code", "chips.bit -> more.bit",'),
        with_block("Correlator"),
        with_block("ShiftRegister", "chips"),
        ('value = "1 uN"\nunit = "N"', ""),
    )


def test_an_unknown_block_port_and_parameter_each_with_the_nearest_name() -> None:
    assert (
        said(
            ('"push.output -> mass.force"', '"psh.output -> mass.force"'),
            ('"mass.displacement -> readout.input"', '"mass.displacment -> readout.inptu"'),
            ('"readout.output -> adc.voltage"', '"readout.output -> adc.refrence"'),
            ('probes = ["adc.code"]', 'probes = ["adc.cod", "acd.code"]'),
        )
        == """\
model.toml:5: wires: psh.output -> mass.force: there is no block psh
  hint:     did you mean push? Otherwise declare it: [blocks.psh] and below it its kind
model.toml:6: wires: mass.displacment -> readout.inptu: mass.displacment is not an output
  hint:     did you mean displacement?
model.toml:6: wires: mass.displacment -> readout.inptu: readout.inptu is neither an input nor a parameter
  hint:     did you mean input?
model.toml:7: wires: readout.output -> adc.refrence: adc.refrence is neither an input nor a parameter
  hint:     did you mean reference?
model.toml:9: probes: adc.cod: adc.cod is not an output
  hint:     did you mean code?
model.toml:9: probes: acd.code: there is no block acd
  hint:     did you mean adc? Otherwise declare it: [blocks.acd] and below it its kind
model.toml:25: blocks.adc: the input voltage is not connected
  expected: a wire that carries a number in V: Voltage to convert.
  hint:     add "readout.output -> adc.voltage" to wires"""
    )


def test_ports_on_the_wrong_side_of_a_wire() -> None:
    assert (
        said(('"push.output -> mass.force"', '"mass.force -> push.output"'))
        == """\
model.toml:5: wires: mass.force -> push.output: the wire is backwards
  hint:     write "push.output -> mass.force\""""
    )


def test_a_parameter_is_no_source() -> None:
    assert "adc.bits is a parameter, not an output" in said(('probes = ["adc.code"]', 'probes = ["adc.bits"]'))


def test_two_wires_into_one_input_and_the_same_wire_twice() -> None:
    assert (
        with_wire("push.output -> mass.force")
        == """\
model.toml:5: wires: push.output -> mass.force: mass.force is driven twice
  got:      two wires from push.output
  expected: one wire
  hint:     remove one of the wires"""
    )


def test_parameters_that_a_wire_may_not_drive() -> None:
    more = ("[blocks.adc]", '[blocks.one]\nkind = "Constant"\n\n[blocks.adc]')
    assert (
        with_wire("one.output -> adc.bits", more)
        == """\
model.toml:8: wires: one.output -> adc.bits: adc.bits cannot be driven
  hint:     it is a parameter that fixes a size, a start or a choice: set it under [blocks.adc]"""
    )
    assert with_wire("one.output -> adc.gain_error", more) == ""


def test_a_rate_on_a_continuous_block() -> None:
    assert (
        said(('kind = "MassSpringDamper"', 'kind = "MassSpringDamper"\nrate = "1 kHz"'))
        == """\
model.toml:18: blocks.mass.rate: a continuous block has no rate: it is integrated from each tick of the graph to the \
next
  hint:     leave the rate out, or give it to the blocks that sample this one"""
    )


def test_no_rate_at_all_and_no_rate_for_some() -> None:
    assert (
        said(('rate = "10 kHz"\n', ""))
        == """\
model.toml: rate: the graph has no rate
  hint:     add rate = "50 kHz" at the top of the file"""
    )
    assert (
        said(('rate = "10 kHz"\n', ""), ("bits = 16", 'rate = "10 kHz"'))
        == """\
model.toml:10: blocks.push: has no rate, and neither has the graph
  hint:     add rate = "50 kHz" at the top of the file, or to this block
model.toml:18: blocks.readout: has no rate, and neither has the graph
  hint:     add rate = "50 kHz" at the top of the file, or to this block"""
    )


def test_rates_without_a_common_base_rate() -> None:
    assert (
        said(("bits = 16", 'rate = "9999.9973 Hz"'))
        == """\
model.toml:27: rate: the rates have no common base rate within reach
  got:      adc at 9999.9973 Hz, push at 10 kHz
  expected: at most 1,000,000 ticks of their least common multiple in one tick of the slowest
  hint:     make the rates ratios of small numbers: 10 kHz for adc, for example"""
    )


def test_a_graph_of_continuous_blocks_alone_needs_a_rate() -> None:
    blocks = {"mass": MassSpringDamper()}
    without = Graph(name="", blocks=blocks)
    assert [problem.message for problem in check(without)] == [
        "the graph has no rate",
        "the input force is not connected",
    ]
    assert [problem.message for problem in check(Graph(name="", blocks=blocks, rate=1))] == [
        "the input force is not connected"
    ]


def test_a_graph_without_blocks() -> None:
    assert (
        "\n".join(map(str, problems_of('name = "nothing"\n')))
        == """\
model.toml: blocks: the graph has no blocks
  hint:     add [blocks.NAME] and below it kind = "Gain\""""
    )


def test_a_probe_twice() -> None:
    assert (
        said(('probes = ["adc.code"]', 'probes = [\n"adc.code",\n"adc.code",\n]'))
        == """\
model.toml:11: probes: adc.code: probed twice
  hint:     remove one of the probes"""
    )


def test_notes_do_not_stop_a_run() -> None:
    text = changed(SMALL, 'probes = ["adc.code"]\n', "")
    found = problems_of(text)
    assert all(problem.note for problem in found)
    assert (
        "\n".join(map(str, found))
        == """\
model.toml: note: probes: no probes: a run records nothing
  hint:     add probes = ["block.output"] above the first block
model.toml:24: note: blocks.adc: none of its outputs is used
  hint:     wire one of code, number, or add "adc.code" to probes"""
    )


def test_notes_are_left_out_while_there_are_problems() -> None:
    text = changed(SMALL, 'probes = ["adc.code"]', "").replace("push.output", "push.outptu")
    assert [problem.note for problem in problems_of(text)] == [False]


def test_several_inputs_that_would_take_the_same_wires() -> None:
    sources = {f"source_{n}": Constant(unit="V") for n in range(5)}
    graph = Graph(name="", rate=1, blocks={**sources, "adc": AnalogToDigital()})
    hint = 'add "source_0.output -> adc.voltage" to wires; source_1.output and source_2.output would fit too'
    assert [problem.hint for problem in check(graph)] == [hint]


def test_inputs_are_offered_in_turn_what_is_wired_to_no_input_of_the_block() -> None:
    text = """\
rate = 1
wires = [
    "plus.output -> apart.addend",
    "minus.output -> apart.subtrahend",
]

[blocks]
plus = { kind = "Constant", unit = "A" }
minus = { kind = "Constant", unit = "A" }
apart = { kind = "Difference", unit = "A" }
"""
    assert [problem.hint for problem in problems_of(text)] == [
        "inputs of apart: first, second.",
        "inputs of apart: first, second.",
        'add "plus.output -> apart.first" to wires; minus.output would fit too',
        'add "minus.output -> apart.second" to wires; plus.output would fit too',
    ]


def test_an_input_that_nothing_fits() -> None:
    graph = Graph(name="", rate=1, blocks={"adc": AnalogToDigital()})
    assert [problem.hint for problem in check(graph)] == ['add "block.output -> adc.voltage" to wires']


@pytest.mark.friendly(6, "faults of all sorts at once")
def test_all_problems_at_once() -> None:
    text = """\
name = "everything"
wires = [
    "push.output -> mass.force",
    "pull.output -> mass.force",
    "mass.displacment -> readout.input",
    "adc.code -> readout.gain",
    "push.output -> adc.bits",
    "ghost.output -> gain.input",
    "chips.bit -> other.input",
]
probes = ["adc.code", "adc.code", "nothing.here"]

[blocks]
push = { kind = "Constant", unit = "V", rate = "1 Hz" }
pull = { kind = "Constant", unit = "mN", rate = "1000001/3 Hz" }
mass = { kind = "MassSpringDamper", rate = "1 Hz" }
readout.kind = "Gain"
adc.kind = "AnalogToDigital"
gain.kind = "Gain"
chips.kind = "ShiftRegister"
other.kind = "Gain"
"""
    found = problems_of(text)
    assert [(problem.line, problem.message) for problem in found] == [
        (3, "the units do not match"),
        (4, "mass.force is driven twice"),
        (4, "the units differ by a factor of 0.001"),
        (5, "mass.displacment is not an output"),
        (6, "the types do not match"),
        (7, "adc.bits cannot be driven"),
        (8, "there is no block ghost"),
        (9, "the types do not match"),
        (11, "probed twice"),
        (11, "there is no block nothing"),
        (15, "the rates have no common base rate within reach"),
        (16, "a continuous block has no rate: it is integrated from each tick of the graph to the next"),
        (17, "has no rate, and neither has the graph"),
        (18, "has no rate, and neither has the graph"),
        (18, "the input voltage is not connected"),
        (19, "has no rate, and neither has the graph"),
        (20, "has no rate, and neither has the graph"),
        (21, "has no rate, and neither has the graph"),
    ]
    assert all(str(problem).startswith(f"model.toml:{problem.line}: ") for problem in found)


def test_a_refused_graph_names_every_problem_in_one_error() -> None:
    graph = Graph(name="", rate=1, blocks={"adc": AnalogToDigital(), "gain": Gain()})
    with pytest.raises(ModelError) as caught:
        checked(graph)
    assert len(caught.value.problems) == 2


def test_units_too_long_to_compare_are_a_problem_and_no_crash() -> None:
    class Squared(Block):
        """A block whose output has a longer unit than its input."""

        unit: str = param("", "Unit of the input.", default="1")
        input = Input("{unit}", "Input.")

    def square(p: Any, input: float) -> float:
        """The square."""
        return input * input

    Squared.output("({unit})*({unit})")(square)
    unit = "*".join(["kg/kg"] * 33)
    blocks = {"a": Constant(unit=unit), "b": Squared(unit=unit), "c": Gain()}
    graph = Graph(name="", rate=1, blocks=blocks, wires=["a.output -> b.input", "b.square -> c.input"])
    assert [problem.message for problem in check(graph)] == [
        "the units cannot be compared: a unit of over 200 characters"
    ]


def test_an_input_in_a_unit_too_long_to_compare_is_not_connected_either() -> None:
    long = "*".join(["kg/kg"] * 33)
    blocks = {
        "root": SquareRoot(unit=long),
        "other": SquareRoot(unit="m"),
        "times": Product(first_unit=long, second_unit=long),
    }
    told = check(Graph(name="", rate=1, blocks=blocks, probes=["root.output", "times.output"]))
    assert sorted((p.key, p.message) for p in told) == [
        ("blocks.other", "the input input is not connected"),
        ("blocks.root", "the input input is not connected"),
        ("blocks.times", "the input first is not connected"),
        ("blocks.times", "the input second is not connected"),
    ]


def test_ten_thousand_blocks_that_fit_nothing_are_reported_within_seconds() -> None:
    blocks: dict[str, Block] = {f"b{n}": AnalogToDigital() if n % 2 else ShiftRegister() for n in range(10_000)}
    wires = [f"b{n}.bitt -> c{n}.voltag" for n in range(10_000)]
    graph = Graph(name="", rate=1, blocks=blocks, wires=wires)
    began = time.process_time()
    found = check(graph)
    assert len(found) == PROBLEMS
    assert time.process_time() - began < 2.0


def test_more_blocks_than_the_limit_are_refused_before_anything_else() -> None:
    gain = Gain()
    graph = Graph(name="", rate=1, blocks={f"b{n}": gain for n in range(10_001)})
    assert [str(problem) for problem in check(graph)] == [
        "blocks: too many\n  got:      10001\n  expected: at most 10000"
    ]


def test_a_block_that_is_not_there_is_one_problem_however_many_wires_name_it() -> None:
    text = SMALL.replace('"push.output', '"pusher.output', 1) + '\n[blocks.more]\nkind = "Gain"\ninput_unit = "N"\n'
    text = text.replace("probes =", "", 0).replace(
        '    "mass.displacement', '    "pusher.output -> more.input",\n    "mass.displacement', 1
    )
    found = [problem.message for problem in problems_of(text) if not problem.note]
    assert found.count("there is no block pusher") == 1
