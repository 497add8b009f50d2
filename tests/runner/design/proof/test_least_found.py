"""Corners at which the least margin is looked for."""

from proofmass.runner.design.proof.least_found import _corners
from proofmass.runner.design.worst.ranges import Range


def test_the_worst_corner_and_its_neighbours() -> None:
    ranges = tuple(Range(name, name, "1", 2.0, 1.0, 3.0) for name in "abc")
    worse = {"a": 3.0, "b": 1.0, "c": 3.0}
    assert list(_corners(worse, ranges)) == [
        worse,
        {"a": 1.0, "b": 1.0, "c": 3.0},
        {"a": 3.0, "b": 3.0, "c": 3.0},
        {"a": 3.0, "b": 1.0, "c": 1.0},
    ]
