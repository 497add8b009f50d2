"""Ledgers and checkpoints whose bytes were changed: the same digest in the end, or a message that names the file.

Damages are a bit, a byte, a cut, two stretches swapped, a garbage page, and a file from an earlier run.
"""

import random
import shutil
import sqlite3
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.model.graph import Graph
from proofmass.graphs.studies.study import Study
from proofmass.graphs.studies.study_reader import read_study
from proofmass.runner.run import simulate as simulation
from proofmass.runner.run.checkpoint import FILE as CHECKPOINT
from proofmass.runner.run.result import Result
from proofmass.runner.run.simulate import simulate
from proofmass.runner.studies.kept.ledger import FILE as LEDGER
from proofmass.runner.studies.kept.ledger import Ledger, repair, whole_stretches
from proofmass.runner.studies.outcome.outcomes import Outcomes, SensorRun, outcomes_of
from proofmass.runner.studies.whole.study import run_study
from tests.runner.run.test_checkpoint import interrupt_after, made

FEW = 12
AMOUNTS = [FEW, pytest.param(1000, marks=pytest.mark.exhaustive)]
STUDY = """
name = "level"
rate = "1 kHz"
duration = "3 ms"
[blocks.level]
kind = "Constant"
value = 1.0
[measures]
mean = {{ signal = "level.output", statistic = "mean" }}
[study]
runs = 300
seed = {seed}
[study.spread]
"level.value" = {{ normal = 0.1 }}
"""


def damaged(data: bytes, earlier: bytes, dice: random.Random) -> bytes:
    """Return other bytes, in one of six ways."""
    place, other = dice.randrange(len(data)), dice.randrange(len(data))
    length = dice.choice((1, 8, 64, 4096))
    match dice.randrange(6):
        case 0:
            return data[:place] + bytes([data[place] ^ 1 << dice.randrange(8)]) + data[place + 1 :]
        case 1:
            return data[:place] + dice.randbytes(1) + data[place + 1 :]
        case 2:
            return data[:place]
        case 3:
            first, second = sorted((place, other))
            return data[:first] + data[second : second + length] + data[first + length :]
        case 4:
            page = place // 4096 * 4096
            return data[:page] + dice.randbytes(min(4096, len(data) - page)) + data[page + 4096 :]
        case _:
            return earlier[: len(data)] if dice.random() < 0.3 else earlier[:place] + data[place:]


