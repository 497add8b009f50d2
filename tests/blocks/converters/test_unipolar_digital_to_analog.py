"""The unipolar converter against exact fractions."""

from fractions import Fraction

import pytest

from proofmass.blocks import UnipolarDigitalToAnalog
from tests.by_hand.functions import drive
from tests.by_hand.ladder import ladder


def test_half_of_20_bits_is_2_5_volt() -> None:
    """N_VREF 524288 of the digital quartz accelerometer [A]."""
    (row,) = drive(UnipolarDigitalToAnalog(), [{"number": 524288.0}])
    assert row == {"code": 524288, "voltage": 2.5}


def test_every_code_of_8_bits_rounding_and_saturation() -> None:
    block = UnipolarDigitalToAnalog(bits=8, reference=1.0 / 3.0)
    numbers = [n + part for n in range(-2, 260) for part in (-0.5, -0.25, 0.0, 0.25)]
    for number, row in zip(numbers, drive(block, [{"number": n} for n in numbers]), strict=True):
        code = min(max(round(Fraction(number)), 0), 255)
        assert row["code"] == code
        assert row["voltage"] == float(code * Fraction(1.0 / 3.0) / 256)


def test_a_step_of_16_bits_is_30_5_ppm_of_half_the_span() -> None:
    """Why DA0 needs more than 16 bits: eq. 30 of the paper corrects in these steps."""
    low, high = drive(UnipolarDigitalToAnalog(bits=16), [{"number": 32768.0}, {"number": 32769.0}])
    assert abs(high["voltage"] / low["voltage"] - 1.0 - 1.0 / 32768.0) < 1e-15


@pytest.mark.derivation(
    UnipolarDigitalToAnalog,
    equation="voltage = clip(rint(number)) reference / 2^bits",
    source="R-2R ladder in plain binary between 0 and reference, by Kirchhoff's laws",
    convention="reference is the whole span, the voltage of the code 2^bits, one step above the highest",
)
def test_an_r_2r_ladder_to_ground() -> None:
    codes = [0, 1, 127, 128, 200, 255]
    expected = [ladder(8, code, 3.3, 0.0) for code in codes]
    found = drive(UnipolarDigitalToAnalog(bits=8, reference=3.3), [{"number": float(code)} for code in codes])
    assert [row["voltage"] for row in found] == pytest.approx(expected, abs=1e-14)
