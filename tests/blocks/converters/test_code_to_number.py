"""Codes stay exact as numbers."""

import pytest

from proofmass.blocks import CodeToNumber
from tests.by_hand.functions import drive


def test_exact_up_to_53_bits() -> None:
    codes = [0, -1, 524287, -(2**31), 2**53]
    rows = drive(CodeToNumber(), [{"code": code} for code in codes])
    assert all(isinstance(row["number"], float) for row in rows)
    assert [int(row["number"]) for row in rows] == codes


@pytest.mark.derivation(
    CodeToNumber,
    equation="number = code",
    source="two's complement read by int.from_bytes",
    convention="a code is signed and counts steps: no scale, no half step",
)
def test_codes_in_twos_complement() -> None:
    words = [b"\x80\x00", b"\xff\xff", b"\x00\x00", b"\x7f\xff"]
    codes = [int.from_bytes(word, "big", signed=True) for word in words]
    rows = drive(CodeToNumber(), [{"code": code} for code in codes])
    assert [row["number"] for row in rows] == [-32768.0, -1.0, 0.0, 32767.0]
