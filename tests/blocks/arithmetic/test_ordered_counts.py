"""The table of values with their counts: places against bisect, contents against sorted lists."""

from bisect import bisect_left

import numpy as np
import pytest

from proofmass.blocks.arithmetic.ordered_counts import join_neighbours, place_of, take_in

VALUES = np.random.default_rng(2).permutation(200).astype(float).tolist()


def test_places() -> None:
    ordered = sorted(VALUES[:50])
    assert [place_of(ordered, 50, u) for u in VALUES] == [bisect_left(ordered, u) for u in VALUES]


def test_fresh_values_are_taken_in_at_their_places() -> None:
    old, fresh = sorted(VALUES[:50]), sorted(VALUES[50:60])
    value, count = [*old, *[0.0] * 10], [*[1] * 50, *[0] * 10]
    take_in(50, value, count, fresh, [7] * 10)
    assert value == sorted(VALUES[:60])
    assert [u for u, samples in zip(value, count, strict=True) if samples == 7] == fresh


def test_all_between_the_ends_are_joined_where_there_is_room() -> None:
    value, count = [0.0, 1.0, 3.0, 9.0], [1, 1, 1, 1]
    assert join_neighbours(4, value, count, 100.0, 0.5, 4.0) == 3
    assert (value[:3], np.abs(count[:3]).tolist()) == ([0.0, 2.0, 9.0], [1, 2, 1])


@pytest.mark.parametrize("part", [0.01, 0.5, 0.999])
def test_neighbours_are_joined_without_losing_samples_and_mean(part: float) -> None:
    value, count = sorted(VALUES), [1] * 200
    left = join_neighbours(200, value, count, 4.0, part, 200.0)
    samples = np.abs(count[:left])
    assert left < 110
    assert samples.sum() == 200
    assert np.dot(samples, value[:left]) == pytest.approx(sum(VALUES), rel=1e-13)
    assert (value[0], value[left - 1], count[0], count[left - 1]) == (0.0, 199.0, 1, 1)
    assert all(np.diff(value[:left]) > 0)
