"""The slots against a written-out timetable."""

import pytest

from proofmass.blocks import MeasurementSlots
from tests.by_hand.functions import drive


def table(block: MeasurementSlots, active: list[bool], period: float = 0.1) -> list[str]:
    rows = drive(block, [{"active": a} for a in active], period)
    marks = {(False, False, False): "-", (True, False, False): "m", (False, True, False): "r", (False, True, True): "f"}
    return [f"{row['slot']}{marks[row['measure'], row['read'], row['finished']]}" for row in rows]


def test_settle_measure_read_again_and_again() -> None:
    block = MeasurementSlots(slots=2, settling=0.2, averaging=0.3)
    row = "0- 0- 0m 0m 0m 0r 1- 1- 1m 1m 1m 1f"
    assert " ".join(table(block, [True] * 24)) == f"{row} {row}"


def test_it_stands_still_while_inactive_and_begins_anew() -> None:
    block = MeasurementSlots(slots=2, settling=0.0, averaging=0.1)
    active = [False, True, True, True, False, True, True, True, True]
    assert table(block, active) == ["0-", "0m", "0r", "1m", "1-", "0m", "0r", "1m", "1f"]


@pytest.mark.parametrize(("period", "ticks"), [(1.0, 1), (0.3, 1), (0.09, 1), (0.06, 2), (0.03, 3), (2e-5, 5000)])
def test_times_are_rounded_to_ticks_and_at_least_one_is_measured(period: float, ticks: int) -> None:
    block = MeasurementSlots(slots=1, settling=0.0, averaging=0.1)
    assert table(block, [True] * (ticks + 1), period) == ["0m"] * ticks + ["0f"]


def test_the_time_to_settle_is_rounded_too() -> None:
    block = MeasurementSlots(slots=1, settling=0.16, averaging=0.1)
    assert table(block, [True] * 4) == ["0-", "0-", "0m", "0f"]
