"""The delay against a list that is shifted, for several lengths and formats."""

import pytest

from proofmass.blocks import FixedDelay
from proofmass.blocks.arithmetic.fixed_point import Fixed
from tests.by_hand.fixed_point import drive_fixed, words


@pytest.mark.exhaustive(but=4)
@pytest.mark.parametrize("ticks", [1, 2, 18, 256])
@pytest.mark.parametrize("format", [Fixed(16, 12), Fixed(8), Fixed(12, 4, signed=False)], ids=str)
def test_the_input_so_many_ticks_before(format: Fixed, ticks: int) -> None:
    inputs = words(format, 300)
    rows = drive_fixed(FixedDelay(format=format, ticks=ticks), [{"input": m} for m in inputs])
    assert [row["output"] for row in rows] == ([0] * ticks + inputs)[:300]
