"""The damping controller: sums of the named lags, at once, never below its lowest."""

import pytest

from proofmass.blocks import DampingController
from proofmass.blocks.declaration.problem import ModelError
from tests.by_hand.functions import drive

MEASURED, MODELLED = [0.0, 6.0, 1.0, 0.5], [9.0, 6.5, 1.25, 0.75]


@pytest.mark.parametrize(("first", "last", "error"), [(1, 1, 0.5), (1, 3, 1.0), (2, 3, 0.5), (0, 0, 9.0)])
def test_the_error_of_the_lags_moves_the_damping_in_the_same_tick(first: int, last: int, error: float) -> None:
    block = DampingController(initial=2.0, gain=0.25, cells=4, first=first, last=last)
    rows = drive(block, [{"measured": MEASURED, "modelled": MODELLED}] * 3)
    assert [row["damping"] for row in rows] == [2.0 + 0.25 * error * n for n in (1, 2, 3)]
    assert DampingController.feedthrough("damping") == ("measured", "modelled")


def test_the_damping_stays_above_its_lowest_and_comes_back() -> None:
    block = DampingController(initial=2.0, gain=-3.0, lowest=0.125, cells=4)
    down, up = {"measured": MEASURED, "modelled": MODELLED}, {"measured": MODELLED, "modelled": MEASURED}
    assert [row["damping"] for row in drive(block, [down, down, up])] == [0.5, 0.125, 1.625]
    block = DampingController(initial=2.0, gain=-3.875, lowest=0.125, cells=4)  # to 0.0625, which is above zero
    assert [row["damping"] for row in drive(block, [down])] == [0.125]


@pytest.mark.parametrize(
    ("values", "expected"), [({"last": 16}, "less than cells"), ({"first": 2}, "at most last = 1")]
)
def test_lags_that_do_not_fit_are_refused(values: dict[str, int], expected: str) -> None:
    with pytest.raises(ModelError, match=expected):
        DampingController(**values)
