"""Edges of a bit, counted by hand."""

from proofmass.blocks import EdgeDetector
from tests.by_hand.responses import response

BITS = [bool(int(b)) for b in "0011101000011"]


def test_edges_by_hand() -> None:
    block = EdgeDetector()
    marks = {name: "".join(str(int(b)) for b in response(block, BITS, name)) for name in EdgeDetector.outputs}
    assert marks == {"rising": "0010001000010", "falling": "0000010100000", "either": "0010011100010"}


def test_the_first_tick_depends_on_what_was_before() -> None:
    assert response(EdgeDetector(), [True], "rising") == [True]
    assert response(EdgeDetector(initially_on=True), [True], "rising") == [False]
    assert response(EdgeDetector(initially_on=True), [False], "falling") == [True]
