"""The numbers of a graph at the ends of periods: a cosine with a cycle of eight of them."""

import math

import pytest

from proofmass.runner.analysis.linearisation.numbers import Orbit


@pytest.mark.parametrize(("most", "nearest"), [(7, 7), (8, 8), (11, 8)])
def test_the_nearest_return_lies_between_the_bounds(most: int, nearest: int) -> None:
    orbit = Orbit([{"x": math.cos(2.0 * math.pi * period / 8.0)} for period in range(13)])
    assert orbit.nearest(3, most) == nearest
