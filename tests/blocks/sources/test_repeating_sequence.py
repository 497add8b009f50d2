"""The sequence against the list it plays."""

import pytest

from proofmass.blocks import RepeatingSequence
from proofmass.blocks.declaration.problem import ModelError
from tests.by_hand.functions import drive


@pytest.mark.parametrize("values", [(7.0,), (1.0, 2.0, 3.0), (0.0, -1.0)])
def test_it_plays_the_list_over_and_over(values: tuple[float, ...]) -> None:
    rows = drive(RepeatingSequence(values=values), [{}] * 8, period=0.5)
    assert [row["output"] for row in rows] == [values[i % len(values)] for i in range(8)]


def test_values_are_read_in_their_unit() -> None:
    assert RepeatingSequence(values=["1 mV", 0.5], unit="V").values == (1e-3, 0.5)


def test_an_empty_list_is_refused() -> None:
    with pytest.raises(ModelError, match=r"RepeatingSequence\.values: must not be empty"):
        RepeatingSequence(values=())
