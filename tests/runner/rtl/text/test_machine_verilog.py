"""The digital part of a graph as Verilog against the simulation of the graph: rates, kept wires, cuts."""

from typing import NamedTuple

import pytest

from proofmass.blocks import FixedCast, FixedDelay, FixedQuantiser, FixedSum, ShiftRegister, Sine
from proofmass.blocks.arithmetic.fixed_point import Fixed, FixedValue
from proofmass.blocks.arithmetic.pipeline import pipe
from proofmass.blocks.declaration.declare import Block, Input, param
from proofmass.graphs.model.build import Graph
from proofmass.runner.rtl.text.machine_verilog import machine_text, top_name
from tests.by_hand.machines import differences, loop_at_rates, made

WIDE = Fixed(24, 16)


@pytest.mark.exhaustive("6000-3000-2000", "2000-6000-1000")
@pytest.mark.parametrize(
    ("error", "gain", "integrator"),
    [(6000, 6000, 6000), (6000, 3000, 2000), (2000, 6000, 1000), (3000, 1000, 3000), (1000, 1000, 1000)],
)
def test_blocks_tick_at_their_own_rates(error: int, gain: int, integrator: int) -> None:
    machine, vectors = made(loop_at_rates(error, gain, integrator))
    assert vectors.clocks >= 20
    assert len({int(value) for value in vectors.outputs["integrator_output"]}) > 5
    assert differences(machine, vectors) == []


def test_one_block_alone_is_its_module() -> None:
    machine, vectors = made(loop_at_rates(), "integrator")
    assert machine.single
    assert (top_name(machine), machine.rate) == ("fixed_integrator", 2000)
    assert machine_text(machine).count("module ") == machine_text(machine).count("endmodule") == 1
    assert differences(machine, vectors) == []


def test_some_blocks_of_a_graph() -> None:
    machine, vectors = made(loop_at_rates(), "gain", "integrator")
    assert [port.name for port in machine.inputs] == ["error_output"]
    assert [port.name for port in machine.outputs] == ["integrator_output"]
    assert differences(machine, vectors) == []


class State(NamedTuple):
    total: FixedValue


class Energy(Block):
    """Sum of squares, and the square, cut before the sum."""

    cuts: int = param("1", "Cuts.", default=2, at_least=0)

    first = Input("1", "Factor.", dtype=FixedValue)
    second = Input("1", "Factor.", dtype=FixedValue)


@Energy.formats
def formats(p: Energy) -> dict[str, Fixed]:
    return {"first": Fixed(12, 8), "second": Fixed(12, 8), "x.total": WIDE, "total": WIDE, "product": WIDE}


def product_of(p: Energy, first: FixedValue, second: FixedValue) -> FixedValue:
    found = first * second
    for _ in range(p.cuts):
        found = pipe(found)
    return found


@Energy.output("1")
def total(p: Energy, x: State) -> FixedValue:
    """Sum of the products before this tick."""
    return x.total


@Energy.output("1")
def product(p: Energy, first: FixedValue, second: FixedValue) -> FixedValue:
    """The product."""
    return product_of(p, first, second)


@Energy.update
def update(p: Energy, x: State, first: FixedValue, second: FixedValue) -> State:
    return State((x.total + product_of(p, first, second)).to(WIDE, "half_even", "wrap"))


def cut_graph(first: int, second: int) -> Graph:
    """Two cut blocks one behind the other, and ways around them."""
    word = Fixed(12, 8)
    return Graph(
        name="cut",
        rate=1000,
        duration="0.1 s",
        blocks={
            "sine": Sine(amplitude=1.5, frequency=37.0),
            "quantiser": FixedQuantiser(output_format=word),
            "energy": Energy(cuts=first),
            "narrow": FixedCast(input_format=WIDE, output_format=word, overflow="wrap"),
            "again": Energy(cuts=second),
            "delay": FixedDelay(format=WIDE),
            "sum": FixedSum(input_format=WIDE, output_format=WIDE, overflow="wrap"),
            "chips": ShiftRegister(length=4, taps=0xC, seed=9),
        },
        wires=[
            "sine.output -> quantiser.input",
            "quantiser.output -> energy.first",
            "quantiser.output -> energy.second",
            "energy.product -> narrow.input",
            "narrow.output -> again.first",
            "quantiser.output -> again.second",
            "energy.total -> delay.input",
            "delay.output -> sum.first",
            "again.total -> sum.second",
        ],
        probes=["sum.output", "again.product", "energy.product", "chips.bit"],
    )


@pytest.mark.parametrize(("first", "second", "latency"), [(0, 0, 0), (2, 0, 2), (0, 1, 1), (1, 3, 4)])
def test_cut_blocks_are_aligned_with_all_that_they_meet(first: int, second: int, latency: int) -> None:
    machine, vectors = made(cut_graph(first, second))
    assert machine.latency == latency
    assert differences(machine, vectors) == []


def test_a_cut_block_alone() -> None:
    machine, vectors = made(cut_graph(2, 1), "energy")
    assert not machine.single  # one wire at two ports
    assert differences(machine, vectors) == []


def test_a_difference_is_found() -> None:
    machine, vectors = made(loop_at_rates())
    vectors.outputs["error_output"][7] += 1
    assert [n for n, _, _ in differences(machine, vectors)] == [7]


def test_the_text_says_where_everything_comes_from() -> None:
    machine, _ = made(loop_at_rates())
    text = machine_text(machine)
    for line in (
        "// top: clock enabled at 6000 Hz",
        "    input wire signed [15:0] quantiser_output,  // (16, 12): The input in the format, as its mantissa; where",
        "    wire tick_2 = enable && count_2 == 1'd0;",
        "    fixed_gain gain (  // FixedGain gain",
        "        .enable(tick_3),",
        "    assign gain_output = tick_2 ? gain_output_now : gain_output_kept;",
    ):
        assert line in text
