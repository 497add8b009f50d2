"""Rows of exported answers, from lifetimes and values that were written by hand."""

import math
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from proofmass.runner.studies.outcome.lifetimes import Lifetimes
from proofmass.runner.studies.outcome.result import StudyResult
from proofmass.runner.studies.shown import export_answers
from tests.by_hand.study_results import study_result


def test_a_row_of_each_age_has_its_own_parts_and_their_intervals(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(export_answers, "point_columns", lambda part: {"point": part})
    law: Any = SimpleNamespace(survival=lambda age: np.exp(-age))
    parts, intervals = np.array([0.9, 0.7]), ((0.8, 0.95), (0.6, 0.75))
    left, bounds = np.array([0.85, 0.5]), ((0.7, 0.875), (0.4, 0.625))
    last = np.zeros(40, dtype=bool), 0.2, law, 0.1, (0.05, 0.15)
    lives = Lifetimes("bias", 40, (0, 2), (0.0, 3.0), parts, intervals, left, bounds, *last)
    rows = list(export_answers._ages("p1", lives))  # type: ignore[arg-type]
    expected = [
        {"epoch": 0, "age_s": 0.0, "good": 0.9, "good_low": 0.8, "good_high": 0.95, "never_out": 0.85}
        | {"never_out_low": 0.7, "never_out_high": 0.875, "weibull": 1.0},
        {"epoch": 2, "age_s": 3.0, "good": 0.7, "good_low": 0.6, "good_high": 0.75, "never_out": 0.5}
        | {"never_out_low": 0.4, "never_out_high": 0.625, "weibull": pytest.approx(np.exp(-3.0))},
    ]
    assert rows == [{"point": "p1", "limit": "bias", "sensors": 40, "band": 0.2} | row for row in expected]


def test_a_summary_of_none_one_and_two_values() -> None:
    """1 and 3 have the mean 2 and the deviation sqrt 2; one value has none."""
    measure = SimpleNamespace(name="bias", unit="V")
    values = np.array([[np.nan, 5.0, 1.0], [np.inf, np.nan, 3.0]])
    study = SimpleNamespace(epochs=(0.0, 1.0, 2.0))
    made: Any = SimpleNamespace(measures=[measure], study=study, values={"bias": values}, _intervals=lambda *_: {})
    made.of_draws = lambda column: column
    rows = vars(StudyResult)["_summary"].func(made)
    assert [row["runs"] for row in rows] == [0, 1, 2]
    assert "mean" not in rows[0]
    assert (rows[1]["mean"], rows[1]["std"], rows[1]["min"], rows[1]["max"]) == (5.0, 0.0, 5.0, 5.0)
    assert (rows[2]["mean"], rows[2]["std"], rows[2]["min"], rows[2]["max"]) == (2.0, np.sqrt(2.0), 1.0, 3.0)


def test_a_row_of_a_limit_has_the_law_with_its_intervals_or_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(export_answers, "point_columns", lambda part: {})
    law = SimpleNamespace(shape=2.0, scale=9.0, one_percent=0.5)
    law.shape_interval, law.scale_interval, law.one_percent_interval = (1.5, 2.5), (8.0, 10.0), (0.25, 0.75)
    facts = {"limit": "bias", "sensors": 40, "time_out": 0.1, "time_out_interval": (0.05, 0.15), "law_fits": 0.5}
    facts |= {"left_at": lambda share: (share, 2 * share) if share < 0.02 else None}
    facts |= {"left_interval": lambda share: (0.5 * share, 3 * share)}
    whole: Any = export_answers._whole
    row = whole(None, SimpleNamespace(law=law, **facts))
    assert [row[f"weibull_{name}"] for name in ("shape", "scale_s", "left_1_percent_s", "fits")] == [2.0, 9.0, 0.5, 0.5]
    assert [row[f"weibull_shape_{end}"] for end in ("low", "high")] == [1.5, 2.5]
    assert [row[f"weibull_scale_s_{end}"] for end in ("low", "high")] == [8.0, 10.0]
    assert [row[f"weibull_left_1_percent_s_{end}"] for end in ("low", "high")] == [0.25, 0.75]
    assert [row[name] for name in ("time_out", "time_out_low", "time_out_high")] == [0.1, 0.05, 0.15]
    assert [row[f"left_1_percent_{of}_s"] for of in ("after", "by", "low", "high")] == [0.01, 0.02, 0.005, 0.03]
    none = whole(None, SimpleNamespace(law=None, **facts))
    assert all(np.isnan(value) for name, value in none.items() if name.startswith("weibull") and name != "weibull_fits")


def test_tables_that_have_rows_are_written_in_every_form(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    result = study_result("", {"bias": [[1.0]]})
    monkeypatch.setattr(export_answers, "index_rows", lambda result: [])
    monkeypatch.setattr(export_answers, "yield_rows", lambda result: [{"limit": "bias", "good": 0.5}])
    monkeypatch.setattr(export_answers, "lifetime_rows", lambda result: [{"a": 1.5}, {"a": math.nan}])
    known: Any = SimpleNamespace(result=result, rows=list)
    assert export_answers.save_answers(known, tmp_path, ("csv",)) == [
        "yields.json", "yields.csv", "lifetimes.json", "lifetimes.csv"
    ]  # fmt: skip
    assert (tmp_path / "yields.csv").read_text().split() == ["limit,good", "bias,0.5"]
    assert (tmp_path / "lifetimes.csv").read_text().split() == ["a", "1.5", "nan"]
    about = "When parts of the sensors have left each limit, Weibull's law, and the time out of tolerance."
    assert (tmp_path / "lifetimes.json").read_text() == (
        f'{{\n "about": "{about}",\n "digest": "{result.digest}",\n'
        ' "rows": [\n  {\n   "a": 1.5\n  },\n  {\n   "a": null\n  }\n ]\n}\n'
    )
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(
        ["yields.json", "yields.csv", "lifetimes.json", "lifetimes.csv"]
    )


@pytest.mark.parametrize("rows", [1, 2])
def test_columns_of_rows(rows: int) -> None:
    made = [{"a": place, "b": 10 * place} for place in range(rows)]
    assert export_answers._columns(made) == {"a": [*range(rows)], "b": [10 * place for place in range(rows)]}
