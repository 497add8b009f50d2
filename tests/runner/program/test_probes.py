"""Vectors that are recorded: truth values, and registers that a converter of one's own fills."""

from typing import Any

import numpy as np
import pytest

from proofmass.blocks import Sine
from proofmass.blocks.arithmetic.fixed_point import Fixed, FixedValue
from proofmass.blocks.declaration.declare import Block, Input
from proofmass.graphs.model.build import Graph
from proofmass.runner.run.simulate import simulate


class Flags(Block):
    """Whether a number is above zero and above one."""

    input = Input("1", "Number that is compared.")


@Flags.output("1", shape=(2,), dtype=bool)
def above(p: Any, input: float, out: list[bool]) -> None:
    """Above zero, above one."""
    out[0] = input > 0.0
    out[1] = input > 1.0


class TwoRegisters(Block):
    """A number in steps of a quarter, and its negative."""

    input = Input("1", "Number that is taken.")


@TwoRegisters.formats
def formats(p: Any) -> dict[str, Fixed]:
    return {"registers": Fixed(4, 2)}


@TwoRegisters.output("1", shape=(2,), dtype=FixedValue)
def registers(p: Any, input: float, out: list[int]) -> None:
    """The mantissas."""
    out[0] = int(4.0 * input)
    out[1] = -int(4.0 * input)


@pytest.mark.parametrize("engine", ["python", "compiled"])
def test_vectors_are_recorded_by_their_type(engine: Any) -> None:
    blocks = {"sine": Sine(amplitude=1.5, frequency=50.0), "flags": Flags(), "pair": TwoRegisters()}
    wires = ["sine.output -> flags.input", "sine.output -> pair.input"]
    probes = ["sine.output", "flags.above", "pair.registers"]
    result = simulate(
        Graph(name="", rate="1 kHz", blocks=blocks, wires=wires, probes=probes), samples=40, engine=engine
    )
    x = np.asarray(result["sine.output"].values)
    flags = result["flags.above"].values
    assert flags.dtype == np.bool_
    assert flags.tolist() == np.stack([x > 0.0, x > 1.0], axis=1).tolist()
    steps = np.trunc(4.0 * x) / 4.0
    assert result["pair.registers"].values.tolist() == np.stack([steps, -steps], axis=1).tolist()
