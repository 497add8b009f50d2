"""The step: on for ever or for a duration, with edges on the tick that the times say."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from proofmass.blocks import Step
from proofmass.blocks.declaration.problem import ModelError
from tests.by_hand.functions import drive


def test_for_ever_without_a_duration() -> None:
    rows = drive(Step(amplitude=3.0, offset=1.0, start_time=0.5), [{}] * 20, period=0.25)
    assert [row["output"] for row in rows] == [1.0] * 2 + [4.0] * 18


def test_back_after_the_duration() -> None:
    rows = drive(Step(amplitude=-2.0, start_time=0.5, duration=0.75), [{}] * 10, period=0.25)
    assert [row["output"] for row in rows] == [0.0] * 2 + [-2.0] * 3 + [0.0] * 5


@given(st.integers(0, 10**6), st.integers(1, 10**6), st.integers(1, 10**6))
def test_edges_fall_on_the_tick_that_a_decimal_time_means(first: int, length: int, thousands: int) -> None:
    period = 1.0 / thousands
    block = Step(start_time=first / thousands, duration=length / thousands)
    constants = Step.functions["constants"].function(block, period)
    step = Step.output_functions["output"].function
    ticks = (first - 1, first, first + length - 1, first + length)
    assert [step(constants, tick * period) for tick in ticks] == [0.0, 1.0, 1.0, 0.0]


def test_a_negative_duration_is_refused() -> None:
    with pytest.raises(ModelError, match=r"Step\.duration: must be >= 0"):
        Step(duration=-1.0)
