"""The schedule against a search for the last time that is not after now."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from proofmass.blocks import PiecewiseConstant
from proofmass.blocks.declaration.problem import ModelError
from tests.by_hand.functions import drive


def test_first_value_before_and_last_value_after_the_times() -> None:
    rows = drive(PiecewiseConstant(times=(1.0, 2.0, 4.0), values=(5.0, 6.0, 7.0)), [{}] * 12, period=0.5)
    assert [row["output"] for row in rows] == [5.0] * 4 + [6.0] * 4 + [7.0] * 4


@given(st.lists(st.integers(-5, 60), min_size=1, max_size=20, unique=True), st.integers(1, 10**6))
def test_every_tick_against_the_definition(ticks: list[int], rate: int) -> None:
    ticks = sorted(ticks)
    block = PiecewiseConstant(times=[t / rate for t in ticks], values=[float(t) for t in ticks])
    for tick, row in enumerate(drive(block, [{}] * 50, period=1.0 / rate)):
        assert row["output"] == max((t for t in ticks if t <= tick), default=ticks[0])


def test_output_does_not_wait_for_the_state() -> None:
    rows = drive(PiecewiseConstant(times=(0.0, 0.1, 0.2, 3.0), values=(0.0, 1.0, 2.0, 3.0)), [{}] * 5, period=1.0)
    assert [row["output"] for row in rows] == [0.0, 2.0, 2.0, 3.0, 3.0]


def test_lists_are_read_in_their_units() -> None:
    block = PiecewiseConstant(times=["0 s", "2 ms"], values=["1 mV", 0.5], unit="V")
    assert (block.times, block.values) == ((0.0, 2e-3), (1e-3, 0.5))


def test_lists_that_do_not_go_together_are_refused() -> None:
    with pytest.raises(ModelError, match=r"PiecewiseConstant\.values.*\n.*\n +expected: 2 of them, as many as times"):
        PiecewiseConstant(times=(0.0, 1.0), values=(0.0,))
    with pytest.raises(ModelError, match=r"PiecewiseConstant\.times.*\n.*\n +expected: each after the one before"):
        PiecewiseConstant(times=(0.0, 1.0, 1.0), values=(0.0, 1.0, 2.0))
