"""The length of a vector against math.hypot."""

import math

import pytest

from proofmass.blocks import Magnitude
from tests.by_hand.responses import noise, responses


def test_against_the_standard_library() -> None:
    a, b, c = noise(300, 1), noise(300, 2), noise(300, 3)
    expected = [math.hypot(*vector) for vector in zip(a, b, c, strict=True)]
    assert responses(Magnitude(), first=a, second=b, third=c) == pytest.approx(expected, rel=1e-15)
    assert responses(Magnitude(), first=[3.0], second=[-4.0], third=[0.0]) == [5.0]
