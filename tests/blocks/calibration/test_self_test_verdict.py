"""The verdict for every combination of what it is made of."""

import itertools

from proofmass.blocks import SelfTestVerdict
from tests.by_hand.functions import drive


def test_every_combination() -> None:
    cases = list(itertools.product((False, True), (False, True), (0.0, 7.9e-3, 8.0e-3, 1.0)))
    rows = drive(SelfTestVerdict(), [{"inside": i, "settled": s, "residual": r} for i, s, r in cases])
    assert [row["trusted"] for row in rows] == [s and r < 8e-3 for _, s, r in cases]
    assert [row["passes"] for row in rows] == [all((i, s, r < 8e-3)) for i, s, r in cases]
    assert sum(row["passes"] for row in rows) == 2
