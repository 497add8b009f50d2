"""The result of a study: what is counted, said and kept of values that were written by hand."""

import copy
import hashlib
import math
import pickle
import struct
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from proofmass.graphs.studies.study_tables import Limit
from proofmass.runner.studies.outcome.outcomes import Outcomes, SensorRun, outcomes_of, together
from proofmass.runner.studies.outcome.result import StudyResult, as_shown, collected
from tests.by_hand.study_results import AGED, SWEPT, measure, study_result

TWO = 'epochs = { ages = ["0 h", "1 h"] }\n'
THREE = 12.706205  # Student's t of two values


def test_it_says_how_many_runs_are_done_at_how_many_epochs() -> None:
    result = study_result("", {"bias": [[1.0]] * 1200, "noise": [[1.0]] * 1200})
    assert repr(result) == "<StudyResult of a converter that ages: 1,200 of 1,200 runs; bias, noise>"
    assert not result.interrupted
    aged = study_result(TWO, {"bias": [[1, 2], [3, 4]]})
    aged = replace(aged, planned_runs=3, faults={(0, 0): "", (1, 1): ""})
    assert repr(aged) == "<StudyResult of a converter that ages: 2 of 3 runs at 2 epochs, 2 failed; bias>"
    assert aged.interrupted


def test_limits_are_kept_up_to_their_ends() -> None:
    """From -2 to 3, and a change of an eighth of 2, 16 or -2 at the second age; what comes before does not count."""
    rows = [[9, 2, 2.25], [9, 2, 1.75], [9, 2, 2.375], [9, -2, -2.25], [9, -2, -1.75], [9, 3, 3], [9, 3.5, 3.5]]
    limit = 'limits = { bias = { at_least = -2, at_most = 3, change = "12.5 %", from = "1 year" } }\n'
    result = study_result(AGED + limit, {"bias": rows})
    assert result.within("bias").tolist() == [
        [True, True, True], [True, True, True], [True, True, False], [True, True, False], [True, True, True],
        [True, True, True], [True, False, False],
    ]  # fmt: skip
    assert result.kept("bias").tolist() == [True, True, False, False, True, True, False]
    assert result.yields() == {"bias": 4.0 / 7.0, "all limits": 4.0 / 7.0}
    assert result.some(result.numbers < 0).yields() == {}
    assert study_result("", {"bias": rows[:1]}).good() is None
    missing = study_result("limits = { bias = { at_most = 3 } }\n", {"bias": [[np.nan], [3.0]]})
    assert missing.kept("bias").tolist() == [False, True]


def test_sensors_of_several_points_count_once() -> None:
    """Sensor 0 has 1 and 3, sensor 1 has 6 and nothing: means 2 and 6, of which t s / sqrt(2) is 25.4."""
    result = study_result(SWEPT, {"bias": [[1], [3], [6], [np.nan]]})
    assert result.sensors == 2
    (row,) = result.summary()
    assert (row["runs"], row["mean"]) == (3, 4.0)
    assert row["intervals"]["mean"] == pytest.approx((4.0 - 2.0 * THREE, 4.0 + 2.0 * THREE), rel=1e-6)
    everything = (-math.inf, math.inf)
    assert row["intervals"] == {
        "mean": row["intervals"]["mean"], "std": (0.0, math.inf), "p1": everything, "p50": everything, "p99": everything
    }  # fmt: skip
    limited = study_result(SWEPT + "limits = { bias = { at_most = 3 } }\n", {"bias": [[1], [3], [6], [np.nan]]})
    low, high = limited.yield_intervals()["bias"]
    assert (low, high) == pytest.approx((1.0 - math.sqrt(0.975), math.sqrt(0.975)))  # of 1 of 2


def test_runs_that_are_independent_have_intervals_of_their_own() -> None:
    result = study_result("", {"bias": [[1], [3]]})
    (row,) = result.summary()
    assert row["intervals"]["mean"] == pytest.approx((2.0 - THREE, 2.0 + THREE), rel=1e-6)
    assert (row["min"], row["max"], row["std"], row["p50"]) == (1.0, 3.0, math.sqrt(2.0), 2.0)
    assert row["p1"] == pytest.approx(1.02)
    row["mean"] = 0.0
    assert result.summary()[0]["mean"] == 2.0, "rows are the caller's own"


