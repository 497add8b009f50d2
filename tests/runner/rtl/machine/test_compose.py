"""Which blocks become hardware, what joins them, at which clocks; and what is refused."""

import re
from fractions import Fraction
from typing import NamedTuple

import pytest

from proofmass.blocks import (
    AnalogToDigital,
    ChipCounter,
    CodeToNumber,
    Correlator,
    FixedCast,
    FixedDelay,
    FixedGain,
    FixedQuantiser,
    FixedSum,
    Pulse,
    ShiftRegister,
    Sine,
)
from proofmass.blocks.arithmetic.fixed_point import Fixed, FixedValue
from proofmass.blocks.arithmetic.pipeline import pipe
from proofmass.blocks.declaration.declare import Block, Input
from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.files.library import FOLDER, library_file
from proofmass.graphs.files.toml_reader import read_graph
from proofmass.graphs.model.build import Graph
from proofmass.runner.planning.plan import plan
from proofmass.runner.rtl.machine.compose import compose, digital_blocks
from proofmass.runner.rtl.machine.machine import Machine
from proofmass.runner.rtl.machine.words import Word
from tests.by_hand.machines import loop_at_rates, made


def library(name: str, *only: str) -> Machine:
    return compose(plan(read_graph(library_file(f"{name}.toml"))), only, name)


def refused(graph: Graph, *only: str) -> str:
    with pytest.raises(ModelError) as caught:
        compose(plan(graph), only)
    return str(caught.value)


def test_the_digital_part_of_the_self_calibration() -> None:
    machine = library("self_calibration_fixed")
    assert machine.rate == 2_457_600
    assert {port.text: str(port.word) for port in machine.inputs} == {
        "measured.output": "(16, 12)",
        "acceleration.output": "(24, 6)",
    }
    assert {port.text for port in machine.outputs} == {
        "chips.bit", "stiffness.stiffness", "damping.damping", "cell.coefficient", "model_cell.coefficient",
    }  # fmt: skip
    strides = {each.path: each.stride for each in machine.instances}
    assert (strides["model"], strides["chips"], strides["damping"]) == (1, 512, 512 * 1023)
    assert machine.counters == ((512, 1, 511), (512 * 1023, 512, 1022))
    modules = {each.path: each.module for each in machine.instances}
    assert modules["cell"] is modules["model_cell"]
    assert modules["modelled"].name == "fixed_gain_modelled"
    assert machine.nets["model.displacement"].kept is False
    assert machine.nets["stiffness_over_mass.output"].kept is True  # the model reads it at every clock


def test_the_compensator_of_a_subgraph_is_its_digital_blocks() -> None:
    machine = library("temperature_compensation_m1", "digital")
    assert len(machine.instances) == 13
    assert {each.module.name for each in machine.instances if "cordic" in each.path} == {"fixed_cordic_exponential"}
    assert [port.text for port in machine.inputs] == ["digital.temperature.output", "digital.sensor.output"][::-1]
    alone = library("temperature_compensation_m1", "digital.first")
    assert {each.path for each in alone.instances} == {
        f"digital.first.{name}" for name in ("cordic", "exponent", "reducer", "scaled", "shift")
    }


def test_each_output_stands_behind_those_that_it_needs() -> None:
    machine = library("temperature_compensation_m1")
    assert machine.order.index(("digital.first.reducer", "octave")) < machine.order.index(
        ("digital.first.shift", "output")
    )


def test_every_shipped_graph_becomes_hardware_or_says_why_not() -> None:
    reasons = set()
    for path in sorted(FOLDER.rglob("*fixed*.toml")) + sorted(FOLDER.rglob("temperature_comp*.toml")):
        try:
            planned = plan(read_graph(path))
        except ModelError:
            continue  # a part of other graphs
        machine = compose(planned, (), path.stem)
        reasons.add(path.stem)
        assert machine.instances
        assert machine.outputs
    assert reasons >= {"self_calibration_fixed", "fixed_against_floating", "temperature_compensation_drift"}


