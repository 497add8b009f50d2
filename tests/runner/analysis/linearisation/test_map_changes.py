"""Norms of responses by as few numbers as there are states, against the responses themselves."""

import numpy as np
import pytest

from proofmass.runner.analysis.linearisation.map_changes import _inverse, _norms


@pytest.mark.parametrize(("states", "inputs", "outputs"), [(3, 2, 4), (5, 50, 30), (0, 3, 2), (4, 1, 1)])
def test_norms(states: int, inputs: int, outputs: int) -> None:
    random = np.random.default_rng(1)
    maps = [
        tuple(
            random.normal(size=size) * 0.3
            for size in ((states, states), (states, inputs), (outputs, states), (outputs, inputs))
        )
        for _ in range(2)
    ]
    z = np.exp(1j * np.array([0.1, 1.0, 3.0]))
    size, moved = _norms(*maps, *(_inverse(parts[0], z) for parts in maps))
    one, two = (np.array([c @ np.linalg.solve(at * np.eye(states) - a, b) + d for at in z]) for a, b, c, d in maps)
    larger = np.maximum(np.linalg.norm(one, axis=(1, 2)), np.linalg.norm(two, axis=(1, 2)))
    assert size == pytest.approx(larger, rel=1e-12)
    assert moved == pytest.approx(np.linalg.norm(two - one, axis=(1, 2)), rel=1e-12)
