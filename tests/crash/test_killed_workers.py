"""Dask workers that are killed at random instants lose, double and change no run.

`PROOFMASS_KILLS=20 pytest tests/crash/test_killed_workers.py -s` kills as often, in 500 chunks.
"""

import os
import random
import signal
import threading
from pathlib import Path

import pytest
from distributed import LocalCluster

from proofmass.graphs.study_reader import read_study
from proofmass.runner.studies import chunks
from proofmass.runner.studies.ledger import FILE
from proofmass.runner.studies.study import run_study
from tests.graph_texts import changed
from tests.kept_runs import kept
from tests.study_texts import STUDY

KILLS = int(os.environ.get("PROOFMASS_KILLS", "2"))
CHUNKS = 25  # per kill, of one run each
PAUSE = 0.4, 1.2  # seconds from one kill to the next


def test_killed_workers(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(chunks, "chunk_size", lambda *_: 1)
    path = tmp_path / "study.toml"
    path.write_text(changed(STUDY, "samples = 60", "samples = 240"))
    study = read_study(path).changed(runs=CHUNKS * KILLS // 2, seed=1)
    stop, killed, dice = threading.Event(), list[int](), random.Random(3)

    def kill(workers: LocalCluster) -> None:
        while len(killed) < KILLS and not stop.wait(dice.uniform(*PAUSE)):
            alive = [worker.pid for worker in workers.workers.values() if worker.pid and worker.pid not in killed]
            if alive:
                killed.append(dice.choice(alive))
                os.kill(killed[-1], signal.SIGKILL)

    expected = run_study(study, engine="python", folder=tmp_path / "here")
    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address="127.0.0.1:0") as workers:
        killer = threading.Thread(target=kill, args=(workers,))
        killer.start()
        made = run_study(study, engine="python", dask=workers.scheduler_address, folder=tmp_path / "there")
        stop.set()
        killer.join()
    print(f"{len(killed)} workers killed in {len(made.numbers)} chunks")
    assert len(killed) > 1, "nothing was killed on its way"
    assert made.digest == expected.digest
    assert kept(tmp_path / "there" / FILE) == kept(tmp_path / "here" / FILE)
