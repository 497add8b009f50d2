"""The latch: transparent while it is enabled."""

from proofmass.blocks import DataLatch
from tests.by_hand.responses import responses


def test_it_follows_and_keeps() -> None:
    data = [bool(int(b)) for b in "10110100"]
    enable = [bool(int(b)) for b in "00101100"]
    answer = responses(DataLatch(), data=data, enable=enable)
    assert answer == [bool(int(b)) for b in "00110111"]
    assert responses(DataLatch(initially_on=True), data=[False], enable=[False]) == [True]
