"""What the functions of a block are given, against the wires of a graph written by hand."""

from typing import NamedTuple

import pytest

from proofmass.blocks.declaration.arguments import Meaning
from proofmass.blocks.declaration.declare import Block, Buffer, Input
from proofmass.blocks.sources.constant import Constant
from proofmass.graphs.model.build import Graph
from proofmass.runner.plan import bindings
from proofmass.runner.planning.plan import plan


class Taking(Block):
    """Takes all that there is."""

    wired = Input("1", "Connected.")
    loose = Input("1", "Not connected.", default=-0.0)
    loose_bit = Input("1", "Not connected.", bool, default=False)
    line = Buffer("A line.", float, (3,))


class State(NamedTuple):
    sum: float


@Taking.output("1", dtype=float, shape=(2,))
def entries(c, out, x: State, line, wired: float, loose_bit: bool) -> None:  # type: ignore[no-untyped-def]
    """Two entries."""
    out[0], out[1] = x.sum + line[0], wired


@Taking.output("1")
def value(c, loose: float, time: float, tick: int, normal: float) -> float:  # type: ignore[no-untyped-def]
    """A value."""
    return loose + time + float(tick) + normal


@Taking.update
def update(c, x: State, line, wired: float) -> State:  # type: ignore[no-untyped-def]
    line[0] = wired
    return State(x.sum + wired)


GRAPH = Graph(
    name="taking",
    rate="1 kHz",
    blocks={"level": Constant(value=1.0), "part_taking": Taking(), "slow": Taking()},
    rates={"slow": "250 Hz"},
    wires=["level.output -> part_taking.wired", "level.output -> slow.wired"],
)


def test_each_kind_of_binding() -> None:
    planned = plan(GRAPH)
    name = "part_taking"
    assert planned.bindings(name, "entries") == (
        bindings.Out((name, "entries")),
        bindings.StateBinding(name),
        bindings.BufferBinding((name, "line")),
        bindings.WireBinding(("level", "output")),
        bindings.Default((name, "loose_bit"), False),
    )
    assert planned.bindings(name, "value") == (
        bindings.Default((name, "loose"), -0.0),
        bindings.Time(),
        bindings.Tick(1),
        bindings.Deviate(name, 1),
    )
    assert planned.bindings(name, "update")[1:] == (
        bindings.BufferBinding((name, "line")),
        bindings.WireBinding(("level", "output")),
    )
    assert planned.bindings("slow", "value")[2:] == (bindings.Tick(4), bindings.Deviate("slow", 4))


def test_defaults_keep_their_type_and_sign() -> None:
    """-0.0, 0.0 and False are equal: two inputs with such defaults must not share a place."""
    planned = plan(GRAPH)
    loose, bit = planned.bindings("slow", "value")[0], planned.bindings("slow", "entries")[-1]
    assert isinstance(loose, bindings.Default)
    assert isinstance(bit, bindings.Default)
    assert str(loose.value) == "-0.0"
    assert bit.value is False
    assert loose != bit


def test_constants_alone_are_given_the_period() -> None:
    block = GRAPH.blocks["level"]
    with pytest.raises(ValueError, match="period"):
        bindings.bound(plan(GRAPH).schedule, block, "level", "", "period", Meaning.PERIOD)
