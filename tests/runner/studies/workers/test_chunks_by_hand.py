"""Chunks of a study on a cluster that was made by hand: which begin, arrive, are tried alone, or are cancelled."""

import threading
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from distributed import KilledWorker
from distributed.client import FutureCancelledError

from proofmass.runner.run.faults import RunError
from proofmass.runner.studies.workers import chunks
from proofmass.runner.studies.workers.chunks import _Chunks

WORKER: Any = SimpleNamespace(address="tcp://w:1")


class Arriving:
    """A chunk that arrives after some looks, or whose worker dies, or that fails."""

    def __init__(self, some: tuple[int, ...], looks: int, error: Exception | None) -> None:
        self.some, self.looks, self.error = some, looks, error

    def done(self) -> bool:
        self.looks -= 1
        return self.looks <= 0

    def result(self) -> Any:
        if self.error is not None:
            raise self.error
        return 0.25, self.some


class Cluster:
    """Workers with their threads; `fate` gives looks and error of a chunk by its first run."""

    def __init__(self, fate: Any = None, **threads: int) -> None:
        self.fate, self.threads = fate or (lambda first, count: (1, None)), threads
        self.begun, self.cancelled, self.most = list[tuple[int, ...]](), list[Any](), 0

    def submit(self, work: Any, parcel: Any, some: tuple[int, ...], pure: bool) -> Arriving:
        assert not pure
        self.begun.append(some)
        return Arriving(some, *self.fate(some[0], self.begun.count(some)))

    def nthreads(self) -> dict[str, int]:
        return self.threads

    def cancel(self, futures: list[Any]) -> None:
        self.cancelled = [future.some for future in futures]


def chunks_of(cluster: Cluster, runs: int = 9, lanes: int = 2) -> tuple[_Chunks, list[str]]:
    lost = list[str]()
    return _Chunks(cluster, SimpleNamespace(), lanes, "tcp://a:1", np.arange(runs), lost), lost  # type: ignore[arg-type]


def arrived(made: _Chunks, enough_after: int = 99, interrupted_after: int = 99) -> list[tuple[int, ...]]:
    found, stop = list[tuple[int, ...]](), threading.Event()
    means: Any = SimpleNamespace(enough=False)
    for outcomes in made.runs(means, stop):
        found.append(outcomes)  # type: ignore[arg-type]
        means.enough = len(found) >= enough_after
        if len(found) >= interrupted_after:
            stop.set()
    return found


@pytest.fixture(autouse=True)
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(chunks, "LOOKS", 1e-4)
    monkeypatch.setattr(chunks, "COUNTS", 0.0)


def test_each_thread_has_two_chunks_of_whole_lanes() -> None:
    """Two lanes of a thread: two chunks of two runs; they take a quarter of a second, so that their size stays."""
    cluster = Cluster(a=1)
    made, lost = chunks_of(cluster)
    assert arrived(made) == [(0, 1), (2, 3), (4, 5), (6, 7), (8,)]
    assert cluster.begun == [(0, 1), (2, 3), (4, 5), (6, 7), (8,)]
    assert (cluster.cancelled, lost) == ([], [])


@pytest.mark.parametrize(("threads", "under_way"), [({"a": 1}, 2), ({"a": 2, "b": 1}, 6), ({}, 1)])
def test_as_many_chunks_are_under_way_as_keep_all_threads_busy(threads: dict[str, int], under_way: int) -> None:
    cluster = Cluster(lambda first, count: (1 if first == 0 else 99, None), **threads)
    made, _ = chunks_of(cluster, 40)
    made._submit()
    assert len(cluster.begun) == under_way
    made._submit()
    assert len(cluster.begun) == under_way


@pytest.mark.parametrize("how", ["enough_after", "interrupted_after"])
def test_what_is_not_wanted_any_more_is_cancelled(how: str) -> None:
    """The first chunk arrives at once, the second would after four looks."""
    cluster = Cluster(lambda first, count: (1 if first == 0 else 4, None), a=1)
    made, _ = chunks_of(cluster)
    assert arrived(made, **{how: 1}) == [(0, 1)]
    assert cluster.cancelled == [(2, 3)]


