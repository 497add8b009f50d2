"""Rows of a report: the worst runs, and what calibrations gain, from values that were written by hand."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from proofmass.runner.studies.shown import report, report_lifetimes


class Result:
    """Values of one measure, and a study without limits."""

    study = SimpleNamespace(limits={}, epochs=(0.0, 1.0))

    def __init__(self, values: list[list[float]]) -> None:
        self.values = np.array(values)

    def __getitem__(self, name: str) -> Any:
        return self.values


@pytest.mark.parametrize(("most", "rows"), [(9, [(2, 1), (0, 0), (1, 0)]), (2, [(2, 1), (0, 0)])])
def test_each_run_has_its_worst_age_and_none_without_a_value(
    most: int, rows: list[tuple[int, int]], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Runs 4 and 1 from the median, and 9 at the second age; the last has no value at all."""
    monkeypatch.setattr(report, "_from_median", lambda values: np.abs(values))
    monkeypatch.setattr(report, "_named", lambda result, name, row, epoch, distance, limit: (row, epoch, distance))
    values = [[4.0, np.nan], [1.0, -0.5], [2.0, -9.0], [np.nan, np.inf]]
    found = report.worst_runs(Result(values), "bias", most)  # type: ignore[arg-type]
    assert found == [(row, epoch, abs(values[row][epoch])) for row, epoch in rows]
    assert not report.worst_runs(Result([[np.nan, np.nan]]), "bias", most)  # type: ignore[arg-type]


def test_sensors_are_compared_with_themselves() -> None:
    """Of the sensors 1 to 4, which both have, one more is within the limit with calibrations."""
    more = SimpleNamespace(good_at_last=np.array([1.0, 1.0, 1.0, 0.0]))
    less = SimpleNamespace(good_at_last=np.array([1.0, 0.0, 1.0, 1.0, 0.0]))
    part = SimpleNamespace(draws=np.array([1, 2, 3, 4]))
    other = SimpleNamespace(draws=np.array([0, 1, 2, 3, 4]))
    gained: Any = report_lifetimes._gain
    assert gained(more, less, part, other).startswith("+25.0 % (")
    assert gained(more, more, part, part).startswith("+0.0 % (")
