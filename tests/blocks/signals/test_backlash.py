"""The play of a gear: by hand, and its describing function against the closed form."""

import cmath
import math

import pytest

from proofmass.blocks import Backlash
from tests.by_hand.responses import response


def test_by_hand() -> None:
    signal = [0.0, 0.5, 1.0, 3.0, 2.5, 1.75, 1.0, -2.0, -1.5, -0.5, 0.25]
    expected = [0.0, 0.0, 0.0, 2.0, 2.0, 2.0, 2.0, -1.0, -1.0, -1.0, -0.75]
    assert response(Backlash(width=2.0), signal) == expected


@pytest.mark.exhaustive("0.5")
@pytest.mark.parametrize("part", [0.1, 0.5, 0.8])
def test_the_fundamental_of_its_response_to_a_sine(part: float) -> None:
    """Half the width over the amplitude is `part`; Gelb and Vander Velde, appendix B: friction-controlled backlash."""
    points = 20_000
    swing = [math.sin(2.0 * math.pi * n / points) for n in range(2 * points)]
    answer = response(Backlash(width=2.0 * part), swing)[points:]
    turns = (cmath.exp(-2.0j * math.pi * n / points) for n in range(points))
    found = 2.0j / points * sum(a * turn for a, turn in zip(answer, turns, strict=True))
    side = 1.0 - 2.0 * part
    real = 0.5 + (math.asin(side) + side * math.sqrt(1.0 - side * side)) / math.pi
    assert found == pytest.approx(complex(real, -4.0 / math.pi * part * (1.0 - part)), abs=1e-4)


def test_without_play_it_follows() -> None:
    assert response(Backlash(width=0.0), [1.0, -2.0, 0.25]) == [1.0, -2.0, 0.25]
