"""Ledgers that are read beside damaged rows, and where nothing may be written."""

import os
from pathlib import Path

import pytest
from scipy.stats import t as student

from proofmass.runner.studies.kept.folder import last_result
from proofmass.runner.studies.kept.ledger import FILE, Ledger, whole_stretches
from proofmass.runner.studies.outcome.outcomes import SensorRun, outcomes_of
from proofmass.runner.studies.whole.study import run_study
from tests.by_hand.study_texts import STUDY

STOPPED = """\
name = "level"
rate = "1 kHz"
samples = 3
blocks.level = {{ kind = "Constant", value = "1 V", unit = "V" }}
measures.mean = {{ signal = "level.output", statistic = "mean" }}
[study]
runs = 200
seed = 7
{stop}
[study.spread]
"level.value" = {{ normal = "0.5 V" }}
"""


@pytest.mark.parametrize("bad", [set(), {5}, {0, 9}, {3, 4, 5}, set(range(10))])
@pytest.mark.parametrize("first", [0, 1000])
def test_all_but_the_damaged_rows_are_read(tmp_path: Path, bad: set[int], first: int) -> None:
    """Each run once."""
    ledger = Ledger(tmp_path / FILE, ["bias"], 1, {"graph": "a"})
    for number in range(first, first + 10):
        ledger.keep([outcomes_of([SensorRun(number, 0, (0.5,))], 1, 1)])
    for number in bad:
        ledger._data.execute("UPDATE stretches SET faults = 'x' WHERE first = ?", (first + number,))
    ledger.close()
    kept = [int(n) for part in whole_stretches(tmp_path / FILE, 1, 1, {"graph": "a"}) for n in part.numbers]
    assert kept == [first + n for n in range(10) if n not in bad]


@pytest.mark.defect("S937", before="the yield within limits that the file no longer had", after="those of the file")
def test_the_result_of_a_file_has_its_limits(tmp_path: Path) -> None:
    """A mean of 819 codes, 1 V of 5 V in 12 bits, is below 900 and not below 100."""
    path, text = tmp_path / "study.toml", STUDY.partition("[study.limits]")[0]
    path.write_text(text + "[study.limits]\nbias = { at_most = 900 }\n")
    run_study(path, runs=1, engine="python", folder=tmp_path / "kept")
    path.write_text(text + "[study.limits]\nbias = { at_most = 100 }\n")
    folder, result = last_result(path)
    assert folder == tmp_path / "kept"
    assert result.yields() == {"bias": 0.0, "all limits": 0.0}


@pytest.mark.defect("S955", before="the runs and the precision of the last command", after="those of the file's stop")
def test_the_result_of_a_file_ends_where_its_stop_says(tmp_path: Path) -> None:
    """A mean of n sensors is known to t s / sqrt(n), Student's t (Fisher 1925): to 0.1 V here after fewer than 200."""
    path = tmp_path / "study.toml"
    path.write_text(STOPPED.format(stop=""))
    values = run_study(path, engine="python", folder=tmp_path / "kept")["mean"][:, 0]
    known = [n for n in range(30, 200) if student.ppf(0.975, n - 1) * values[:n].std(ddof=1) / n**0.5 <= 0.1]
    path.write_text(STOPPED.format(stop='stop = { mean = "0.1 V" }'))
    _, result = last_result(path)
    assert result.planned_runs == len(result.numbers) == known[0] < 200
    assert result.study.stop == {"mean": 0.1}


@pytest.mark.defect("H879", before="unable to open database file: its runs are safe, repeat", after="it is read")
def test_a_ledger_where_nothing_may_be_written_is_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A study in an archive: SQLite would want two files beside the ledger."""
    written = Ledger(tmp_path / FILE, ["bias"], 1, {"graph": "a"})
    written.keep([outcomes_of([SensorRun(3, 0, (0.5,))], 1, 1)])
    written.close()
    monkeypatch.setattr(os, "access", lambda path, mode: mode != os.W_OK)
    archived = Ledger(tmp_path / FILE, ["bias"], 1, {"graph": "a"})
    kept = archived.outcomes(10)
    beside = list(tmp_path.iterdir())
    archived.close()
    assert kept.values.tolist() == [[[0.5]]]
    assert beside == [tmp_path / FILE]


@pytest.mark.defect("S1041", before="its runs are safe, where none was written", after="no run is kept")
@pytest.mark.parametrize(
    ("pragma", "said"),
    [("PRAGMA max_page_count = 1", "full"), ("PRAGMA query_only = 1", "readonly")],
)
def test_no_run_is_said_to_be_safe_where_none_is(pragma: str, said: str, tmp_path: Path) -> None:
    ledger = Ledger(tmp_path / FILE, ["bias"], 1, {"graph": "a"})
    ledger._data.execute(pragma)
    many = [outcomes_of((SensorRun(run, 0, (float(run),)) for run in range(5000)), 1, 1)]
    with pytest.raises(OSError, match=f"{said}.*; no run is kept: repeat the command once this is cured"):
        ledger.keep(many)
    ledger.close()


def test_of_a_ledger_that_cannot_be_opened_nothing_is_said(tmp_path: Path) -> None:
    with pytest.raises(OSError, match="unable to open database file; repeat the command"):
        Ledger(tmp_path / "none" / FILE, ["bias"], 1, {"graph": "a"})
