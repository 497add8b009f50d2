"""Words of the memory against rounded coefficients."""

import pytest

from proofmass.blocks import FixedCoefficientMemory
from proofmass.blocks.arithmetic.fixed_point import Fixed
from proofmass.blocks.declaration.instance import unit_of
from tests.by_hand.cordic import scaled
from tests.by_hand.fixed_point import drive_fixed

LAW = {"a1": 0.17604176, "b1": -5.9936064, "a2": -0.00032113697, "b2": 1.5061774}
OUTPUTS = ("first_factor", "first_exponent", "second_factor", "second_exponent")


@pytest.mark.parametrize("growth", [1.0, 0.8281593609920])
@pytest.mark.parametrize(("factor_bits", "exponent_bits"), [(24, 16), (16, 12)])
def test_words_are_rounded_coefficients(growth: float, factor_bits: int, exponent_bits: int) -> None:
    block = FixedCoefficientMemory(
        **LAW, growth=growth, factor_format=Fixed(30, factor_bits), exponent_format=Fixed(20, exponent_bits)
    )
    (row,) = drive_fixed(block, [{}])
    assert [row[name] for name in OUTPUTS] == [
        scaled(LAW["a1"] / growth, factor_bits),
        scaled(LAW["b1"], exponent_bits),
        scaled(LAW["a2"] / growth, factor_bits),
        scaled(LAW["b2"], exponent_bits),
    ]


def test_units_follow_the_temperature() -> None:
    block = FixedCoefficientMemory(temperature_unit="K", unit="mV")
    assert unit_of(block, type(block).outputs["first_exponent"]) == "1/(K)"
    assert unit_of(block, type(block).outputs["second_factor"]) == "mV"
