"""Loops without delay that are refused: each is named wire by wire, with what cures it, and the cure is one."""

from typing import Any

import pytest

from proofmass.blocks import (
    Constant,
    DotProduct,
    Gain,
    MassSpringDamper,
    SamplingNoise,
    Sum,
    TransferFunction,
    UnitDelay,
    VectorJoin,
)
from proofmass.blocks.declaration.declare import Block
from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.checks.check import check
from proofmass.graphs.model.build import Graph
from tests.graphs.checks.test_schedule import NEWTON, schedule


def test_a_loop_is_named_wire_by_wire() -> None:
    blocks: dict[str, Block] = {"sum": Sum(), "gain": Gain(), "source": Constant(), "back": Gain()}
    wires = ["source.output -> sum.first", "sum.output -> gain.input", "gain.output -> back.input"]
    graph = Graph(name="", rate=1, blocks=blocks, wires=[*wires, "back.output -> sum.second"])
    assert (
        "\n".join(map(str, check(graph)))
        == """\
wires: algebraic loop: each of these outputs needs the one before it within the same tick
  got:      back.output -> sum.second, sum.output -> gain.input, gain.output -> back.input
  expected: at least one block in the loop whose output does not depend on its input in the same tick
  hint:     put a UnitDelay into one of these wires, for example into gain.output -> back.input; \
or have the loop solved: algebraic_loops = "newton" under [integration]"""
    )


def test_a_filter_in_the_loop_is_offered_by_its_strictly_proper_part() -> None:
    blocks: dict[str, Block] = {"lag": TransferFunction(), "gain": Gain()}
    graph = Graph(name="", rate=1, blocks=blocks, wires=["lag.output -> gain.input", "gain.output -> lag.input"])
    (problem,) = check(graph)
    offered = (
        "lag.strictly_proper_part needs no input of the same tick: wire it in place of lag.output if it serves. Or put"
    )
    assert problem.hint.startswith(offered)
    cured = Graph(
        name="",
        rate=1,
        blocks=blocks,
        wires=["lag.strictly_proper_part -> gain.input", "gain.output -> lag.input"],
        probes=["gain.output"],
    )
    assert check(cured) == []


def test_a_delay_in_the_loop_cures_it() -> None:
    blocks: dict[str, Block] = {"sum": Sum(), "gain": Gain(), "source": Constant(), "back": UnitDelay()}
    wires = ["source.output -> sum.first", "sum.output -> gain.input", "gain.output -> back.input"]
    graph = Graph(name="", rate=1, blocks=blocks, wires=[*wires, "back.output -> sum.second"], probes=["sum.output"])
    assert check(graph) == []
    assert schedule(graph).order == (
        ("back", "output"),
        ("source", "output"),
        ("sum", "output"),
        ("gain", "output"),
    )


def test_a_continuous_block_in_the_loop_cures_it() -> None:
    blocks: dict[str, Block] = {"mass": MassSpringDamper(), "gain": Gain(input_unit="m", output_unit="N")}
    wires = ["mass.displacement -> gain.input", "gain.output -> mass.force"]
    assert schedule(Graph(name="", rate=1, blocks=blocks, wires=wires)).order == (
        ("mass", "displacement"),
        ("gain", "output"),
        ("mass", "velocity"),
    )


@pytest.mark.parametrize(
    ("blocks", "wires", "rates", "reason"),
    [
        ({"g": Gain()}, ["g.output -> g.gain", "c.output -> g.input"], {}, "the parameters of g depend on its own"),
        (
            {"g": Gain(), "h": Gain()},
            ["g.output -> h.input", "h.output -> g.input"],
            {"h": 2},
            "its outputs have different rates",
        ),
        (
            {"g": SamplingNoise(), "h": Gain(input_unit="V", output_unit="V")},
            ["g.output -> h.input", "h.output -> g.voltage"],
            {},
            "g.output draws noise",
        ),
        (
            {"g": VectorJoin(), "h": DotProduct(weights=(1.0, 1.0))},
            ["g.output -> h.vector", "h.output -> g.first", "c.output -> g.second"],
            {},
            "g.output is not a single number of type float",
        ),
    ],
)
def test_why_newtons_method_cannot_solve_a_loop(
    blocks: dict[str, Block], wires: list[str], rates: dict[str, Any], reason: str
) -> None:
    graph = Graph(name="", rate=1, blocks={**blocks, "c": Constant()}, wires=wires, rates=rates, integration=NEWTON)
    with pytest.raises(ModelError, match=f"Newton's method cannot solve the loop, since {reason}"):
        schedule(graph)
