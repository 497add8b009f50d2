"""Dask workers that are killed at random instants lose, double and change no run.

`PROOFMASS_KILLS=20 pytest tests/crash/test_killed_workers.py -s` kills as often, in 500 chunks.
"""

import os
import random
import signal
import threading
import time
from pathlib import Path

import pytest
from distributed import LocalCluster
from distributed.core import Status

from proofmass.graphs.study_reader import read_study
from proofmass.runner.studies import chunks
from proofmass.runner.studies.ledger import FILE
from proofmass.runner.studies.study import run_study
from tests.kept_runs import kept
from tests.study_texts import STUDY

KILLS = int(os.environ.get("PROOFMASS_KILLS", "2"))
CHUNKS = 25  # per kill, of one run each
LATER = 0.3  # seconds, at most, from the chunk after which a worker is killed


def at_work(workers: LocalCluster) -> list[int]:
    """Processes of workers that have started; Dask gives up one that dies while it starts."""
    nannies = [nanny for nanny in workers.workers.values() if nanny.worker_address in workers.scheduler.workers]
    return [nanny.pid for nanny in nannies if nanny.process is not None and nanny.process.status == Status.running]


def test_killed_workers(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(chunks, "chunk_size", lambda *_: 1)
    path = tmp_path / "study.toml"
    path.write_text(STUDY)
    study = read_study(path).changed(runs=CHUNKS * KILLS // 2, seed=1)
    ended, killed, dice, arrived = threading.Event(), list[int](), random.Random(3), list[int]([0])

    def kill(workers: LocalCluster) -> None:
        for number in range(KILLS):
            after = dice.uniform(CHUNKS * number, CHUNKS * (number + 1) - 5)
            while arrived[-1] < after and not ended.is_set():
                time.sleep(0.02)
            time.sleep(dice.uniform(0.0, LATER))
            while not (alive := [pid for pid in at_work(workers) if pid not in killed]) and not ended.is_set():
                time.sleep(0.02)
            if not ended.is_set():
                killed.append(dice.choice(alive))
                os.kill(killed[-1], signal.SIGKILL)

    expected = run_study(study, engine="python", folder=tmp_path / "here")
    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address="127.0.0.1:0") as workers:
        killer = threading.Thread(target=kill, args=(workers,))
        killer.start()
        made = run_study(
            study,
            engine="python",
            dask=workers.scheduler_address,
            folder=tmp_path / "there",
            progress=lambda done, *_: arrived.append(done),
        )
        ended.set()
        killer.join()
    print(f"{len(killed)} workers killed in {len(made.numbers)} chunks")
    assert len(killed) == KILLS
    assert made.digest == expected.digest
    assert kept(tmp_path / "there" / FILE) == kept(tmp_path / "here" / FILE)
