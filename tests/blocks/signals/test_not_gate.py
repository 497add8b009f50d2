"""The truth table."""

from proofmass.blocks import NotGate
from tests.by_hand.responses import response


def test_truth_table() -> None:
    assert response(NotGate(), [False, True]) == [True, False]
