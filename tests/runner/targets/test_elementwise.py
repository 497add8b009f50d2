"""Compiled functions over arrays: shapes as NumPy's, bits as plain Python's, and what is kept is never stale."""

import sys

import numpy as np
import pytest

from proofmass.blocks.arithmetic.counter_random import normal_quantile, uniform_deviate
from proofmass.runner.targets.elementwise import Elementwise

OFFSET = 0.5


def raised(x: float) -> float:
    return x + OFFSET


def doubled(x: float) -> float:
    return 2.0 * raised(x)


def test_arguments_of_any_shape() -> None:
    deviates = Elementwise(uniform_deviate, {"seed": int, "run": int, "stream": int, "sample": int}, float)
    found = deviates(3, np.arange(5), np.array([[1], [2]]), 7)
    assert found.tolist() == [[uniform_deviate(3, run, stream, 7) for run in range(5)] for stream in (1, 2)]
    assert deviates(3, np.arange(0), 1, 7).shape == (0,)
    with pytest.raises(ValueError, match="broadcast"):
        deviates(3, np.arange(2), np.arange(3), 7)


def test_views_and_other_kinds_of_numbers() -> None:
    probabilities = np.linspace(0.01, 0.99, 30)
    quantiles = Elementwise(normal_quantile, {"probability": float}, float)
    assert quantiles(probabilities[::3]).tolist() == [normal_quantile(p) for p in probabilities[::3].tolist()]
    assert quantiles(np.float32(0.25)).item() == normal_quantile(0.25)


def test_a_function_that_is_kept_is_made_anew_when_what_it_reads_changes(monkeypatch: pytest.MonkeyPatch) -> None:
    given = np.array([1.0, 2.0])

    def now() -> list[float]:
        found: list[float] = Elementwise(doubled, {"x": float}, float)(given).tolist()
        return found

    module = sys.modules[__name__]
    assert now() == [3.0, 5.0]
    monkeypatch.setattr(module, "OFFSET", 1.5)  # read by the function that it calls
    assert now() == [5.0, 7.0]
    monkeypatch.setattr(module, "raised", lambda x: x - 1.0)
    assert now() == [0.0, 2.0]
    monkeypatch.undo()
    assert now() == [3.0, 5.0]
