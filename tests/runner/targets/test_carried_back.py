"""Products of sparse maps from the last tick back, against products of whole matrices from the first one on."""

import numpy as np
import pytest

from proofmass.runner.targets.carried_back import TickEntries, carried_back


@pytest.mark.parametrize("seed", range(6))
def test_random_ticks(seed: int) -> None:
    """Most numbers stay, some are forgotten, some are sums; events enter, are listened to, or neither."""
    draw = np.random.default_rng(seed)
    size, ticks, most = int(draw.integers(1, 12)), int(draw.integers(1, 30)), int(draw.integers(1, 4))
    maps = np.zeros((ticks, size + most, size + most))
    for of_tick in maps:
        for row in range(size + most):
            if row < size and draw.random() < 0.6:
                of_tick[row, row] = 1.0
            elif draw.random() < 0.8:
                of_tick[row, draw.integers(0, size + most, 3)] = draw.normal(size=3)
    enters, heard = np.full((ticks, most), -1), np.full((ticks, most), -1)
    inside = draw.random((ticks, most)) < 0.7
    enters[inside] = np.arange(inside.sum())
    asked = draw.random((ticks, most)) < 0.3
    heard[asked] = size + np.arange(asked.sum())
    row, column, value, bounds = [np.zeros(0, dtype=int)], [np.zeros(0, dtype=int)], [np.zeros(0)], [0]
    for of_tick in maps:
        rows, columns = np.nonzero(of_tick)
        order = draw.permutation(len(rows))
        row.append(rows[order])
        column.append(columns[order])
        value.append(of_tick[rows, columns][order])
        bounds.append(bounds[-1] + len(rows))
    entries = TickEntries(np.array(bounds), *(np.concatenate(each) for each in (row, column, value)))
    a, b = carried_back(entries, heard, enters, np.eye(size, size + int(asked.sum())))

    lasting, outputs = (
        np.eye(size, size + int(inside.sum())),
        np.zeros((size + int(asked.sum()), size + int(inside.sum()))),
    )
    for tick, of_tick in enumerate(maps):
        entering = np.zeros((most, lasting.shape[1]))
        for event in np.flatnonzero(enters[tick] >= 0):
            entering[event, size + enters[tick, event]] = 1.0
        moved = of_tick @ np.vstack([lasting, entering])
        outputs[heard[tick][heard[tick] >= 0]] = moved[size:][heard[tick] >= 0]
        lasting = moved[:size]
    outputs[:size] = lasting
    made = np.vstack([a, b]).T
    assert made == pytest.approx(outputs, rel=1e-9, abs=1e-12 * np.max(np.abs(outputs)))
    assert ((made != 0.0) == (outputs != 0.0)).all(), "what is nothing is so exactly"
