"""The detector's mean is a straight line in the phase difference, zero in quadrature."""

import math

import pytest

from proofmass.blocks import XorPhaseDetector
from tests.by_hand.responses import responses


@pytest.mark.derivation(
    XorPhaseDetector,
    equation="output = level if the bits differ, else -level; its mean is level (2 |d| / pi - 1)",
    source="overlap of two square waves, counted over two periods",
    convention="from -level to level, half the swing; 2 level / pi per rad; zero in quadrature",
)
@pytest.mark.parametrize("late", [0, 50, 100, 250, 400, 500])
def test_its_mean_against_the_closed_form(late: int) -> None:
    """Square waves of 1000 ticks, one `late` ticks behind the other."""
    first = [n % 1000 < 500 for n in range(2000)]
    second = [(n - late) % 1000 < 500 for n in range(2000)]
    answer = responses(XorPhaseDetector(level=2.5), first=first, second=second)
    difference = 2.0 * math.pi * late / 1000.0
    assert math.fsum(answer) / 2000.0 == pytest.approx(2.5 * (2.0 * difference / math.pi - 1.0), abs=1e-12)
