"""Curves of the variants of a sweep: one for each value of the other parameters."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from proofmass.runner.studies.shown import curves


class Result:
    """A measure of two sensors at two ages."""

    measures = (SimpleNamespace(name="bias"),)

    def __init__(self, last: float) -> None:
        self.values = {"bias": np.array([[9.0, last], [9.0, last + 1.0]])}

    def __getitem__(self, name: str) -> Any:
        return self.values[name]


def test_variants_are_curves_over_one_parameter(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of two gains and two masses, over the gain a curve of each mass, at the last age."""
    drawn: list[Any] = []
    monkeypatch.setattr(curves, "_drawn", lambda known, key, unit, measure: drawn.append((known, key)) or "")
    names = {f"gain = {gain}, mass = {mass}": (gain, mass) for gain in (1, 2) for mass in (5, 7)}
    results = {name: Result(10.0 * gain + mass) for name, (gain, mass) in names.items()}
    swept = {name: {"gain": str(gain), "mass": str(mass)} for name, (gain, mass) in names.items()}
    curves._over(results, swept, "gain")  # type: ignore[arg-type]
    ((known, key),) = drawn
    assert key == "gain"
    assert {name: [(at, column.tolist()) for at, column in points] for name, points in known.items()} == {
        "mass = 5": [(1.0, [15.0, 16.0]), (2.0, [25.0, 26.0])],
        "mass = 7": [(1.0, [17.0, 18.0]), (2.0, [27.0, 28.0])],
    }
