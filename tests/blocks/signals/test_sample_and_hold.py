"""The sample and hold follows and keeps."""

from proofmass.blocks import SampleAndHold
from tests.by_hand.functions import drive


def outputs(block: SampleAndHold, holds: list[bool]) -> list[float]:
    rows = drive(block, [{"signal": float(n + 1), "hold": hold} for n, hold in enumerate(holds)])
    return [row["output"] for row in rows]


def test_it_keeps_the_last_value_before_the_hold() -> None:
    assert outputs(SampleAndHold(), [False, False, True, True, False, True]) == [1.0, 2.0, 2.0, 2.0, 5.0, 5.0]


def test_held_from_the_start_it_gives_the_initial_value() -> None:
    assert outputs(SampleAndHold(initial=-4.0), [True, True, False, True]) == [-4.0, -4.0, 3.0, 3.0]