def test_a_chunk_whose_worker_died_is_tried_alone_and_then_named() -> None:
    def fate(first: int, count: int) -> tuple[int, Exception | None]:
        return 1, KilledWorker("task", WORKER, 3) if first == 2 and count < 2 else None

    cluster = Cluster(fate, a=1)
    made, _ = chunks_of(cluster)
    assert arrived(made) == [(0, 1), (4, 5), (6, 7), (8,), (2, 3)]
    deadly = Cluster(lambda first, count: (1, KilledWorker("task", WORKER, 3) if first == 2 else None), a=1)
    made, _ = chunks_of(deadly, 4)
    with pytest.raises(RunError, match="workers die as they begin with runs 2 to 3") as failed:
        arrived(made)
    assert failed.value.problem.hint == "replay one of them alone: --run 2"
    assert failed.value.problem.key == "tcp://a:1"


def test_after_three_suspects_no_other_chunk_begins_before_they_are_tried() -> None:
    """Of ten chunks those of the runs 0, 2 and 4 are lost at first."""

    def fate(first: int, count: int) -> tuple[int, Exception | None]:
        return 1, KilledWorker("task", WORKER, 3) if first < 6 and count < 2 else None

    cluster = Cluster(fate, a=1)
    made, _ = chunks_of(cluster, 20)
    assert len(arrived(made)) == 10
    again = [place for place, some in enumerate(cluster.begun) if some in cluster.begun[:place]]
    assert cluster.begun[again[0]] == (0, 1)
    assert again[0] <= 5


@pytest.mark.parametrize(
    ("error", "said", "got"),
    [
        (FutureCancelledError("key", "lost"), "the scheduler dropped the study", None),
        (ValueError("two\n lines"), "a worker could not do runs 0 to 1", "ValueError: two lines"),
        (OSError("gone"), "a worker could not do runs 0 to 1", "OSError: gone"),
    ],
)
def test_failures_are_named(error: Exception, said: str, got: str | None) -> None:
    made, _ = chunks_of(Cluster(lambda first, count: (1, error), a=1))
    with pytest.raises(RunError) as failed:
        arrived(made)
    assert failed.value.problem.message == said
    assert got in (None, failed.value.problem.got)


def test_a_connection_that_is_lost() -> None:
    cluster = Cluster(a=1)
    cluster.nthreads = lambda: (_ for _ in ()).throw(OSError("gone"))  # type: ignore[method-assign]
    with pytest.raises(RunError, match="the connection to the scheduler is lost"):
        arrived(chunks_of(cluster)[0])


def test_workers_that_go_away_are_named_and_none_for_long_ends_the_study(monkeypatch: pytest.MonkeyPatch) -> None:
    now = [0.0]
    monkeypatch.setattr(chunks.time, "monotonic", lambda: now[0])
    cluster = Cluster(b=1, a=2)
    made, lost = chunks_of(cluster)
    made._count_threads()
    cluster.threads = {"c": 1}
    now[0] = 50.0
    made._count_threads()
    assert lost == ["a", "b"]
    cluster.threads = {}
    for moment in (51.0, 110.0):
        now[0] = moment
        made._count_threads()
    assert lost == ["a", "b", "c"]
    now[0] = 110.5
    with pytest.raises(RunError, match="the scheduler has had no workers for 60 s"):
        made._count_threads()


def test_workers_are_counted_once_a_second(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(chunks, "COUNTS", 1.0)
    now = [0.0]
    monkeypatch.setattr(chunks.time, "monotonic", lambda: now[0])
    cluster = Cluster(a=1)
    made, _ = chunks_of(cluster)
    made._count_threads()
    cluster.threads = {"a": 5}
    for moment, threads in ((0.5, 1), (0.99, 1), (1.0, 5)):
        now[0] = moment
        made._count_threads()
        assert made._threads == threads
