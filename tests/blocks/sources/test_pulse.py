"""The rectangular wave against its definition in whole ticks."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from proofmass.blocks import Pulse
from proofmass.blocks.declaration.problem import ModelError
from proofmass.blocks.sources.pulse import edges
from tests.by_hand.functions import drive


def test_high_for_the_duty_and_low_before_the_delay() -> None:
    block = Pulse(amplitude=5.0, offset=-1.0, repetition=2.0, duty=0.25, delay=1.0)
    rows = drive(block, [{}] * 24, period=0.25)
    assert [row["output"] for row in rows] == [-1.0] * 4 + ([4.0] * 2 + [-1.0] * 6) * 2 + [4.0] * 2 + [-1.0] * 2


@given(st.integers(2, 500), st.integers(0, 500), st.integers(0, 300), st.integers(1, 10**6), st.integers(0, 10**6))
def test_edges_fall_on_whole_ticks(length: int, high: int, delay: int, rate: int, tick: int) -> None:
    high, period = min(high, length), 1.0 / rate
    block = Pulse(repetition=length / rate, duty=high / length, delay=delay / rate)
    constants = Pulse.functions["constants"].function(block, period)
    expected = 1.0 if tick >= delay and (tick - delay) % length < high else 0.0
    assert Pulse.output_functions["output"].function(constants, tick * period) == expected


@given(st.integers(2, 500), st.integers(0, 500), st.integers(0, 300), st.integers(1, 10**6), st.integers(0, 10**6))
def test_edges_are_counted(length: int, high: int, delay: int, rate: int, tick: int) -> None:
    """None before the delay; then one where each pulse begins and one where it ends, also of a pulse of no length."""
    high, period = min(high, length), 1.0 / rate
    block = Pulse(repetition=length / rate, duty=high / length, delay=delay / rate)
    constants = Pulse.functions["constants"].function(block, period)
    turns, ticks = divmod(tick - delay, length)
    assert edges(constants, tick * period) == (0 if tick < delay else 2 * turns + (1 if ticks < high else 2))


def test_a_repetition_too_short_to_count_does_not_stop_a_run() -> None:
    assert [row["output"] for row in drive(Pulse(repetition=1e-300, duty=1.0), [{}] * 3)][1:] in ([0.0] * 2, [1.0] * 2)


def test_a_duty_beyond_one_is_refused() -> None:
    with pytest.raises(ModelError, match=r"Pulse\.duty: must be >= 0 and <= 1"):
        Pulse(duty="101 %")
