"""The chip counter against the sequence it accompanies."""

import pytest

from proofmass.blocks import ChipCounter, ShiftRegister
from proofmass.blocks.declaration.problem import ModelError
from tests.by_hand.functions import drive


def test_the_window_follows_the_ten_ones_of_the_sequence_by_one_chip() -> None:
    """What the device answers to a chip is read in the next."""
    counted = drive(ChipCounter(), [{}] * 2046)
    bits = [row["bit"] for row in drive(ShiftRegister(), [{}] * 2046)]
    for start in (0, 1023):
        assert all(bits[start : start + 10])
        assert not bits[start + 10]
        assert [n for n in range(1023) if counted[start + n]["window"]] == list(range(1, 11))
    assert [row["chip"] for row in counted] == 2 * list(range(1023))
    assert [n for n, row in enumerate(counted) if row["end"]] == [1022, 2045]


@pytest.mark.parametrize(("values", "expected"), [({"last": 1023}, "less than chips"), ({"first": 11}, "at most last")])
def test_a_window_that_does_not_fit_is_refused(values: dict[str, int], expected: str) -> None:
    with pytest.raises(ModelError, match=expected):
        ChipCounter(**values)
