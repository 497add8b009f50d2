"""A study that is killed at random instants loses, doubles and changes no run; disks that refuse are said clearly.

`PROOFMASS_KILLS=200 pytest tests/crash/test_killed_studies.py -s --exhaustive` kills as often: studies of one
process, and of one with two workers.
"""

import os
import random
import signal
import sqlite3
import subprocess
import sys
import time
from pathlib import Path

import pytest

from proofmass.graphs.studies.study_reader import read_study
from proofmass.runner.studies.kept.ledger import FILE, Ledger
from proofmass.runner.studies.outcome.outcomes import SensorRun, outcomes_of
from proofmass.runner.studies.whole.study import run_study
from tests.by_hand.amounts import amounts
from tests.by_hand.kept_runs import kept
from tests.by_hand.little_disk import little_room
from tests.by_hand.study_texts import STUDY

KILLS = int(os.environ.get("PROOFMASS_KILLS", "20"))
START = 0.4  # seconds in which a study has hardly begun
LONGEST = 1.5  # seconds that a study lives before it is killed
LONGEST_OF_WORKERS = 0.6  # seconds that one with workers does, after it has gone on


def command(path: Path, folder: Path, runs: int) -> list[str]:
    words = [sys.executable, "-m", "proofmass", "montecarlo", str(path), "--runs", str(runs), "--engine", "python"]
    return [*words, "--quiet", "--out", str(folder)]


@pytest.mark.parametrize("kills", amounts(2, KILLS))
@pytest.mark.parametrize(
    "more",
    [
        pytest.param([], id="alone"),
        pytest.param(["--dask", "local:2"], id="with two workers", marks=pytest.mark.exhaustive),
    ],
)
def test_killed_at_random_instants(more: list[str], kills: int, tmp_path: Path) -> None:
    path, folder, dice = tmp_path / "study.toml", tmp_path / "out", random.Random(7)
    path.write_text(STUDY)
    runs = (10 if more else 24) * (kills + 1)
    expected = run_study(read_study(path), runs=runs, folder=tmp_path / "whole")
    killed, before = 0, dict[int, bytes]()
    while killed < kills:
        words = [*command(path, folder, runs), *more]
        process = subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
        if more and dice.random() < 0.75:  # workers take a while to start
            wait_for_more(process, folder / FILE, len(before))
            time.sleep(dice.uniform(0.0, LONGEST_OF_WORKERS))
        else:
            time.sleep(dice.uniform(START, LONGEST))
        if process.poll() is not None:
            process.communicate()
            break  # it has ended before
        process.send_signal(signal.SIGKILL)
        process.communicate()
        killed += 1
        now = kept(folder / FILE)
        assert before.items() <= now.items(), "a run lost or changed"
        before = now
    print(f"{killed} kills, {len(before)} runs before the last one")
    assert killed > 1
    assert run_study(read_study(path), runs=runs, engine="python", folder=folder).digest == expected.digest
    assert kept(folder / FILE) == kept(tmp_path / "whole" / FILE)


def wait_for_more(process: "subprocess.Popen[bytes]", path: Path, before: int) -> None:
    """Until the ledger has more rows than before, or the process has ended."""
    while process.poll() is None and len(kept(path)) <= before:
        time.sleep(0.05)


@pytest.mark.exhaustive
def test_a_full_disk_is_said_and_the_study_goes_on_when_there_is_room(tmp_path: Path) -> None:
    path, folder = tmp_path / "study.toml", tmp_path / "out"
    path.write_text(STUDY)
    arguments = command(path, folder, 100)
    full = subprocess.run(arguments, capture_output=True, text=True, check=False, **little_room(40_000))
    assert full.returncode == 3, full.stderr
    assert f"cannot write or read {folder / FILE}: " in full.stderr
    assert "its runs are safe: repeat the command once this is cured" in full.stderr
    assert "Traceback" not in full.stderr
    done = kept(folder / FILE)
    whole = run_study(read_study(path), runs=100, engine="python", folder=folder)
    assert whole.digest == run_study(read_study(path), runs=100, engine="python").digest
    assert 0 < len(done) < 200
    assert done.items() < kept(folder / FILE).items()


@pytest.mark.parametrize(
    ("pragma", "said"),
    [("PRAGMA max_page_count = 1", "full"), ("PRAGMA query_only = 1", "readonly")],
)
def test_a_ledger_that_cannot_be_written_to(pragma: str, said: str, tmp_path: Path) -> None:
    first = Ledger(tmp_path / FILE, ("bias",), 1, {"graph": "a"})
    first.keep([outcomes_of([SensorRun(0, 0, (1.5,))], 1, 1)])
    first._data.execute(pragma)
    many = [outcomes_of((SensorRun(run, 0, (float(run),)) for run in range(1, 5000)), 1, 1)]
    with pytest.raises(OSError, match=said) as caught:
        first.keep(many)
    assert caught.value.filename == str(tmp_path / FILE)
    assert "its runs are safe: repeat" in str(caught.value)
    first.close()
    again = Ledger(tmp_path / FILE, ("bias",), 1, {"graph": "a"})
    assert again.outcomes(10).values.tolist() == [[[1.5]]]
    again.keep(many)
    assert again.outcomes(10**6).numbers.tolist() == list(range(5000))
    again.close()


@pytest.mark.exhaustive
def test_a_folder_that_is_none(tmp_path: Path) -> None:
    (tmp_path / "study.toml").write_text(STUDY)
    (tmp_path / "out").write_text("")
    words = command(tmp_path / "study.toml", tmp_path / "out" / "deeper", 2)
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    assert done.returncode == 3
    assert "cannot write or read" in done.stderr
    assert "Traceback" not in done.stderr


def test_a_ledger_in_use_is_waited_for_and_then_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    first = Ledger(tmp_path / FILE, ("bias",), 1, {"graph": "a"})
    first._data.execute("BEGIN IMMEDIATE")
    connect = sqlite3.connect
    monkeypatch.setattr(sqlite3, "connect", lambda *words, **more: connect(*words, **more, timeout=0.05))
    with pytest.raises(OSError, match="locked"):
        Ledger(tmp_path / FILE, ("bias",), 1, {"graph": "a"})
    first.close()
