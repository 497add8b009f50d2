"""The controller against big integers, against PID in floating point, and at the range of its output."""

import math
from fractions import Fraction

import numpy as np
import pytest

from proofmass.blocks import PID, FixedPID
from proofmass.blocks.arithmetic.fixed_point import Fixed
from tests.by_hand.fixed_point import ROUNDINGS, cast, drive_fixed, value_of, words
from tests.by_hand.functions import drive

PERIOD = 1.0 / 50e3
ERROR, GAIN, SUM, OUT = Fixed(16, 12), Fixed(24, 20), Fixed(24, 18), Fixed(14, 11)
PARAMETERS = {"proportional": 0.8, "integral": 4000.0, "derivative_gain": 3e-5, "derivative_pole": 1500.0}


def gains() -> list[float]:
    decay = math.exp(-2.0 * math.pi * 1500.0 * PERIOD)
    return [0.8, 4000.0 * PERIOD, 3e-5 / PERIOD * (1.0 - decay), decay]


@pytest.mark.exhaustive(but=1)
@pytest.mark.parametrize("overflow", ["saturate", "wrap"])
@pytest.mark.parametrize("rounding", ROUNDINGS)
def test_against_big_integers(rounding: str, overflow: str) -> None:
    block = FixedPID(**PARAMETERS, sum_format=SUM, output_format=OUT, rounding=rounding, overflow=overflow)
    kp, ki, kd, a = (Fraction(round(Fraction(g) * 2**20), 2**20) for g in gains())
    lowest, highest = (value_of(m, OUT) for m in (OUT.lowest, OUT.highest))
    errors = [m // 4 + 2000 * (1 if i // 150 % 2 else -1) for i, m in enumerate(words(ERROR, 600))]
    total = slope = before = Fraction(0)
    expected, kept = [], 0
    for m in errors:
        e = value_of(m, ERROR)
        moved = value_of(cast(total + ki * e, SUM, rounding, overflow), SUM)
        slope = value_of(cast(a * slope + kd * (e - before), SUM, rounding, overflow), SUM)
        wanted = kp * e + moved + slope
        expected.append(cast(wanted, OUT, rounding, overflow))
        winds_up = (wanted > highest and moved > total) or (wanted < lowest and moved < total)
        kept += winds_up
        total = total if winds_up and overflow == "saturate" else moved
        before = e
    rows = drive_fixed(block, [{"error": m} for m in errors], PERIOD)
    assert [row["output"] for row in rows] == expected
    assert kept > 30


@pytest.mark.parametrize(("error", "end"), [(-1, -8), (1, 7)])
def test_the_integral_reaches_the_end_of_the_range_and_leaves_it_at_once(error: int, end: int) -> None:
    whole = Fixed(4, 0)
    formats = {"input_format": whole, "output_format": whole, "gain_format": Fixed(8, 0), "sum_format": Fixed(8, 0)}
    block = FixedPID(proportional=0.0, integral=1.0, derivative_gain=0.0, **formats)
    rows = drive_fixed(block, [{"error": error}] * 12 + [{"error": -error}] * 3, 1.0)
    assert [row["output"] for row in rows[-4:]] == [end, end - error, end - 2 * error, end - 3 * error]


def test_against_the_controller_in_floating_point_and_at_its_limits() -> None:
    fine = {"gain_format": Fixed(30, 28), "sum_format": Fixed(32, 27), "output_format": Fixed(28, 26)}
    block = FixedPID(**PARAMETERS, **fine)
    sibling = PID(**PARAMETERS, limited=True, lowest=-2.0, highest=2.0 - 2.0**-26)
    errors = np.repeat([1200, -2000, 3600, -400, -3600, 160], 60).tolist()
    found = [row["output"] / 2**26 for row in drive_fixed(block, [{"error": m} for m in errors], PERIOD)]
    expected = [row["output"] for row in drive(sibling, [{"error": m / 4096} for m in errors], PERIOD)]
    assert found == pytest.approx(expected, abs=1e-5)
    assert max(found) == 2.0 - 2.0**-26
