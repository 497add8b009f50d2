"""One SHA-256 over all measures of a study, however it is computed: `python -m benchmarks.study_digests`.

Threads, lanes, chunks of runs, their order, the engine, workers of Dask, hash seeds of Python, interruptions. Exit code
1 when one digest differs.
"""

import hashlib
import os
import subprocess
import sys
import tempfile
import threading
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from proofmass import Study, read_study, run_study
from proofmass.runner.studies.outcome.outcomes import Outcomes, together
from proofmass.runner.studies.runs.sensor_runs import SensorRuns
from proofmass.runner.studies.whole import study as studies
from tests.by_hand.study_texts import STUDY

RUNS = 1024
FEW = 96  # of which plain Python is asked
GRAPH = (
    STUDY.partition("[study]")[0]
    + """\
[study]
seed = 11

[study.spread]
"adc.reference" = { normal = "200 ppm", relative = true }
"source.value" = { uniform = "1 mV" }

[study.epochs]
ages = ["0 h", "1 year"]

[study.drift]
"adc.reference" = { ramp = "20 ppm/year", random_walk = "9 ppm/sqrt(year)", relative = true }
"""
)


def digests(study: Study, path: Path) -> Iterator[tuple[str, int, str]]:
    """Each way to compute the study: what it is, how many runs, and the digest."""
    for threads in (1, 2):
        for lanes in (0, 8, 16, 32):
            result = run_study(study, engine="compiled", lanes=lanes, threads=threads)
            yield f"{lanes or 'no'} lanes, {threads} thread{'s' if threads > 1 else ''}", RUNS, result.digest
    sensors = SensorRuns(study, "compiled", 16)
    shuffled = np.random.default_rng(5).permutation(RUNS)
    for order, numbers in (("forward", np.arange(RUNS)), ("shuffled", shuffled)):
        for size in (1, 7, 64, 1000):
            parts = [numbers[first : first + size] for first in range(0, RUNS, size)]
            yield f"chunks of {size}, {order}", RUNS, _digest(sensors, parts)
    yield "Python engine", FEW, run_study(study, runs=FEW, engine="python").digest
    for workers in (1, 2, 4):
        result = run_study(study, engine="compiled", lanes=16, dask=f"local:{workers}")
        yield f"Dask, {workers} worker{'s' if workers > 1 else ''}", RUNS, result.digest
    for seed in ("0", "1", "4242"):
        script = "import sys, proofmass as p; print(p.run_study(p.read_study(sys.argv[1]), engine='compiled').digest)"
        environment = os.environ | {"PYTHONHASHSEED": seed}
        made_by = [sys.executable, "-c", script, str(path)]
        said = subprocess.run(made_by, env=environment, check=True, capture_output=True, text=True).stdout
        yield f"PYTHONHASHSEED={seed}", RUNS, said.strip()
    with tempfile.TemporaryDirectory() as folder:
        times, digest = _interrupted(study, Path(folder))
    yield f"interrupted and resumed {times} times", RUNS, digest


def _digest(sensors: SensorRuns, parts: list[np.ndarray]) -> str:
    """The digest of runs in parts, by themselves, as `StudyResult` computes it."""
    outcomes: list[Outcomes] = [sensors.runs(part, threading.Event()) for part in parts]
    all_of_them = together(outcomes, len(sensors.study.epochs), len(sensors.measures))
    values = all_of_them.values[np.argsort(all_of_them.numbers)]
    digest = hashlib.sha256()
    for _, place in sorted((measure.name, place) for place, measure in enumerate(sensors.measures)):
        digest.update(np.ascontiguousarray(values[:, :, place], dtype="<f8").tobytes())
    return digest.hexdigest()


def _interrupted(study: Study, folder: Path, times: int = 20) -> tuple[int, str]:
    """The digest after so many interruptions, each after some more runs."""
    in_threads, whole = studies._in_threads, 0
    for _ in range(times):

        def until(sensors: SensorRuns, threads: int, left: np.ndarray, *more: object) -> Iterator[Outcomes]:
            yield from in_threads(sensors, threads, left[: RUNS // (times + 1)], *more)  # type: ignore[arg-type]

        studies._in_threads = until  # type: ignore[assignment]
        whole += run_study(study, engine="compiled", lanes=16, folder=folder).interrupted
    studies._in_threads = in_threads
    return whole, run_study(study, engine="compiled", lanes=16, folder=folder).digest


def main() -> int:
    """Print the table; returns the exit code."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "study.toml"
        path.write_text(GRAPH.replace("seed = 11", f"seed = 11\nruns = {RUNS}"), encoding="utf-8")
        study = read_study(path)
        expected = {RUNS: "", FEW: run_study(study, runs=FEW, engine="compiled", lanes=0).digest}
        different = 0
        for how, runs, digest in digests(study, path):
            expected[runs] = expected[runs] or digest
            different += digest != expected[runs]
            said = "" if digest == expected[runs] else "  DIFFERENT"
            print(f"{how:38} {runs:5,} runs  {digest[:16]}...{said}", flush=True)
        print(f"{different} differ; {RUNS:,} runs: {expected[RUNS]}, {FEW}: {expected[FEW]}")
    return int(different > 0)


if __name__ == "__main__":
    sys.exit(main())