def codes(reader: Block) -> Graph:
    return Graph(
        name="codes",
        rate=1000,
        samples=10,
        blocks={"sine": Sine(unit="V"), "adc": AnalogToDigital(bits=9), "reader": reader},
        wires=["sine.output -> adc.voltage", "adc.code -> reader.code"],
        probes=["reader.doubled"],
    )


class Doubler(Block):
    """Twice a code, as an integer."""

    code = Input("1", "Code.", dtype=int)


@Doubler.output("1")
def doubled(p: Doubler, code: int) -> int:
    """Twice the code."""
    return 2 * code


def test_integers_are_as_wide_as_what_they_come_from() -> None:
    machine = compose(plan(codes(Doubler())))
    assert [port.word for port in machine.inputs] == [Word(-256, 255)]
    assert [port.word for port in machine.outputs] == [Word(-512, 510)]


def test_what_carries_numbers_or_noise_or_seconds_is_left_outside() -> None:
    assert digital_blocks(plan(loop_at_rates())) == ("error", "gain", "integrator")
    graph = Graph(name="g", rate=1, blocks={"a": ShiftRegister(), "b": Pulse()}, wires=[], probes=["a.bit", "b.output"])
    assert digital_blocks(plan(graph)) == ("a",)


def test_names_that_are_no_digital_blocks_are_refused_together() -> None:
    text = refused(loop_at_rates(), "gian", "quantiser", "integrator")
    assert "blocks.gian: no such block" in text
    assert "did you mean gain?" in text
    assert "blocks.quantiser: is not a digital block, and cannot become hardware" in text
    assert "got:      FixedQuantiser" in text
    assert "a block whose ports and state are integers, truth values or fixed-point values" in text


def test_a_graph_without_digital_blocks_is_refused() -> None:
    text = refused(Graph(name="g", rate=1, blocks={"a": Sine()}, wires=[], probes=["a.output"]))
    assert "blocks: the graph has no digital blocks" in text
    assert "put a FixedQuantiser behind what is analogue" in text


class Looped(Block):
    """A code that says how often a loop is run."""

    code = Input("1", "Code.", dtype=int)


@Looped.output("1")
def doubled(p: Looped, code: int) -> int:  # noqa: F811
    """So many ones."""
    count = 0
    for _ in range(code):
        count = count ^ 1
    return count


def test_a_block_that_cannot_be_traced_is_refused_with_its_line() -> None:
    text = refused(codes(Looped()))
    assert re.search(r"test_compose\.py:\d+: blocks\.\w+\.doubled: a signal bounds a loop or indexes a list", text)
    assert "hint:     give the loop a constant length" in text


@pytest.mark.exhaustive
def test_sums_without_a_format_that_grow_are_refused_with_their_line() -> None:
    graph = Graph(
        name="g",
        rate=1,
        blocks={"sine": Sine(unit="V"), "adc": AnalogToDigital(), "chips": ShiftRegister(), "bank": Correlator()},
        wires=["sine.output -> adc.voltage", "adc.code -> bank.code", "chips.bit -> bank.bit"],
        probes=["bank.impulse_response"],
    )
    text = refused(graph)
    assert "correlator.py:49: blocks.bank.bank: sums: sums grows without bound" in text
    assert "hint:     hold it with clip() or a mask" in text


class Counted(Block):
    """A code of which no format is said."""

    voltage = Input("V", "Voltage.")


@Counted.output("1")
def code(p: Counted, voltage: float) -> int:
    """A count."""
    return int(voltage)


def test_integers_from_outside_need_a_format() -> None:
    graph = Graph(
        name="g",
        rate=1,
        blocks={"sine": Sine(unit="V"), "count": Counted(), "doubler": Doubler()},
        wires=["sine.output -> count.voltage", "count.code -> doubler.code"],
        probes=["doubler.doubled"],
    )
    text = refused(graph)
    assert "blocks.count: how many bits count.code has is not said" in text
    assert 'return {"code": Fixed(12)}' in text


