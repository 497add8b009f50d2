"""Dask workers that are killed at random instants lose, double and change no run.

`PROOFMASS_KILLS=20 pytest tests/crash/test_killed_workers.py -s` kills as often, in 500 chunks.
"""

import os
import random
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from distributed import LocalCluster

from proofmass.graphs.studies.study_reader import read_study
from proofmass.runner.studies.kept.ledger import FILE
from proofmass.runner.studies.whole import study as study_module
from proofmass.runner.studies.whole.study import run_study
from proofmass.runner.studies.workers import chunks
from tests.by_hand.kept_runs import kept
from tests.by_hand.study_texts import STUDY

KILLS = int(os.environ.get("PROOFMASS_KILLS", "2"))
CHUNKS = 25  # per kill, of one run each
LAST = 5  # of them, which wait until a worker has been killed and another has come
LATER = 0.1  # seconds, at most, from the chunk after which a worker is killed


def started(address: str) -> "subprocess.Popen[bytes]":
    """A worker of one thread, with nobody to start it again: Dask's own nannies give up workers that die early."""
    words = [sys.executable, "-m", "dask", "worker", address, "--nthreads", "1", "--no-nanny", "--no-dashboard"]
    return subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


@pytest.mark.exhaustive  # a storm of kills
def test_killed_workers(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(chunks, "chunk_size", lambda *_: 1)
    monkeypatch.setattr(study_module, "BATCH_SECONDS", 0.0)  # progress after every chunk
    path = tmp_path / "study.toml"
    path.write_text(STUDY)
    study = read_study(path).changed(runs=CHUNKS * KILLS // 2, seed=1)
    ended, killed, dice, arrived = threading.Event(), list[int](), random.Random(3), list[int]([0])

    def until(there: Callable[[], object]) -> None:
        while not there() and not ended.is_set():
            time.sleep(0.01)

    def kill(workers: "list[subprocess.Popen[bytes]]", scheduler: Any, after: float) -> None:
        """One of them, once so many chunks have arrived; another is started, and waited for."""
        until(lambda: len(scheduler.workers) == len(workers) and arrived[-1] >= after)
        time.sleep(dice.uniform(0.0, LATER))
        place, known = dice.randrange(len(workers)), set(scheduler.workers)
        workers[place].kill()
        died = workers[place].wait()
        workers[place] = started(scheduler.address)
        until(lambda: set(scheduler.workers) - known)
        killed.append(died)

    def kill_all(workers: "list[subprocess.Popen[bytes]]", scheduler: Any) -> None:
        for first in range(0, CHUNKS * KILLS, CHUNKS):
            if not ended.is_set():
                kill(workers, scheduler, dice.uniform(first, first + CHUNKS - LAST))

    def hold(done: int, *_: object) -> None:
        """The study goes on to the next kill's chunks when this one has been done."""
        arrived.append(done)
        while len(killed) < (done + LAST) // CHUNKS and killer.is_alive():
            time.sleep(0.01)

    expected = run_study(study, engine="python", folder=tmp_path / "here")
    with LocalCluster(n_workers=0, dashboard_address="127.0.0.1:0") as cluster:
        address = cluster.scheduler_address
        workers = [started(address) for _ in range(2)]
        killer = threading.Thread(target=kill_all, args=(workers, cluster.scheduler))
        killer.start()
        try:
            made = run_study(study, engine="python", dask=address, folder=tmp_path / "there", progress=hold)
        finally:
            ended.set()
            killer.join()
            for worker in workers:
                worker.kill()
                worker.wait()
    print(f"{len(killed)} workers killed in {len(made.numbers)} chunks")
    assert killed == [-signal.SIGKILL] * KILLS
    assert len(made.numbers) == CHUNKS * KILLS
    assert made.digest == expected.digest
    assert kept(tmp_path / "there" / FILE) == kept(tmp_path / "here" / FILE)
