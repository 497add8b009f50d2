"""Dask workers that are killed at random instants lose, double and change no run.

`PROOFMASS_KILLS=20 pytest tests/crash/test_killed_workers.py -s` kills as often, in 500 chunks.
"""

import os
import random
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest
from distributed import LocalCluster

from proofmass.graphs.study_reader import read_study
from proofmass.runner.studies import chunks
from proofmass.runner.studies.ledger import FILE
from proofmass.runner.studies.study import run_study
from tests.kept_runs import kept
from tests.study_texts import STUDY

KILLS = int(os.environ.get("PROOFMASS_KILLS", "2"))
CHUNKS = 25  # per kill, of one run each
LATER = 0.3  # seconds, at most, from the chunk after which a worker is killed


def started(address: str) -> "subprocess.Popen[bytes]":
    """A worker of one thread, with nobody to start it again: Dask's own nannies give up workers that die early."""
    words = [sys.executable, "-m", "dask", "worker", address, "--nthreads", "1", "--no-nanny", "--no-dashboard"]
    return subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def test_killed_workers(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(chunks, "chunk_size", lambda *_: 1)
    path = tmp_path / "study.toml"
    path.write_text(STUDY)
    study = read_study(path).changed(runs=CHUNKS * KILLS // 2, seed=1)
    ended, killed, dice, arrived = threading.Event(), list[int](), random.Random(3), list[int]([0])

    def kill(workers: "list[subprocess.Popen[bytes]]", address: str) -> None:
        for number in range(KILLS):
            after = dice.uniform(CHUNKS * number, CHUNKS * (number + 1) - 5)
            while arrived[-1] < after and not ended.is_set():
                time.sleep(0.02)
            time.sleep(dice.uniform(0.0, LATER))
            if not ended.is_set():
                place = dice.randrange(len(workers))
                workers[place].kill()
                killed.append(workers[place].wait())
                workers[place] = started(address)

    expected = run_study(study, engine="python", folder=tmp_path / "here")
    with LocalCluster(n_workers=0, dashboard_address="127.0.0.1:0") as cluster:
        workers = [started(cluster.scheduler_address) for _ in range(2)]
        killer = threading.Thread(target=kill, args=(workers, cluster.scheduler_address))
        killer.start()
        try:
            made = run_study(
                study,
                engine="python",
                dask=cluster.scheduler_address,
                folder=tmp_path / "there",
                progress=lambda done, *_: arrived.append(done),
            )
        finally:
            ended.set()
            killer.join()
            for worker in workers:
                worker.kill()
                worker.wait()
    print(f"{len(killed)} workers killed in {len(made.numbers)} chunks")
    assert len(killed) >= max(1, KILLS - 2), "the study ended before"
    assert made.digest == expected.digest
    assert kept(tmp_path / "there" / FILE) == kept(tmp_path / "here" / FILE)
