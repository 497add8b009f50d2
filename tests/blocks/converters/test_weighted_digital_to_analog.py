"""The sum of weights against NumPy, and the ideal converter."""

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
