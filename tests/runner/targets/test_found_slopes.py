"""Which slopes count, against the same written with sets, tick by tick."""

import numpy as np
import pytest

from proofmass.runner.targets.found_slopes import LANES, Found, ReusedArrays, StillRow, followed
from proofmass.runner.targets.still_numbers import StillNumbers


@pytest.mark.parametrize("seed", range(6))
def test_random_ticks(seed: int) -> None:
    """Numbers begin to have slopes and lose them; events enter, do not, or do so if the number there is moved."""
    draw = np.random.default_rng(seed)
    ticks, rows, size, most = (int(draw.integers(1, last)) for last in (20, 4, 30, 4))
    made = np.where(draw.random((ticks, rows, size + most + 1, LANES)) < 0.05, 1.0, 0.0)
    made *= draw.normal(size=made.shape)
    made[draw.random(made.shape) < 1e-3] = np.nan
    directions = draw.permutation(size + most)[: rows * LANES]
    lanes = np.full((rows, LANES), -1)
    lanes.reshape(-1)[: len(directions)] = directions
    entering, live = draw.random((ticks, most)) < 0.3, draw.random(size) < 0.2
    if_moved = ~entering & (draw.random((ticks, most)) < 0.5)

    none = StillRow(-1, np.zeros((size + most + 1, LANES)))

    found, lived, after, entered, left = followed(made, lanes, live, entering, if_moved, none, ReusedArrays())

    now, ever, expected = {*np.flatnonzero(live)}, set[int](), list[tuple[int, int, int, float]]()
    for tick in range(ticks):
        ever |= now
        own = now | {size + event for event in range(most) if entering[tick, event]}
        for event in range(most):
            own_lanes = np.isin(lanes, [*own])
            if if_moved[tick, event] and (made[tick, :, size + event] != 0.0)[own_lanes].any():
                own.add(size + event)
        assert {size + event for event in range(most) if entered[tick, event]} == {of for of in own if of >= size}
        of_tick = [
            (tick, place, int(lanes[row, lane]), float(made[tick, row, place, lane]))
            for row in range(rows)
            for place in range(size + most)
            for lane in range(LANES)
            if lanes[row, lane] in own and made[tick, row, place, lane] != 0.0
        ]
        expected += of_tick
        now = {np.int64(place) for _, place, _, _ in of_tick if place < size}
    assert left == ticks
    assert {*np.flatnonzero(lived)} == ever
    assert {*np.flatnonzero(after)} == now
    np.testing.assert_array_equal(np.array(found).T, np.array(expected).reshape(-1, 4))


def test_numbers_that_are_still_keep_their_slope_up_to_the_tick_that_moves_one() -> None:
    """Of three numbers and an event: the first is followed, the others are still; all that differs is a move."""
    live, no_events, ticks = np.array([True, True, True]), np.zeros((4, 1), dtype=bool), 4
    numbers = StillNumbers(3)
    numbers.now[1:] = True
    begins = numbers.begins(5)
    lanes = np.full((2, LANES), -1)
    lanes[0, 0] = 0
    made = np.zeros((ticks, 2, 5, LANES))
    made[:, 0, :2, 0] = 0.5, 7.0  # the first fades, and moves the second
    made[:, 1] = begins

    def ticks_left() -> int:
        given = made, lanes, live, no_events, no_events, StillRow(1, begins), ReusedArrays()
        return followed(*given).still

    found = followed(made, lanes, live, no_events, no_events, StillRow(1, begins), ReusedArrays()).found
    expected = {(0, 0, 0.5), (1, 0, 7.0), (1, 1, 1.0), (2, 2, 1.0)}
    assert {*zip(found.row.tolist(), found.column.tolist(), found.value.tolist(), strict=True)} == expected
    assert np.bincount(found.tick).tolist() == [4] * ticks
    for place, lane, value in [(1, LANES - 1, 0.5), (2, LANES - 1, 0.0), (0, 3, np.nan), (3, 0, np.nan), (4, 5, 1.0)]:
        made[2, 1, place, lane] = value
        assert ticks_left() == 2
        made[2, 1] = begins
    of_the_other = np.flatnonzero(np.isnan(begins[1]) & ~np.isnan(begins[2]))[0]
    made[0, 1, 2, of_the_other] = np.nan  # one still number moves another
    assert ticks_left() == 0
    made[0, 1] = begins
    assert ticks_left() == ticks


def test_each_of_thousands_has_lanes_that_another_one_has_not() -> None:
    numbers = StillNumbers(6435)
    numbers.now[:] = True
    lanes = np.isnan(numbers.begins(6435)).astype(int)
    shared = lanes[::50] @ lanes.T
    assert (lanes.sum(axis=1) == 7).all()
    assert (np.sum(shared == 7, axis=1) == 1).all()  # itself


def test_numbers_are_taken_to_be_still_after_ticks_that_left_them() -> None:
    """Those with no entry but 1 for themselves in each tick; after a move all are followed for longer and longer."""
    size, ticks = 64, 3
    own = np.tile(np.arange(size), ticks)
    value = np.ones(len(own))
    value[size + 5] = 0.5  # number 5, in the second tick
    found = Found(np.repeat(np.arange(ticks), size), own, own, value)
    numbers, live = StillNumbers(size), np.ones(size, dtype=bool)
    live[7] = False

    def waits() -> int:
        for parts in range(100):
            if numbers.now.any():
                return parts
            numbers.choose(found, live, ticks, 1)
        return -1

    assert waits() == 2
    assert np.flatnonzero(~numbers.now).tolist() == [5, 7]
    patience = []
    for _ in range(3):
        numbers.moved()
        assert not numbers.now.any()
        patience.append(waits())
    assert patience == [2, 4, 8]
    numbers.choose(found, live, ticks, 1)
    numbers.moved()
    assert waits() == 1
    numbers.choose(found, np.arange(size) < 30, ticks, 1)
    assert not numbers.now.any()  # two rows of lanes are as few
