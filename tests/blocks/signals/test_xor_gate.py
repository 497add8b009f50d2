"""The truth table."""

from proofmass.blocks import XorGate
from tests.by_hand.responses import responses


def test_truth_table() -> None:
    first, second = [False, False, True, True], [False, True, False, True]
    assert responses(XorGate(), first=first, second=second) == [False, True, True, False]
