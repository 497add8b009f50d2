"""A geometric series of phasors against the sum of its terms."""

import cmath
import math

import pytest

from proofmass.blocks.arithmetic.geometric_series import summed


@pytest.mark.parametrize("n", [1, 16, 17, 256])
@pytest.mark.parametrize("turns", [0.0, 1e-9, -1.0 / 256.0, 1.5 / 16.0, 0.25, 0.4999, 0.5, 1.0, 2.3])
def test_it_is_the_sum_of_its_terms(turns: float, n: int) -> None:
    terms = sum(cmath.exp(-2j * math.pi * (turns * i % 1.0)) for i in range(n))
    assert abs(complex(*summed(turns, n)) - terms) < 1e-13 * n
