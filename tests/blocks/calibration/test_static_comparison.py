"""The three outputs of the paper's Fig. 13 and their differences."""

from proofmass.blocks import StaticComparison
from tests.by_hand.functions import drive


def test_errors_appear_with_the_second_and_the_third_test() -> None:
    responses = [7.0, 1000.0, 7.0, 1193.0, 7.0, 1024.0, 1001.0]
    reads = [False, True, False, True, False, True, True]
    ticks = [{"response": u, "read": b} for u, b in zip(responses, reads, strict=True)]
    rows = drive(StaticComparison(), [*ticks, {"response": 0.0, "read": False}])
    assert [row["reference"] for row in rows] == [0.0, 0.0] + [1000.0] * 6
    assert [row["uncompensated_error"] for row in rows] == [0.0] * 4 + [193.0] * 4
    assert [row["compensated_error"] for row in rows] == [0.0] * 6 + [24.0, 1.0]
