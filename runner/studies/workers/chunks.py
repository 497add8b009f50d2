"""Runs of a study on Dask workers, in chunks; each arrives here once, even if workers die.

Dask promises that a task is done at least once. A chunk is waited for here until it arrives, and
counts when it does; the ledger is written by this process alone.
"""

import threading
import time
from collections.abc import Generator, Iterator
from typing import Any, cast

from proofmass.blocks.declaration.problem import Problem
from proofmass.runner.host.arrays import AnyArray
from proofmass.runner.run.faults import RunError
from proofmass.runner.studies.outcome.outcomes import Outcomes
from proofmass.runner.studies.outcome.running_means import RunningMeans
from proofmass.runner.studies.runs.sensor_runs import SensorRuns
from proofmass.runner.studies.workers.cluster import connected
from proofmass.runner.studies.workers.parcel import Parcel, packed
from proofmass.runner.studies.workers.worker import run_chunk

CHUNK_SECONDS = 0.25  # of runs in a chunk: a task costs Dask about a millisecond
GROWTH = 8  # of a chunk to the next, at most
AHEAD = 2  # chunks per thread of a worker that wait or run
LOOKS = 0.01  # seconds between looks at what has arrived
COUNTS = 1.0  # seconds between counts of the workers
NO_WORKER_SECONDS = 60.0  # to wait for workers
SUSPECTS = 3  # chunks whose workers died before each of them is tried alone


def runs_on_workers(
    dask: str, sensors: SensorRuns, lost: list[str], left: AnyArray, means: RunningMeans, interrupted: threading.Event
) -> Generator[Outcomes, None, None]:
    """Yield results as they arrive, until all are there, the means are known or the event is set.

    `lost` gets the addresses of workers that go away meanwhile. Raises `RunError`, `ModelError`,
    `OSError`.
    """
    if len(left):
        parcel = packed(sensors)
        with connected(dask) as client:
            yield from _Chunks(client, parcel, sensors.lanes, dask, left, lost).runs(means, interrupted)


def chunk_size(before: int, seconds: float, lanes: int) -> int:
    """Return the size of the next chunks, if `before` runs took `seconds`: whole rows of lanes, growing slowly.

    >>> chunk_size(64, 0.05, 64), chunk_size(1, 0.1, 0), chunk_size(1, 1e-6, 0)
    (320, 3, 8)
    """
    wanted = CHUNK_SECONDS * before / max(seconds, CHUNK_SECONDS / GROWTH)
    row = max(1, lanes)
    return max(1, -(-int(wanted + 0.5) // row)) * row


class _Chunks:
    """The chunks of one study on one cluster."""

    def __init__(self, client: Any, parcel: Parcel, lanes: int, dask: str, left: AnyArray, lost: list[str]) -> None:
        self._client, self._parcel, self._lanes, self._dask = client, parcel, lanes, dask
        self._size, self._left = max(1, lanes), left
        self._under_way = dict[Any, tuple[int, ...]]()  # by future
        self._suspects, self._alone = list[tuple[int, ...]](), tuple[int, ...]()
        self._threads, self._counted, self._last_seen = 0, -COUNTS, time.monotonic()
        self._workers, self._lost = set[str](), lost

    def runs(self, means: RunningMeans, interrupted: threading.Event) -> Iterator[Outcomes]:
        """Results as they arrive."""
        try:
            while True:
                if not interrupted.is_set() and not means.enough:
                    self._submit()
                if not self._under_way:
                    self._see_workers()
                    return
                arrived = [future for future in self._under_way if future.done()]
                for future in arrived:
                    outcomes = self._arrived(future)
                    if outcomes is not None:
                        yield outcomes
                if interrupted.is_set() or means.enough:
                    return
                if not arrived:
                    interrupted.wait(LOOKS)
        except OSError as error:  # of the connection
            raise self._failed("the connection to the scheduler is lost", str(error)) from None
        finally:
            self._client.cancel(list(self._under_way))

    def _submit(self) -> None:
        """Keep every thread of the cluster busy."""
        self._count_threads()
        if self._alone in self._under_way.values():
            return
        most = max(1, AHEAD * self._threads)
        while len(self._left) and len(self._under_way) < most and len(self._suspects) < SUSPECTS:
            some, self._left = self._left[: self._size], self._left[self._size :]
            self._begin(tuple(some.tolist()))
        if self._suspects and not self._under_way:
            self._alone = self._suspects.pop(0)
            self._begin(self._alone)

    def _begin(self, some: tuple[int, ...]) -> None:
        self._under_way[self._client.submit(run_chunk, self._parcel, some, pure=False)] = some

    def _count_threads(self) -> None:
        """Count the threads, since workers come and go; raises `RunError` if there have been none for long."""
        now = time.monotonic()
        if now - self._counted < COUNTS:
            return
        self._counted = now
        self._see_workers()
        if self._threads:
            self._last_seen = now
        elif now - self._last_seen > NO_WORKER_SECONDS:
            hint = "start some with: dask worker ADDRESS; then repeat the command"
            message = f"the scheduler has had no workers for {NO_WORKER_SECONDS:.0f} s"
            raise self._failed(message, f"under way were {self._named()}" if self._under_way else "", hint)

    def _see_workers(self) -> None:
        """Note which workers there are, and which are no longer."""
        threads = self._client.nthreads()
        self._lost += sorted(self._workers - set(threads))
        self._workers, self._threads = set(threads), sum(threads.values())

    def _arrived(self, future: Any) -> Outcomes | None:
        """Return the runs of a chunk; None if its worker died, which makes it a suspect. Raises `RunError`."""
        # start-up time: distributed takes 0.2 s
        from distributed import KilledWorker
        from distributed.client import FutureCancelledError

        some = self._under_way.pop(future)
        try:
            seconds, outcomes = future.result()
        except KilledWorker as error:
            if some == self._alone:
                hint = f"replay one of them alone: --run {some[0]}"
                raise self._failed(f"workers die as they begin with {_named(some)}", str(error), hint) from None
            self._suspects.append(some)  # or it waited at a worker that another chunk killed
            return None
        except FutureCancelledError as error:
            raise self._failed("the scheduler dropped the study", str(error)) from None
        except Exception as error:
            said = " ".join(f"{type(error).__name__}: {error}".split())
            hint = "install the same version of proofmass for the scheduler and its workers"
            raise self._failed(f"a worker could not do {_named(some)}", said, hint) from None
        self._size = chunk_size(len(some), seconds, self._lanes)
        return cast(Outcomes, outcomes)

    def _named(self) -> str:
        return "; ".join(map(_named, self._under_way.values()))

    def _failed(self, message: str, got: str, hint: str = "the same command goes on") -> RunError:
        return RunError(Problem(message=message, key=self._dask, got=got, hint=hint))


def _named(some: tuple[int, ...]) -> str:
    """Return numbers of runs in words.

    >>> _named((7,)), _named((4, 5, 6)), _named((4, 6, 9))
    ('run 7', 'runs 4 to 6', '3 runs from 4 to 9')
    """
    if len(some) == 1:
        return f"run {some[0]}"
    whole = some[-1] - some[0] == len(some) - 1
    return f"runs {some[0]} to {some[-1]}" if whole else f"{len(some)} runs from {some[0]} to {some[-1]}"