def test_some_runs_are_a_part_of_the_study() -> None:
    result = study_result(TWO, {"bias": [[1, 2], [3, 4], [5, 6], [7, 8]]})
    result = replace(result, numbers=np.array([4, 1, 6, 0]), faults={(1, 0): "a", (0, 1): "b", (6, 1): "c"})
    some = result.some(np.array([True, True, False, False]), 2)
    assert (some.numbers.tolist(), some["bias"].tolist()) == ([4, 1], [[1, 2], [3, 4]])
    assert (some.faults, some.planned_runs) == ({(1, 0): "a"}, 2)
    assert result.some(np.array([0])).planned_runs == 4


def test_the_digest_is_that_of_all_bits_in_the_order_of_names() -> None:
    result = study_result(TWO, {"noise": [[1, 2], [3, 4]], "bias": [[5, 6], [7, 8]]})
    assert result.digest == hashlib.sha256(struct.pack("<8d", 5, 6, 7, 8, 1, 2, 3, 4)).hexdigest()
    attributes = result.attributes()
    assert attributes["digest"] == result.digest
    assert (attributes["graph"], attributes["proofmass"]) == ("a converter that ages", "0.1.0")
    assert attributes["study"] == result.study.text()


def test_a_notebook_shows_a_table_with_yields() -> None:
    """Ages of less than an hour are in seconds; a measure that no run has has no numbers."""
    limits = 'epochs = { ages = ["10 s", "1 h", "1 year"] }\nlimits = { bias = { at_most = 3 } }\n'
    result = study_result(limits, {"bias": [[1, 2, 3], [1, 4, np.nan]], "noise": [[np.nan] * 3] * 2}, {"bias": "m/s^2"})
    text = result._repr_html_()
    cells = [row.split("</td>")[:-1] for row in text.split("<tr>")[1:]]
    bare = [[cell.rpartition(">")[2] for cell in row] for row in cells if len(row) > 1]
    assert bare[:3] == [
        ["bias", "m/s²", "10 s", "2", "1", "0", "1", "1", "1"],
        ["bias", "m/s²", "1 h", "2", "3", "1.41421", "2.02", "3", "3.98"],
        ["bias", "m/s²", "1 year", "1", "3", "0", "3", "3", "3"],
    ]
    assert [row[:4] for row in bare[3:]] == [["noise", "", age, "0"] for age in ("10 s", "1 h", "1 year")]
    assert bare[-1][4:] == [""] * 5
    assert "StudyResult of a converter that ages: 2 of 2 runs at 3 epochs; bias, noise" in text
    assert "&lt;" not in text
    assert "yield, bias: 50.00 %" in text


@pytest.mark.parametrize(
    ("largest", "factor", "unit"),
    [(0.01, 1.0, "V"), (0.0099, 1e3, "mV"), (9999.0, 1.0, "V"), (1e4, 1e-3, "kV"), (0.0, 1.0, "V")],
)
def test_measures_have_a_prefix_where_numbers_are_long_without_it(largest: float, factor: float, unit: str) -> None:
    limits = "limits = { bias = { at_least = -2, at_most = 3 }, noise = { at_most = 5 } }\n"
    values = {"bias": [[-largest], [np.nan]], "noise": [[1.0], [2.0]]}
    result = study_result(limits, values, {"bias": "V"})
    shown = as_shown(result)
    assert [one.unit for one in shown.measures] == [unit, "1"]
    assert shown["bias"][0, 0] == pytest.approx(-largest * factor)
    assert shown["noise"].tolist() == [[1.0], [2.0]]
    limit = shown.study.limits["bias"]
    assert (limit.at_least, limit.at_most) == pytest.approx((-2.0 * factor, 3.0 * factor))
    assert shown.study.limits["noise"] == Limit(at_most=5.0)
    assert (shown is result) == (factor == 1.0)


