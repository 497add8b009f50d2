"""What a Dask worker does: it unpacks a study once, and computes the runs that it is asked for."""

import functools
import signal
import tempfile
import threading
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from proofmass.runner.studies.outcome.outcomes import Outcomes
from proofmass.runner.studies.runs.sensor_runs import SensorRuns
from proofmass.runner.studies.workers.parcel import Parcel, unpacked

_unpacking = threading.Lock()


def run_chunk(parcel: Parcel, numbers: Sequence[int]) -> tuple[float, Outcomes]:
    """Some runs at each epoch, and the seconds that they took. Raises `ParcelError`, `OSError`."""
    with _unpacking:
        _, sensors = _unpacked(parcel)
    began = time.perf_counter()
    outcomes = sensors.runs(numbers, threading.Event())
    return time.perf_counter() - began, outcomes


@functools.lru_cache(maxsize=2)
def _unpacked(parcel: Parcel) -> tuple[Any, SensorRuns]:
    """The sensors of a parcel, and the folder of its files, which goes when they do."""
    folder = tempfile.TemporaryDirectory(prefix="proofmass-")
    return folder, unpacked(parcel, Path(folder.name))


def dask_setup(worker: Any) -> None:
    """Workers of one's own leave Ctrl-C to the process that started them, which says when to end."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
