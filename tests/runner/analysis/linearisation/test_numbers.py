"""The numbers of a graph at the ends of periods: a cosine with a cycle of eight of them."""

import math

import pytest

from proofmass.runner.analysis.linearisation.numbers import Orbit


@pytest.mark.parametrize(("most", "nearest"), [(7, 7), (8, 8), (11, 8)])
def test_the_nearest_return_lies_between_the_bounds(most: int, nearest: int) -> None:
    orbit = Orbit([{"x": math.cos(2.0 * math.pi * period / 8.0)} for period in range(13)])
    assert orbit.nearest(3, most) == nearest


def test_returns_are_the_convergents_of_the_cycle() -> None:
    """7, 36 / 5 and 115 / 16 are the continued fraction of a cycle of 115 / 16 periods."""
    orbit = Orbit([{"x": math.cos(2.0 * math.pi * period * 16.0 / 115.0)} for period in range(130)])
    assert [*orbit.returns()] == [7, 36, 115]
