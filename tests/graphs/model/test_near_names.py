"""Ports that may be joined have one unit, one type and one number of axes; wires that are written as lists."""

import pytest

from proofmass.blocks import AnalogToDigital, Comparator, Gain, ImpulseResponseEstimator
from proofmass.blocks.declaration.declare import Block
from proofmass.blocks.declaration.problem import Refusal
from proofmass.graphs.model.build import read_wire
from proofmass.graphs.model.near_names import _ends, _fit

BLOCKS: dict[str, Block] = {
    "volts": Gain(output_unit="V"),
    "amperes": Gain(input_unit="A"),
    "adc": AnalogToDigital(),
    "comparator": Comparator(unit="V"),
    "cells": ImpulseResponseEstimator(unit="V"),
}


@pytest.mark.parametrize(
    ("source", "target", "joined"),
    [
        ("volts.output", "adc.voltage", True),
        ("volts.output", "cells.response", True),
        ("volts.output", "amperes.input", False),
        ("comparator.on", "cells.response", False),
        ("cells.impulse_response", "adc.voltage", False),
    ],
)
def test_what_fits(source: str, target: str, joined: bool) -> None:
    (one,), (other,) = _ends(source, BLOCKS, 0), _ends(target, BLOCKS, 1)
    assert _fit(one, other) == joined


@pytest.mark.parametrize(
    ("wire", "cure"),
    [
        (["a.output", "b.input"], 'write "a.output -> b.input"'),
        (["a.output", "no signal"], 'write "block.output -> block.input"'),
        ([], 'write "block.output -> block.input"'),
        ({"from": "a.output", "to": "b.input"}, 'write "a.output -> b.input"'),
        ({"to": "b.input", "from": "a.output"}, 'write "a.output -> b.input"'),
        ({"from": "a.output"}, 'write "block.output -> block.input"'),
        ({"from": 1, "to": 2}, 'write "block.output -> block.input"'),
        ({1: "a.output", None: "b.input"}, 'write "a.output -> b.input"'),
    ],
)
def test_a_wire_of_two_texts_is_written_as_one_where_both_are_signals(wire: object, cure: str) -> None:
    with pytest.raises(Refusal, match="not a wire") as refusal:
        read_wire(wire)
    assert refusal.value.hint == cure
