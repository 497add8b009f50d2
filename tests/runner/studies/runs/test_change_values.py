"""Changes of measures, numbers of noise, and what a study does with runs as they arrive, worked out by hand."""

import math
from collections import deque
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.studies.ages import YEAR
from proofmass.graphs.studies.changes import Change
from proofmass.runner.plan.planned import PlannedMeasure
from proofmass.runner.studies.draws.factors import Drawn
from proofmass.runner.studies.kept import ledger as ledgers
from proofmass.runner.studies.kept.ledger import Ledger, repair
from proofmass.runner.studies.outcome.outcomes import Outcomes, SensorRun
from proofmass.runner.studies.runs.sensor_runs import SensorRuns, change_measures, change_values, noise_run
from proofmass.runner.studies.whole import study as whole
from proofmass.runner.studies.workers.chunks import chunk_size
from tests.by_hand.study_results import measure

AGES = (0.0, YEAR, 2.0 * YEAR, 3.0 * YEAR)
FACTS = {"seed": "1"}
CHANGES = {
    "new": Change("bias", 0.0, relative=False),
    "part": Change("bias", YEAR, relative=True),
    "calibrated": Change("noise", None, relative=False),
}
STUDY: Any = SimpleNamespace(changes=CHANGES, epochs=AGES)


def test_changes_since_an_age_and_since_the_last_calibration() -> None:
    """Calibrated at the first three epochs: there the run that follows counts from the next epoch on."""
    bias, noise = [1.0, 2.0, 5.0, 8.0], [10.0, 20.0, 40.0, 80.0]
    values = np.array([np.column_stack([noise, bias])] * 2)
    calibrated = np.array([[True, True, True, False], [False] * 4])
    after = np.full((2, 4, 2), np.nan)
    after[0, :3, 0] = [12.0, 21.0, 43.0]
    found = change_values(STUDY, ["noise", "bias"], values, calibrated, after)
    assert found[0].T.tolist() == [[0.0, 1.0, 4.0, 7.0], [-0.5, 0.0, 1.5, 3.0], [0.0, 8.0, 19.0, 37.0]]
    assert found[1, :, 2].tolist() == [0.0, 10.0, 30.0, 70.0]
    zero = change_values(STUDY, ["noise", "bias"], 0.0 * values, calibrated, after)
    assert np.isnan(zero[0, :, 1]).all(), "of nothing there is no part"


def test_changes_are_measures_with_the_units_of_theirs() -> None:
    noise, bias = measure("noise", "V", "mV"), measure("bias", "rad/s", "deg/h")
    found = change_measures(STUDY, (noise, bias))
    facts = [(m.name, m.signal, m.statistic, m.unit, m.shown_in) for m in found]
    assert facts == [
        ("new", "bias", "change since 0 h", "rad/s", "deg/h"),
        ("part", "bias", "change since 1 year", "1", ""),
        ("calibrated", "noise", "change since the last calibration", "V", "mV"),
    ]
    assert found[0] == PlannedMeasure("new", "bias", "change since 0 h", "rad/s", ("", ""), False, 0, "deg/h")


