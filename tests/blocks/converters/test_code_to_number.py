"""Codes stay exact as numbers."""

from proofmass.blocks import CodeToNumber
from tests.by_hand.functions import drive


def test_exact_up_to_53_bits() -> None:
    codes = [0, -1, 524287, -(2**31), 2**53]
    rows = drive(CodeToNumber(), [{"code": code} for code in codes])
    assert all(isinstance(row["number"], float) for row in rows)
    assert [int(row["number"]) for row in rows] == codes
