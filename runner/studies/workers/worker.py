"""The work of a Dask worker: it unpacks a study once, and computes runs of it."""

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
    """Return runs at all epochs, and the seconds they took. Raises `ParcelError`, `OSError`."""
    with _unpacking:
        _, sensors = _unpacked(parcel)
    began = time.perf_counter()
    outcomes = sensors.runs(numbers, threading.Event())
    return time.perf_counter() - began, outcomes


@functools.lru_cache(maxsize=2)
def _unpacked(parcel: Parcel) -> tuple[Any, SensorRuns]:
    """Return the sensors of a parcel, and the temporary folder of its files."""
    folder = tempfile.TemporaryDirectory(prefix="proofmass-")
    return folder, unpacked(parcel, Path(folder.name))


def dask_setup(worker: Any) -> None:
    """Ignore Ctrl-C in local workers: the process that started them ends them."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
