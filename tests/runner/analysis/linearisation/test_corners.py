"""Operating points exactly at a corner: tables, own blocks and buffers that have one there say so, and no others."""

from typing import Any, NamedTuple

import pytest

from proofmass import Graph, margins, response
from proofmass.blocks import (
    Constant,
    DeadZone,
    Gain,
    LookUpTable,
    MedianFilter,
    RateLimiter,
    Saturation,
    Sum,
    UnitDelay,
)
from proofmass.blocks.declaration.declare import Block, Input

SAID = "x stands exactly at a corner: its slope is that of one side, and on the other side it is another"


class Folded(Block):
    """The larger of its input and half of it, kept for a tick."""

    input = Input("1", "Number.")


class Kept(NamedTuple):
    number: float


@Folded.start
def start(p: Any) -> Kept:
    return Kept(0.0)


@Folded.output("1")
def output(p: Any, x: Kept) -> float:
    """What is kept."""
    return x.number


@Folded.update
def update(p: Any, input: float) -> Kept:
    return Kept(input if input > 0.0 else 0.5 * input)


def loop(block: Any, bias: float = 0.0) -> Graph:
    """A block behind a bias, and a way past it, whose sum goes back by a gain and a delay."""
    port = next(iter(type(block).outputs))
    return Graph(
        name="loop",
        rate="1 kHz",
        blocks={
            "bias": Constant(value=bias), "sum": Sum(), "x": block, "both": Sum(), "back": Gain(gain=-0.05),
            "late": UnitDelay(),
        },
        wires=[
            "bias.output -> sum.first", "late.output -> sum.second", "sum.output -> x.input",
            f"x.{port} -> both.first", "sum.output -> both.second", "both.output -> back.input",
            "back.output -> late.input",
        ],
        loops={"main": {"open_at": "back.output"}},
    )  # fmt: skip


def table(left: float, right: float) -> LookUpTable:
    """A table with two slopes that meet at zero."""
    return LookUpTable(breakpoints=(-1.0, 0.0, 1.0), values=(-left, 0.0, right))


@pytest.mark.defect(
    "S890", before="a kink at rest: stable by 1.94 dB, unstable on its other side, unsaid", after="a note"
)
@pytest.mark.parametrize(
    ("block", "notes"),
    [
        (table(12.0, 4.0), (SAID,)),
        (table(4.0, 4.0), ()),  # a breakpoint, and no corner
        (DeadZone(lowest=0.0, highest=1.0), (SAID,)),
        (DeadZone(lowest=-1.0, highest=1.0), ()),
        (Folded(), (SAID,)),
        (Saturation(), ()),
        (RateLimiter(), ()),
    ],
)
def test_a_loop_at_a_corner_says_so(block: Any, notes: tuple[str, ...]) -> None:
    assert margins(loop(block), at="0 s").system.map.notes == notes


@pytest.mark.parametrize(("edge", "notes"), [(0.0, (SAID,)), (1e-9, ())])
def test_a_response_at_the_edge_of_a_dead_zone_says_so(edge: float, notes: tuple[str, ...]) -> None:
    graph = loop(DeadZone(lowest=-1.0, highest=edge))
    assert response(graph, "sum.output", "both.output", at="0 s").notes == notes


def test_a_median_of_equal_numbers_stands_at_a_corner() -> None:
    """Whichever of them is taken moves it: one step is none of its, a constant one is all."""
    assert SAID in margins(loop(MedianFilter(length=3)), at="0 s").system.map.notes