class Kept(NamedTuple):
    held: int


class Follower(Block):
    """An integer, a tick later."""

    code = Input("1", "Code.", dtype=int)


@Follower.output("1")
def held(p: Follower, x: Kept) -> int:
    """The code before."""
    return x.held


@Follower.update
def follow(p: Follower, x: Kept, code: int) -> Kept:
    return Kept(code)


def test_integers_that_go_round_are_refused() -> None:
    graph = Graph(
        name="g",
        rate=1,
        blocks={"a": Follower(), "b": Follower()},
        wires=["a.held -> b.code", "b.held -> a.code"],
        probes=["a.held"],
    )
    text = refused(graph)
    assert "integers go round in a loop, and their range cannot be told" in text
    assert "let a FixedValue go round: its format is the range" in text


class Late(Block):
    """The input, cut."""

    input = Input("1", "Any.", dtype=FixedValue)


@Late.formats
def formats(p: Late) -> dict[str, Fixed]:
    return {"input": Fixed(16, 12), "output": Fixed(16, 12)}


@Late.output("1")
def output(p: Late, input: FixedValue) -> FixedValue:
    """The input."""
    return pipe(input)


def cut_loop(own: Fraction) -> Graph:
    return Graph(
        name="g",
        rate=1000,
        blocks={"sine": Sine(), "in": FixedQuantiser(), "sum": FixedSum(), "late": Late(), "delay": FixedDelay()},
        rates={"delay": own},
        wires=[
            "sine.output -> in.input",
            "in.output -> sum.first",
            "delay.output -> sum.second",
            "sum.output -> late.input",
            "late.output -> delay.input",
        ],
        probes=["late.output"],
    )


def test_a_cut_in_a_loop_of_blocks_is_refused() -> None:
    text = refused(cut_loop(Fraction(1000)))
    assert (
        "blocks.late: a pipeline cut in a loop of blocks: each round would take longer than in the simulation" in text
    )
    assert "late.output -> delay.input, delay.output -> sum.second, sum.output -> late.input" in text
    assert "keep the stages in the state of the block" in text


def test_a_cut_among_several_rates_is_refused() -> None:
    graph = Graph(
        name="g",
        rate=1000,
        blocks={
            "sine": Sine(),
            "in": FixedQuantiser(),
            "late": Late(),
            "gain": FixedGain(),
            "slow": FixedCast(input_format=Fixed(16, 12)),
        },
        rates={"slow": Fraction(500)},
        wires=[
            "sine.output -> in.input",
            "in.output -> late.input",
            "late.output -> gain.input",
            "gain.output -> slow.input",
        ],
        probes=["slow.output"],
    )
    text = refused(graph)
    assert "blocks.late: a pipeline cut, and outputs at several rates" in text
    assert "as with --block late" in text
    assert compose(plan(graph), ["late", "gain"]).latency == 1


def test_an_input_that_is_not_wired_is_its_default() -> None:
    (instance,) = compose(plan(loop_at_rates()), ["error"]).instances
    assert instance.module.name == "fixed_difference"
    machine = compose(plan(cut_loop(Fraction(1000))), ["sum"])
    (instance,) = machine.instances
    assert (instance.inputs["third"], instance.inputs["fourth"]) == (0, 0)
    assert not machine.single


def test_a_counter_of_chips_beside_its_reader() -> None:
    graph = Graph(
        name="g",
        rate=1,
        blocks={"counter": ChipCounter(chips=10, last=3), "doubler": Doubler(), "number": CodeToNumber()},
        wires=["counter.chip -> doubler.code", "doubler.doubled -> number.code"],
        probes=["number.number"],
    )
    machine = compose(plan(graph))
    assert [str(port.word) for port in machine.outputs] == ["(5, 0) unsigned"]


def test_what_has_no_registers_needs_no_ticks() -> None:
    machine, _ = made(loop_at_rates(2000, 2000, 2000), "error", "gain")
    assert machine.strides == ()
    assert not machine.clocked
