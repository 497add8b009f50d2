"""Difference: first less second, exactly."""

from hypothesis import given
from hypothesis import strategies as some

from proofmass.blocks import Difference
from tests.by_hand.functions import drive

numbers = some.floats(-1e300, 1e300)


@given(numbers, numbers)
def test_first_less_second(first: float, second: float) -> None:
    assert drive(Difference(unit="V"), [{"first": first, "second": second}]) == [{"output": first - second}]


def test_both_inputs_reach_the_output_at_once() -> None:
    assert Difference.feedthrough("output") == ("first", "second")
