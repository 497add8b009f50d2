"""Rows of influences and indices for other tools, from values that were written by hand."""

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from proofmass.graphs.studies.ages import YEAR
from proofmass.runner.studies.draws.factors import Factors
from proofmass.runner.studies.shown import influences
from proofmass.runner.studies.shown.influences import Influences, StudyInfluences, index_rows, one_age, point_columns
from proofmass.runner.studies.shown.sensitivities import Index, Influence, Regression
from tests.by_hand.study_results import AGED, SWEPT, measure, study_result

CALIBRATED = 'recalibration = { every = ["never", "1 year"], carried = { "adc.gain_error" = "bias" } }\n'


def test_the_age_of_a_calibration_is_one_if_all_runs_share_it() -> None:
    assert one_age((0.0, 1.0, 3.0), np.array([2, 2, 2])) == 3.0
    assert math.isnan(one_age((0.0, 1.0, 3.0), np.array([2, 1, 2])))
    assert math.isnan(one_age((0.0, 1.0, 3.0), np.array([1, 2, 2])))


@pytest.mark.parametrize(
    ("points", "epochs", "measures", "every"),
    [(1, 500, 1, True), (1, 501, 1, False), (2, 125, 2, True), (2, 126, 2, False), (13, 500, 1, True)],
)
def test_of_too_many_tables_a_dozen_ages_are_looked_at(
    points: int, epochs: int, measures: int, every: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """500 tables at most; many points of a sweep are one part."""
    monkeypatch.setattr(influences, "parts", lambda result: [None] * (points if points <= 12 else 1))
    study = SimpleNamespace(epochs=tuple(range(epochs)), points=points)
    result: Any = SimpleNamespace(study=study, measures=range(measures))
    looked_at = influences.epochs_looked_at(result)
    step = 1 if every else math.ceil((epochs - 1) / 10)
    assert looked_at == sorted({*range(0, epochs, step), epochs - 1})


def test_columns_that_name_the_point() -> None:
    result = study_result(SWEPT + AGED, {"bias": [[1, 2, 3]] * 4})
    odd = result.some(result.numbers % 2 == 1)
    assert point_columns(odd) == {"filter.corner_frequency": 200.0}
    assert point_columns(result) == {}, "several points have no single value"
    calibrated = study_result(SWEPT + AGED + CALIBRATED, {"bias": [[1, 2, 3]] * 8})
    last = calibrated.some(calibrated.numbers % 4 == 3)
    assert point_columns(last) == {"filter.corner_frequency": 200.0, "recalibration_s": YEAR}
    assert list(point_columns(calibrated)) == ["recalibration_s"]
    assert math.isnan(point_columns(calibrated)["recalibration_s"])
    nobody = calibrated.some(calibrated.numbers < 0)
    assert math.isnan(point_columns(nobody)["recalibration_s"])


def found(name: str, epoch: int, since: list[int], *of: Influence) -> Influences:
    units = {parameter: f"unit of {parameter}" for one in of for parameter in one.parameters}
    regression = Regression(of, 0.75, 0.625, 9)
    return Influences(measure(name, "V"), epoch, np.array(since), Factors({}, units), np.zeros(0), regression)


def test_a_row_for_each_factor_of_each_measure(monkeypatch: pytest.MonkeyPatch) -> None:
    result = study_result(SWEPT + AGED, {"bias": [[1, 2, 3]] * 4})
    one = Influence(("a", "b"), 1.5, -2.5, 0.5, 0.25, 0.125, 0.0625)
    two = Influence(("change of a", "change of b"), 2.5, 3.5, 1.5, 1.25, 1.125, 1.0625)
    mixed = replace(two, parameters=("change of a", "b"))
    tables = [found("bias", 1, [0, 0], one, two), found("noise", 2, [1, 0], mixed)]
    monkeypatch.setattr(influences, "influences_at", lambda part, drawn, epoch: [t for t in tables if t.epoch == epoch])
    monkeypatch.setattr(influences, "drawn_of", lambda part: None)
    known = StudyInfluences(result)
    first, second, third, *others = known.rows()
    explained = {"explained": 0.75, "explained_of_ranks": 0.625, "runs": 9}
    head = {"filter.corner_frequency": 100.0, "measure": "bias", "epoch": 1, "age_s": YEAR, "unit": "V", "since_s": 0.0}
    assert first == head | explained | {
        "factor": "a, b", "change": False, "factor_unit": "unit of a", "slope": 1.5, "effect": -2.5,
        "effect_half": 0.5, "share": 0.0625, "standardised": 0.25, "of_ranks": 0.125,
    }  # fmt: skip
    assert second == head | explained | {
        "factor": "change of a, change of b", "change": True, "factor_unit": "unit of change of a", "slope": 2.5,
        "effect": 3.5, "effect_half": 1.5, "share": 1.0625, "standardised": 1.25, "of_ranks": 1.125,
    }  # fmt: skip
    assert (third["measure"], third["age_s"], third["change"]) == ("noise", 3.0 * YEAR, False)
    assert math.isnan(third["since_s"])
    assert [row["filter.corner_frequency"] for row in others] == [200.0] * 3
    part = result.some(result.numbers % 2 == 0)
    assert known.by_measure(part) == {"bias": tables[:1], "noise": tables[1:]}
    assert known.of(part) is known.of(part)
    nobody = StudyInfluences(result.some(result.numbers < 0))
    assert nobody.rows() == []
    assert nobody.by_measure(nobody.result) == {}


def test_influences_at_an_epoch_are_those_of_the_first_runs_on_what_varies(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of bias = 3 x + 1 at the second age; noise does not vary."""
    x = np.array([1.0, 2.0, 4.0, 5.0, 7.0])
    bias = np.column_stack([np.zeros(6), np.append(3.0 * x + 1.0, 99.0), np.zeros(6)])
    result = study_result(AGED, {"noise": np.ones((6, 3)), "bias": bias})
    since = np.zeros(5, dtype=int)
    drawn: Any = SimpleNamespace(
        runs=range(5), factors=lambda epoch: Factors({"x": x}, {"x": "m"}), since=lambda e: since
    )
    (one,) = influences.influences_at(result, drawn, 1)
    assert (one.measure.name, one.epoch, one.values.tolist()) == ("bias", 1, [4.0, 7.0, 13.0, 16.0, 22.0])
    assert one.since is since
    assert one.regression.influences[0].slope == pytest.approx(3.0)


def test_parameters_are_drawn_again_of_the_first_runs(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(influences, "MOST_RUNS", 3)
    result = study_result("", {"bias": [[1.0]] * 5})
    assert influences.drawn_of(result).runs.tolist() == [0, 1, 2]


def test_a_row_for_each_index(monkeypatch: pytest.MonkeyPatch) -> None:
    index = Index("adc.reference", 0.25, (0.125, 0.375), 0.5, (0.4375, 0.5625))
    asked = []

    def indices(part: Any, name: str, epoch: int, point: int) -> list[Index]:
        asked.append((part.numbers.tolist(), name, epoch, point))
        return [index]

    monkeypatch.setattr(influences, "sobol_indices", indices)
    text = 'design = "saltelli"\n' + 'spread = { "adc.reference" = { uniform = 0.1 } }\n' + SWEPT
    result = study_result(text + 'epochs = { ages = ["0 h", "1 year"] }\n', {"bias": [[1, 2]] * 6}, {"bias": "V"})
    rows = index_rows(result)
    assert rows[-1] == {
        "filter.corner_frequency": 200.0, "measure": "bias", "epoch": 1, "age_s": YEAR, "unit": "V",
        "parameter": "adc.reference", "first_order": 0.25, "first_order_low": 0.125, "first_order_high": 0.375,
        "total": 0.5, "total_low": 0.4375, "total_high": 0.5625,
    }  # fmt: skip
    even, odd = [0, 2, 4], [1, 3, 5]
    assert asked == [(even, "bias", 0, 0), (even, "bias", 1, 0), (odd, "bias", 0, 1), (odd, "bias", 1, 1)]
    assert index_rows(result.some(result.numbers < 0)) == []
    assert index_rows(study_result(SWEPT, {"bias": [[1.0]] * 6})) == []
