"""Derivatives of margins of loops through carriers: those of a whole turn, in closed form."""

import math

import pytest

from proofmass.blocks import (
    ChopperModulator,
    Constant,
    Difference,
    DiscreteTransferFunction,
    Gain,
    Product,
    RepeatingSequence,
    Sine,
    Sum,
    UnitDelay,
)
from proofmass.blocks.declaration.declare import Block
from proofmass.graphs.model.build import Graph
from tests.by_hand.amounts import chosen
from tests.runner.analysis.margins.test_sensitivity import loop_margins, slopes


def through_carriers(between: dict[str, Block], wires: list[str]) -> Graph:
    """A loop of a pole and a delay, from `gain.output` through what lies between to `pole.input`."""
    blocks: dict[str, Block] = {
        "zero": Constant(value=0.0),
        "error": Difference(),
        "gain": Gain(gain=0.5),
        "pole": DiscreteTransferFunction(numerator=(1.0,), denominator=(1.0, -0.9)),
        "delay": UnitDelay(),
    }
    around = ["zero.output -> error.first", "delay.output -> error.second", "error.output -> gain.input"]
    around += ["pole.strictly_proper_part -> delay.input"]
    return Graph(name="carriers", rate="1 kHz", samples=64, blocks=blocks | between, wires=around + wires)


@pytest.mark.defect("S824", before="4.9 dB per radian of a phase, -5.1 of an offset: those of one tick", after="none")
@pytest.mark.parametrize("phase", chosen([0.3], [0.0]))
def test_margins_on_carriers_move_as_in_a_whole_turn(phase: float) -> None:
    """A^2 sin^2 + cos^2 is one in each tick if A is one, and (A^2 + 1) / 2 on average: 1 / A of a margin by A."""
    sine, cosine = (Sine(frequency=125.0, amplitude=1.0, phase=phase + turn) for turn in (0.0, 0.5 * math.pi))
    products = {name: Product() for name in "abcd"}
    between = {"sine": sine, "cosine": cosine, "sum": Sum(), **products}
    wires = [
        "gain.output -> a.first", "sine.output -> a.second", "a.output -> b.first", "sine.output -> b.second",
        "gain.output -> c.first", "cosine.output -> c.second", "c.output -> d.first", "cosine.output -> d.second",
        "b.output -> sum.first", "d.output -> sum.second", "sum.output -> pole.input",
    ]  # fmt: skip
    by_gain, *_ = loop_margins(through_carriers(between, wires), "delay.output")
    found = slopes(by_gain)
    assert found["sine.amplitude"] == pytest.approx(-20.0 / math.log(10.0))
    assert found["gain.gain"] == pytest.approx(2.0 * found["cosine.amplitude"])
    for name in ("sine.phase", "cosine.phase", "sine.offset", "cosine.offset"):
        assert found.get(name, 0.0) == pytest.approx(0.0, abs=1e-9)


@pytest.mark.defect("S851", before="-8.7 dB per unit, that of one tick, where a chopper makes the chips", after="none")
@pytest.mark.parametrize(
    ("chips", "port"),
    [
        (RepeatingSequence(values=(1.0,) * 4 + (-1.0,) * 4), "output"),
        (ChopperModulator(half_period=4, unit="1"), "square"),  # of which no parameter moves a margin
    ],
)
def test_an_offset_behind_a_chopper_moves_no_margin(chips: Block, port: str) -> None:
    """(chips + offset) chips is 1 + offset chips: the chips are as often negative as positive."""
    between = {"chips": chips, "offset": Constant(value=0.0), "sum": Sum(), "up": Product(), "down": Product()}
    wires = [
        f"chips.{port} -> sum.first", "offset.output -> sum.second", "gain.output -> up.first",
        "sum.output -> up.second", "up.output -> down.first", f"chips.{port} -> down.second",
        "down.output -> pole.input", *(["zero.output -> chips.input"] if port == "square" else []),
    ]  # fmt: skip
    found = slopes(loop_margins(through_carriers(between, wires), "delay.output")[0])
    assert found["gain.gain"] == pytest.approx(-40.0 / math.log(10.0))
    assert found.get("offset.value", 0.0) == pytest.approx(0.0, abs=1e-9)