def test_a_measure_is_shown_in_the_unit_that_it_asks_for() -> None:
    """1 rad/s is 648000 / pi degrees an hour."""
    result = study_result("", {"bias": [[1.0]]})
    result = replace(result, measures=(measure("bias", "rad/s", "deg/h"),))
    shown = as_shown(result)
    assert shown["bias"][0, 0] == pytest.approx(648000.0 / math.pi)
    assert (shown.measures[0].unit, shown.measures[0].shown_in) == ("deg/h", "")


def test_outcomes_of_runs_stand_in_columns() -> None:
    runs = [
        SensorRun(3, 0, (1.0, 2.0)),
        SensorRun(3, 1, None, "lost"),
        SensorRun(1, 0, (5.0, 6.0)),
        SensorRun(1, 1, (7.0, 8.0)),
    ]
    found = outcomes_of(runs, 2, 2)
    assert found.numbers.tolist() == [3, 1]
    np.testing.assert_array_equal(found.values, [[[1.0, 2.0], [np.nan] * 2], [[5.0, 6.0], [7.0, 8.0]]])
    assert found.faults == {(3, 1): "lost"}
    measures = measure("bias"), measure("noise")
    kept = collected(measures, found)
    np.testing.assert_array_equal(kept["values"]["noise"], [[2.0, np.nan], [6.0, 8.0]])
    assert kept["numbers"] is found.numbers
    assert kept["faults"] is found.faults


def numbered(*numbers: int, faults: dict[tuple[int, int], str] | None = None) -> Outcomes:
    values = np.array(numbers, dtype=float)[:, None, None]
    return Outcomes(np.array(numbers, dtype=np.int64), values, faults or {})


def told(outcomes: Outcomes) -> tuple[list[int], dict[tuple[int, int], str]]:
    assert outcomes.values.ravel().tolist() == outcomes.numbers.tolist()
    return outcomes.numbers.tolist(), outcomes.faults


def test_stretches_are_runs_of_consecutive_numbers() -> None:
    faults = {(2, 0): "a", (9, 0): "b"}
    found = [told(part) for part in numbered(9, 1, 2, 5, 0, 4, faults=faults).stretches()]
    assert found == [([0, 1, 2], {(2, 0): "a"}), ([4, 5], {}), ([9], {(9, 0): "b"})]
    assert list(numbered().stretches()) == []
    assert told(numbered(9, 2, faults=faults).chosen(np.array([False, True]))) == ([2], {(2, 0): "a"})


def test_outcomes_are_put_together_in_the_order_in_which_they_are_given() -> None:
    one, two = numbered(3, faults={(3, 0): "a"}), numbered(1, 2, faults={(1, 0): "b"})
    assert told(together([one, two], 1, 1)) == ([3, 1, 2], {(3, 0): "a", (1, 0): "b"})
    assert together([one], 1, 1) is one
    nothing = together([], 3, 2)
    assert (nothing.values.shape, nothing.numbers.dtype, len(nothing.numbers)) == ((0, 3, 2), np.int64, 0)


@pytest.mark.defect("S1015", before="`bias = result['bias']; bias *= 1000` changed the yield to 0", after="refused")
def test_values_of_a_study_cannot_be_changed() -> None:
    result = study_result("limits = { bias = { at_most = 3 } }\n", {"bias": [[1.0], [3.0]]})
    bias = result["bias"]
    with pytest.raises(ValueError, match="read-only"):
        bias *= 1000.0
    with pytest.raises(ValueError, match="read-only"):
        result.to_xarray()["bias"] *= 1000.0
    assert result.yields()["bias"] == 1.0


@pytest.mark.defect("C896", before="TypeError: cannot pickle 'mappingproxy' object", after="the study with its result")
@pytest.mark.defect("S1048", before="the numbers of runs could be changed", after="read-only")
@pytest.mark.parametrize("again", [copy.copy, copy.deepcopy, lambda one: pickle.loads(pickle.dumps(one))])
def test_the_result_of_a_study_is_copied_and_pickled(again: Callable[[StudyResult], StudyResult]) -> None:
    result = study_result(AGED, {"bias": [[1.0, 2.0], [3.0, 4.0]]})
    copied = again(result)
    assert copied.digest == result.digest
    assert copied.study == result.study
    assert not copied["bias"].flags.writeable
    assert not copied.numbers.flags.writeable
    assert type(copied.study.spread) is type(result.study.spread)