class TestRuns:
    @pytest.fixture
    def folder(self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
        """The checkpoint of a run, and one of an earlier run with another seed."""
        monkeypatch.setattr(simulation, "CHUNK_BYTES", 700)
        for name, seed in (("now", 5), ("earlier", 6)):
            options = {"samples": 2000, "engine": "python", "folder": tmp_path / name}
            simulate(made(tmp_path), seed=seed, progress=interrupt_after(1200), **options)
        return tmp_path

    def go_on(self, graph: Graph, folder: Path) -> Result:
        return simulate(graph, samples=2000, engine="python", folder=folder, seed=5, resume=True)

    @pytest.mark.defect("S400", before="a changed digit, tick or row gives another digest", after="refused by its sum")
    @pytest.mark.parametrize("amount", AMOUNTS)
    def test_never_end_with_another_digest(self, folder: Path, amount: int) -> None:
        dice, graph, said = random.Random(400), made(folder), list[str]()
        whole = simulate(graph, samples=2000, engine="python", seed=5).digest
        names = [path.name for path in (folder / "now").iterdir()]
        for _ in range(amount):
            shutil.rmtree(folder / "tried", ignore_errors=True)
            shutil.copytree(folder / "now", folder / "tried")
            name = dice.choice([*names, CHECKPOINT])
            before = (folder / "now" / name).read_bytes()
            (folder / "tried" / name).write_bytes(damaged(before, (folder / "earlier" / name).read_bytes(), dice))
            try:
                assert self.go_on(graph, folder / "tried").digest == whole
            except ModelError as error:
                said.append(str(error))
        assert len(said) > (amount / 2 if amount > FEW else 0)
        assert all(str(folder / "tried" / CHECKPOINT) in text for text in said)

    def test_a_row_that_was_changed_is_named(self, folder: Path) -> None:
        path = folder / "now" / "sum.output.npy"
        values = np.load(path)
        values[17] *= 1.0 + 2.0**-52
        np.save(path, values)
        with pytest.raises(ModelError, match=r"damaged: sum\.output\.npy differs from its check sum"):
            self.go_on(made(folder), folder / "now")

    def test_a_checkpoint_without_sums_is_of_another_version(self, folder: Path) -> None:
        path = folder / "now" / CHECKPOINT
        path.write_text(path.read_text().replace('"version": 2', '"version": 1'))
        with pytest.raises(ModelError, match="has another form"):
            self.go_on(made(folder), folder / "now")


class TestStudies:
    @pytest.fixture
    def study(self, tmp_path: Path) -> Study:
        """A study that ran, in `now`, and one with another seed in `earlier`."""
        for name, seed in (("earlier", 6), ("now", 5)):
            path = tmp_path / f"{name}.toml"
            path.write_text(STUDY.format(seed=seed))
            study = read_study(path)
            for runs in range(20, 301, 20):
                run_study(study, runs=runs, engine="python", folder=tmp_path / name)
        return study

    def tried(self, folder: Path, change: Callable[[bytes], bytes]) -> Path:
        """Return a copy of the folder with a changed ledger."""
        shutil.rmtree(folder / "tried", ignore_errors=True)
        shutil.copytree(folder / "now", folder / "tried")
        (folder / "tried" / LEDGER).write_bytes(change((folder / "now" / LEDGER).read_bytes()))
        return folder / "tried"

    @pytest.mark.defect("S401", before="a bit of a row gives another digest", after="refused, or run again by --repair")
    @pytest.mark.defect("C400", before="a garbage page ends in a DatabaseError", after="named, with its cure")
    @pytest.mark.parametrize("amount", AMOUNTS)
    def test_never_end_with_another_digest(self, study: Study, tmp_path: Path, amount: int) -> None:
        dice, said, lost = random.Random(401), list[str](), list[str]()
        whole = run_study(study, engine="python").digest
        earlier = (tmp_path / "earlier" / LEDGER).read_bytes()
        for _ in range(amount):
            folder = self.tried(tmp_path, lambda data: damaged(data, earlier, dice))
            try:
                assert run_study(study, engine="python", folder=folder).digest == whole
            except ModelError as error:
                said.append(str(error))
                try:
                    assert run_study(study, engine="python", folder=folder, repair=True).digest == whole
                except ModelError as again:
                    lost.append(str(again))
        assert len(said) > (amount / 4 if amount > FEW else 0)
        assert all(str(tmp_path / "tried" / LEDGER) in text for text in said)
        assert all("holds no whole run" in text for text in lost)
        assert len(lost) < (len(said) / 2 if amount > FEW else amount)  # how long batches are follows the clock

    def test_a_changed_number_is_named_and_repaired(self, study: Study, tmp_path: Path) -> None:
        number = np.float64(run_study(study, engine="python")["mean"][123, 0]).tobytes()
        folder = self.tried(tmp_path, lambda data: data.replace(number, b"\1" + number[1:]))
        with pytest.raises(ModelError, match="the runs from 120 on differs from its check sum"):
            run_study(study, engine="python", folder=folder)
        whole = run_study(study, engine="python", folder=folder, repair=True)
        assert whole.digest == run_study(study, engine="python").digest
        assert (folder / "ledger.damaged").exists()


def test_what_is_whole_beside_a_damaged_row_is_kept(tmp_path: Path) -> None:
    path = tmp_path / LEDGER
    ledger = Ledger(path, ["m"], 1, {"graph": "a"})
    for first in range(0, 1000, 10):
        ledger.keep([outcomes_of([SensorRun(first + n, 0, (0.5,)) for n in range(10)], 1, 1)])
    ledger._data.execute("UPDATE stretches SET numbers = zeroblob(80) WHERE first = 420")
    ledger.close()
    kept = [int(n) for part in whole_stretches(path, 1, 1, {"graph": "a"}) for n in part.numbers]
    assert sorted(kept) == [n for n in range(1000) if not 420 <= n < 430]


@pytest.mark.defect(
    "S951", before="280 whole runs beyond the 20 asked for are dropped", after="all whole runs are kept"
)
def test_fewer_runs_do_not_drop_whole_ones(tmp_path: Path) -> None:
    path, text = tmp_path / "study.toml", STUDY.format(seed=5)
    path.write_text(text)
    study = read_study(path)
    for runs in range(20, 301, 20):
        run_study(study, runs=runs, engine="python", folder=tmp_path / "now")
    ledger = tmp_path / "now" / LEDGER
    eighth = np.float64(run_study(study, runs=8, engine="python")["mean"][7, 0]).tobytes()
    ledger.write_bytes(ledger.read_bytes().replace(eighth, b"\1" + eighth[1:]))
    assert len(run_study(study, runs=20, engine="python", folder=tmp_path / "now", repair=True).numbers) == 20
    with sqlite3.connect(ledger) as kept:
        assert kept.execute("SELECT sum(runs) FROM stretches").fetchone() == (300,)
    kept.close()


@pytest.mark.defect("S952", before="one page above the others is damaged: holds no whole run", after="all are kept")
@pytest.mark.defect("H890", before="16 s to find none of 200,000 runs", after="as long as it takes to read the file")
@pytest.mark.parametrize("runs", [20, 2000], ids=["many rows on a page", "a row on many pages"])
def test_rows_below_a_damaged_page_are_kept(tmp_path: Path, runs: int) -> None:
    """A page of type 5 leads to others; a damaged one hides what it leads to, which is whole."""
    path, facts = tmp_path / LEDGER, {"graph": "a"}
    ledger = Ledger(path, ["m"], 1, facts)
    for first in range(0, 100 * runs, runs):
        values = np.arange(first, first + runs, dtype=float).reshape(runs, 1, 1)
        ledger.keep([Outcomes(np.arange(first, first + runs), values, {})])
    ledger.close()
    data = bytearray(path.read_bytes())
    above = [page for page in range(4096, len(data), 4096) if data[page] == 5]
    for page in above:
        data[page : page + 4096] = bytes(4096)
    path.write_bytes(data)
    repair(path, ["m"], 1, facts)
    anew = Ledger(path, ["m"], 1, facts)
    kept = anew.outcomes(100 * runs)
    anew.close()
    assert above
    assert kept.numbers.tolist() == kept.values.ravel().tolist() == list(range(100 * runs))


def test_runs_in_the_log_of_a_killed_process_are_kept(tmp_path: Path) -> None:
    """What is copied while the ledger is open has its rows in the log; one cut off there has those before."""
    ledger = Ledger(tmp_path / LEDGER, ["m"], 1, {"graph": "a"})
    for first in range(4):
        ledger.keep([outcomes_of([SensorRun(first, 0, (0.5,))], 1, 1)])
    killed = tmp_path / "killed.sqlite"
    killed.write_bytes((tmp_path / LEDGER).read_bytes())
    log = (tmp_path / f"{LEDGER}-wal").read_bytes()
    ledger.close()
    for cut, runs in ((len(log), 4), (len(log) - 1, 3)):
        (tmp_path / "killed.sqlite-wal").write_bytes(log[:cut])
        kept = {int(n) for part in whole_stretches(killed, 1, 1, {"graph": "a"}) for n in part.numbers}
        assert kept == set(range(runs))
