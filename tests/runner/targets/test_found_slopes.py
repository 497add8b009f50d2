"""Which slopes count, against the same written with sets, tick by tick."""

import numpy as np
import pytest

from proofmass.runner.targets.found_slopes import LANES, ReusedArrays, followed


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

    found, lived, after, entered = followed(made, lanes, live, entering, if_moved, ReusedArrays())

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
    assert {*np.flatnonzero(lived)} == ever
    assert {*np.flatnonzero(after)} == now
    np.testing.assert_array_equal(np.array(found).T, np.array(expected).reshape(-1, 4))
