"""The sum of weights against NumPy, and the ideal converter."""

from fractions import Fraction

import numpy as np
import pytest

from proofmass.blocks import DigitalToAnalog, WeightedDigitalToAnalog
from proofmass.blocks.arithmetic.bit_weights import bit_weights
from proofmass.blocks.declaration.problem import ModelError
from tests.by_hand.responses import noise, response


def test_without_errors_it_is_the_ideal_converter() -> None:
    numbers = [*noise(300, 1, 800.0), 0.5, 1.5, -1e9, 1e9]
    found = response(WeightedDigitalToAnalog(bits=12), numbers, "voltage", "number")
    assert found == response(DigitalToAnalog(bits=12), numbers, "voltage", "number")


@pytest.mark.parametrize("mismatch", [0.0, 0.02])
def test_every_code_against_its_bits(mismatch: float) -> None:
    errors = (0.01, -0.03, 0.02)
    block = WeightedDigitalToAnalog(bits=6, reference=1.0, bit_errors=errors, mismatch=mismatch, device=7)
    codes = np.arange(-32, 32)
    bits = (codes[:, None] + 32) >> np.arange(5, -1, -1) & 1
    weights = np.array(bit_weights(6, errors, mismatch, 7))
    if not mismatch:
        assert weights == pytest.approx([32 * 1.01, 16 * 0.97, 8 * 1.02, 4, 2, 1])
    expected = (bits @ weights - 32.0) / 32.0
    found = response(block, codes.astype(float).tolist(), "voltage", "number")
    assert found == pytest.approx(expected, rel=1e-12, abs=1e-15)


def test_too_many_errors_are_refused() -> None:
    with pytest.raises(ModelError, match="at most 3 numbers"):
        WeightedDigitalToAnalog(bits=3, bit_errors=(0.0,) * 4)


@pytest.mark.derivation(
    WeightedDigitalToAnalog,
    equation="voltage = (sum of b_i w_i - 2^(bits-1)) reference / 2^(bits-1), w_i = 2^i (1 + error_i)",
    source="2^bits - 1 sources of current into one node, each by itself, in exact fractions",
    convention="reference is half the span; errors are of a bit, not of a step: 1 % of the highest of 8 is 1.28 steps",
)
def test_a_sum_of_unit_sources() -> None:
    errors = (Fraction(1, 100), Fraction(-3, 200), Fraction(1, 50), *[Fraction(0)] * 5)
    units = [[1 + error] * 2 ** (7 - i) for i, error in enumerate(errors)]
    block = WeightedDigitalToAnalog(bits=8, reference=5.0, bit_errors=tuple(float(error) for error in errors))
    codes = [-128, -1, 0, 31, 32, 127]
    found = response(block, [float(code) for code in codes], "voltage", "number")
    for code, voltage in zip(codes, found, strict=True):
        on = sum(sum(source) for i, source in enumerate(units) if (code + 128) >> (7 - i) & 1)
        assert voltage == pytest.approx(float((on - 128) * Fraction(10, 256)), rel=1e-12)
    step = (found[2] - found[1]) / (10.0 / 256.0)
    assert step == pytest.approx(1.0 + 128 * 0.01 + 64 * 0.015 - 32 * 0.02, rel=1e-9)