def test_each_run_and_epoch_has_noise_of_its_own() -> None:
    study: Any = SimpleNamespace(epochs=AGES, peer=lambda run: run // 2)
    assert [noise_run(study, run, epoch) for run, epoch in ((0, 0), (1, 3), (2, 0), (7, 2))] == [0, 3, 4, 14]


def test_the_last_calibration_before_an_epoch_by_run() -> None:
    """Runs take turns: never calibrated, and at the first and the third epoch."""
    calibrated = [(False,) * 4, (True, False, True, False)]
    study: Any = SimpleNamespace(recalibration=SimpleNamespace(every=(1, 2)), calibrated=calibrated.__getitem__)
    drawn: Any = SimpleNamespace(study=study, runs=np.array([0, 1, 2, 3]))
    found = [Drawn.since(drawn, epoch).tolist() for epoch in range(4)]
    assert found == [[0, 0, 0, 0], [0, 0, 0, 0], [0, 0, 0, 0], [0, 2, 0, 2]]


def test_calibrations_store_what_was_measured_where_all_of_it_is_known() -> None:
    """Of four sensors the first does not calibrate, and one of the measures of the third has no value."""
    carried = {"gain": "a", "offset": "c"}
    study = SimpleNamespace(recalibration=SimpleNamespace(carried=carried))
    sensors: Any = SimpleNamespace(_carried=[0, 2], study=study)
    values = np.array([[[9.0] * 3, [10.0 * k + 1, 10.0 * k + 2, 10.0 * k + 3]] for k in range(4)])
    values[2, 1, 2] = np.nan
    measured = Outcomes(np.arange(4), values, {})
    left = {"gain": np.array([-1.0, -2.0, -3.0, -4.0]), "offset": np.array([-5.0, -6.0, -7.0, -8.0])}
    done = SensorRuns._carry(sensors, measured, 1, np.array([False, True, True, True]), left)
    assert done.tolist() == [False, True, False, True]
    assert {name: found.tolist() for name, found in left.items()} == {
        "gain": [-1.0, 11.0, -3.0, 31.0], "offset": [-5.0, 13.0, -7.0, 33.0]
    }  # fmt: skip
    names = [SimpleNamespace(name=name) for name in "abc"]
    places: Any = SimpleNamespace(own_measures=names, study=sensors.study)
    assert vars(SensorRuns)["_carried"].func(places) == [0, 2]
    for row, expected in (((1.0, 2.0, 3.0), {"gain": 1.0, "offset": 3.0}), ((1.0, 2.0, math.nan), {}), (None, {})):
        assert SensorRuns._left_by(sensors, SensorRun(0, 0, row)) == expected


@pytest.mark.parametrize(
    ("before", "seconds", "lanes", "size"),
    [
        (64, 0.05, 64, 320),
        (1, 0.1, 0, 3),  # 2.5, rounded up
        (1, 1e-6, 0, 8),
        (100, 10.0, 0, 3),
        (100, 100.0, 0, 1),
        (10, 0.25, 8, 16),
        (10, 0.0, 0, 80),
    ],
)
def test_chunks_take_a_quarter_of_a_second_and_grow_eightfold(
    before: int, seconds: float, lanes: int, size: int
) -> None:
    assert chunk_size(before, seconds, lanes) == size


# -- what is written, and what is said meanwhile -----------------------------------------------------------------------


def outcomes(*numbers: int, faults: Any = None) -> Outcomes:
    values = np.array([[[float(n)], [n + 0.5]] for n in numbers]).reshape(-1, 2, 1)
    return Outcomes(np.array(numbers, dtype=np.int64), values, faults or {})


def kept(of: Ledger, below: int = 99) -> tuple[list[int], dict[tuple[int, int], str]]:
    found = of.outcomes(below)
    assert found.values.ravel().tolist() == outcomes(*found.numbers.tolist()).values.ravel().tolist()
    return found.numbers.tolist(), found.faults


def test_a_ledger_keeps_each_run_once_in_the_order_of_numbers(tmp_path: Path) -> None:
    book = Ledger(tmp_path / "a.sqlite", ["bias"], 2, {"seed": "1"})
    book.keep([outcomes(7, 3, 4, faults={(4, 1): "lost"}), outcomes(0)])
    assert kept(book) == ([0, 3, 4, 7], {(4, 1): "lost"})
    book.keep([outcomes(2, 3, 5, 8, faults={(3, 0): "again", (8, 0): "late"})])
    assert kept(book) == ([0, 2, 3, 4, 5, 7, 8], {(4, 1): "lost", (8, 0): "late"})
    assert kept(book, 5) == ([0, 2, 3, 4], {(4, 1): "lost"})
    assert kept(book, 4) == ([0, 2, 3], {})
    book.keep([outcomes()])
    book.close()
    again = Ledger(tmp_path / "a.sqlite", ["bias"], 2, {"seed": "1"})
    assert kept(again)[0] == [0, 2, 3, 4, 5, 7, 8]
    again.close()
    with pytest.raises(ModelError, match="belongs to another seed") as refused:
        Ledger(tmp_path / "a.sqlite", ["bias"], 2, {"seed": "2"})
    assert refused.value.problems[0].got == "-1; +2"


def test_a_row_that_was_changed_is_found_and_the_others_are_kept(tmp_path: Path) -> None:
    path = tmp_path / "a.sqlite"
    book = Ledger(path, ["bias"], 2, FACTS)
    book.keep([outcomes(0, 1, faults={(1, 0): "lost"}), outcomes(5, 6)])
    book._data.execute("UPDATE stretches SET faults = '[[5, 0, \"x\"]]' WHERE first = 5")
    with pytest.raises(ModelError, match="is damaged") as refused:
        book.outcomes(9)
    assert refused.value.problems[0].got == "the row of the runs from 5 on differs from its check sum"
    book.close()
    repair(path, ["bias"], 2, FACTS)
    anew = Ledger(path, ["bias"], 2, FACTS)
    assert kept(anew) == ([0, 1], {(1, 0): "lost"})
    anew.close()
    assert (tmp_path / "a.damaged").exists()
    with pytest.raises(ModelError, match="holds no whole run"):
        repair(path, ["bias"], 2, {"graph": "another"})


def test_lines_that_differ_are_told_up_to_six() -> None:
    assert ledgers._difference("a\nb\nc", "a\nx\nc") == "-b; +x"
    assert ledgers._difference("1\n2\n3", "4\n5\n6") == "-1; -2; -3; +4; +5; +6"
    assert ledgers._difference("1\n2\n3\n9", "4\n5\n6\n8").endswith("+5; ...")
    assert ledgers._difference("a", "a") == ""
    assert ledgers._spelt_out([(3, 2), (9, 1)]).tolist() == [3, 4, 9]
    assert ledgers._spelt_out([]).tolist() == []


def filled(
    seconds: deque[float], monkeypatch: pytest.MonkeyPatch
) -> tuple[list[list[int]], list[tuple[int, int, str]]]:
    """What is written, batch by batch, and what is said: 3 of 10 runs are there, and parts of 2, 4 and 4 arrive."""
    written, said, counted = list[list[int]](), list[tuple[int, int, str]](), list[int]()
    book: Any = SimpleNamespace(keep=lambda batch: written.append([len(one.numbers) for one in batch]))
    means: Any = SimpleNamespace(end=10, add=lambda one: counted.append(len(one.numbers)), text=lambda: f"{counted}")
    monkeypatch.setattr(whole.time, "perf_counter", seconds.popleft)

    def source(left: Any, means: Any, interrupted: Any) -> Any:
        for size in (2, 4, 4):
            yield outcomes(*range(size))

    whole._fill(book, source, np.arange(7), means, lambda *now: said.append(now))
    return written, said


def test_runs_are_written_in_batches_and_never_more_than_all_are_done(monkeypatch: pytest.MonkeyPatch) -> None:
    """The clock says 0.1 s, 0.3 s and 0.4 s; a fifth of a second after the last writing the next one is due."""
    written, said = filled(deque([0.0, 0.1, 0.3, 0.3, 0.4]), monkeypatch)
    assert written == [[2, 4], [4]]
    assert said == [(9, 10, "[2, 4]"), (10, 10, "[2, 4, 4]")]


def test_little_is_written_at_the_end(monkeypatch: pytest.MonkeyPatch) -> None:
    written, said = filled(deque([0.0, 0.1, 0.2, 0.2]), monkeypatch)
    assert written == [[2, 4, 4]]
    assert said == [(10, 10, "[2, 4, 4]")]
    assert math.isclose(whole.BATCH_SECONDS, 0.2)
