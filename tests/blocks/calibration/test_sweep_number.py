"""The sweep of the paper: 4000, 5000 ... 14000."""

from proofmass.blocks import SweepNumber
from tests.by_hand.functions import drive


def test_eleven_points_and_the_working_number() -> None:
    ticks = [{"slot": n, "active": n < 11} for n in range(12)]
    found = [row["number"] for row in drive(SweepNumber(), ticks)]
    assert found == [*range(4000, 14001, 1000), 34952.0]
