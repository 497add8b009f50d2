"""The counter: exact where periods are whole ticks, and its resolution where they are not."""

import numpy as np
import pytest

from proofmass.blocks import FrequencyCounter
from tests.by_hand.functions import drive

PERIOD = 1e-5


def counted(frequency: float, **parameters: bool | float) -> list[tuple[int, float]]:
    bits = [bool(np.sin(2.0 * np.pi * frequency * PERIOD * n + 0.1) >= 0.0) for n in range(50_000)]
    rows = drive(FrequencyCounter(**parameters), [{"signal": bit} for bit in bits], PERIOD)
    finished = {row["measurements"]: row["frequency"] for row in rows}
    return [(number, finished[number]) for number in sorted(finished)]


def test_whole_ticks_are_counted_exactly() -> None:
    (_, first), *rest = counted(1000.0)
    assert first == 0.0
    assert len(rest) in (49, 50)
    assert [value for _, value in rest] == pytest.approx([1000.0] * len(rest), rel=1e-12)


@pytest.mark.parametrize("frequency", [876.5, 3333.3, 12_345.6])
def test_a_reciprocal_count_is_right_to_a_tick(frequency: float) -> None:
    values = np.array([value for _, value in counted(frequency)[1:]])
    assert np.abs(values / frequency - 1.0).max() <= PERIOD / 0.01
    assert values.mean() == pytest.approx(frequency, rel=2e-5)


def test_a_gated_count_is_right_to_an_edge() -> None:
    values = np.array([value for _, value in counted(3333.3, reciprocal=False)[1:]])
    assert set(np.round(values, 6)) == {3300.0, 3400.0}
    assert len(values) in (49, 50)


def test_a_signal_that_stands_still_is_never_finished() -> None:
    assert counted(0.0) == [(0, 0.0)]
