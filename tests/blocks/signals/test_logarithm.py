"""The logarithm against mpmath, as decibels, and below its smallest input."""

import mpmath
import pytest

from proofmass.blocks import Logarithm
from tests.by_hand.responses import noise, response


def test_against_mpmath() -> None:
    x = [abs(u) + 1e-6 for u in noise(200, 1, 5.0)]
    found = response(Logarithm(base=10.0, scale=20.0, reference=0.5), x)
    assert found == pytest.approx([float(20 * mpmath.log10(mpmath.mpf(u) / 0.5)) for u in x], rel=1e-13, abs=1e-13)


def test_zero_and_less_count_as_the_smallest() -> None:
    assert response(Logarithm(smallest=1e-3), [0.0, -5.0, 1e-4]) == pytest.approx([float(mpmath.log(1e-3))] * 3)
