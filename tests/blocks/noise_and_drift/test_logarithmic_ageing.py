"""Logarithmic ageing against the logarithm."""

import mpmath
import pytest

from proofmass.blocks import LogarithmicAgeing
from tests.by_hand.functions import drive


@pytest.mark.parametrize("start_age", ["0 s", "1 h", "10 year", "1000 year"])
@pytest.mark.parametrize("period", [1e-6, 1.0, 1e6])
def test_against_the_logarithm(start_age: str, period: float) -> None:
    block = LogarithmicAgeing(rate_per_decade="-15 ppm", onset="2 d", start_age=start_age, nominal=5.0, unit="V")
    for tick, row in enumerate(drive(block, [{}] * 20, period=period)):
        age = mpmath.mpf(block.start_age + tick * period)
        expected = float(-15e-6 * mpmath.log1p(age / 172800) / mpmath.log(10))
        assert row["deviation"] == pytest.approx(expected, rel=2e-15)
        assert row["value"] == 5.0 * (1.0 + row["deviation"])


def test_so_much_per_decade_of_age() -> None:
    ages = [99.0, 999.0, 9999.0]
    blocks = [LogarithmicAgeing(rate_per_decade=1e-3, onset=1.0, start_age=age) for age in ages]
    assert [drive(block, [{}])[0]["deviation"] for block in blocks] == pytest.approx([2e-3, 3e-3, 4e-3], rel=1e-14)
