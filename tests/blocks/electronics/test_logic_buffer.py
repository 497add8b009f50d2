"""The buffer passes bits on, in the same tick."""

from proofmass.blocks import LogicBuffer
from tests.by_hand.functions import drive


def test_the_same_bit() -> None:
    bits = [True, False, False, True]
    assert [row["output"] for row in drive(LogicBuffer(), [{"input": bit} for bit in bits])] == bits
    assert LogicBuffer.feedthrough("output") == ("input",)
