"""The patterns, letter by letter."""

import pytest

from proofmass.blocks import SwitchPattern
from tests.by_hand.functions import drive


@pytest.mark.parametrize(("palindrome", "letters"), [(False, "ABABABABAB"), (True, "ABBAABBAAB")])
def test_pattern(palindrome: bool, letters: str) -> None:
    rows = drive(SwitchPattern(palindrome=palindrome), [{"slot": n, "active": True} for n in range(10)])
    assert "".join("A" if row["on"] else "B" for row in rows) == letters


def test_off_outside_measurements() -> None:
    rows = drive(SwitchPattern(), [{"slot": n, "active": False} for n in range(4)])
    assert not any(row["on"] for row in rows)
