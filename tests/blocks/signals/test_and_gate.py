"""The truth table."""

from itertools import product

from proofmass.blocks import AndGate
from tests.by_hand.functions import drive

NAMES = ("first", "second", "third", "fourth")


def test_truth_table() -> None:
    rows = [dict(zip(NAMES, bits, strict=True)) for bits in product((False, True), repeat=4)]
    assert [row["output"] for row in drive(AndGate(), rows)] == [sum(row.values()) == 4 for row in rows]


def test_inputs_that_are_not_wired_change_nothing() -> None:
    assert [AndGate.inputs[name].default for name in NAMES] == [None, None, 1.0, 1.0]
