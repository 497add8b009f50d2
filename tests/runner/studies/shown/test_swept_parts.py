"""Points of a sweep that have tables of their own: those of two to twelve values."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from proofmass.runner.studies.shown import points


@pytest.mark.parametrize(
    ("swept", "intervals", "several"), [(1, 1, False), (1, 3, False), (2, 1, True), (12, 2, True), (13, 1, False)]
)
def test_few_points_stand_apart(swept: int, intervals: int, several: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    """Runs of two rounds over all points; the intervals between calibrations of a point stand together."""
    monkeypatch.setattr(points, "_swept_text", lambda study, point: f"point {point}")
    total = swept * intervals
    study = SimpleNamespace(points=total, recalibration=SimpleNamespace(every=(1.0,) * intervals))
    numbers = np.arange(2 * total)
    result: Any = SimpleNamespace(study=study, numbers=numbers, some=lambda chosen, of: (numbers[chosen].tolist(), of))
    found = points.swept_parts(result)
    if not several:
        assert found == {"": result}
        return
    assert found == {
        f"point {number * intervals}": (
            [turn * total + number * intervals + k for turn in (0, 1) for k in range(intervals)],
            swept,
        )
        for number in range(swept)
    }
