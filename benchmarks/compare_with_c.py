"""The compiled engine beside hand-written C, in one run: `python benchmarks/compare_with_c.py [--json]`.

The C is compiled here by the machine's own gcc with -O3 -march=native, once as gcc does it and once without
contraction to fused multiply-add (the same operations as the engine). Rounds are interleaved and take CPU time; a ratio
is of the two minima, with the median of the paired ratios beside it, since machines are shared and noisy.
"""

import argparse
import ctypes
import dataclasses
import json
import statistics
import subprocess
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from proofmass import read_graph
from proofmass.graphs.files.library import library_file
from proofmass.graphs.model.build import Graph
from proofmass.runner.continuous.exact_hold import hold
from proofmass.runner.plan.memory import start
from proofmass.runner.planning.plan import plan
from proofmass.runner.run.simulate import simulate
from proofmass.runner.targets.native import CompiledLoop

HERE = Path(__file__).parent
SAMPLES = 1_000_000
PERIODS = 1_000
GYROSCOPE_SAMPLES, STEPS = 100_000, 6


def main() -> None:
    """Measure all workloads and print the ratios."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--rounds", type=int, default=15)
    arguments = parser.parse_args()
    rows = [closed_loop(arguments.rounds), self_test(arguments.rounds), *gyroscope(arguments.rounds)]
    if arguments.json:
        print(json.dumps(rows, indent=2))
        return
    print(f"{'workload':28} {'C':>8} {'C, no FMA':>10} {'engine':>8} {'ratio':>6} {'paired':>7} {'limit':>6}")
    for row in rows:
        print(
            f"{row['workload']:28} {row['c_ns']:6.1f}ns {row['c_no_fma_ns']:8.1f}ns {row['engine_ns']:6.1f}ns"
            f" {row['ratio']:6.2f} {row['paired_ratio']:7.2f} {row['limit'] or '':>6}"
        )


def closed_loop(rounds: int) -> dict[str, Any]:
    """Workload W1: a million samples, every output code recorded."""
    graph = read_graph(library_file("closed_loop_accelerometer.toml"))
    a, b = hold([[0.0, 1.0], [-3.0e-3 / 1.0e-7, -4.0e-4 / 1.0e-7]], [[0.0], [1.0 / 1.0e-7]], 1 / 50e3)
    record = np.zeros(SAMPLES, dtype=np.int32)

    def c(library: ctypes.CDLL) -> None:
        library.closed_loop(ctypes.c_int64(SAMPLES), *_held(a, b), ctypes.c_void_p(record.ctypes.data))

    row = _measure("W1 closed loop", "closed_loop.c", c, graph, SAMPLES, rounds, 0.75)
    row["equal"] = bool((simulate(graph, samples=SAMPLES, engine="compiled")["dac.code"].values == record).all())
    return row


def self_test(rounds: int) -> dict[str, Any]:
    """Workload W2: a thousand periods of 1023 chips, one vector of 16 sums a period."""
    graph = read_graph(library_file("pn_self_test_minimal.toml"))
    m, k, c_ = 50.43e-9, 49.5627, 3.4e-3
    a, b = hold([[0.0, 1.0], [-k / m, -c_ / m]], [[0.0], [1.0 / m]], 1 / 9.6e3)
    sums = np.zeros((PERIODS, 16), dtype=np.int64)

    def c(library: ctypes.CDLL) -> None:
        library.self_test(ctypes.c_int64(PERIODS), *_held(a, b), ctypes.c_void_p(sums.ctypes.data))

    samples = 1023 * PERIODS
    row = _measure("W2 PN self-test", "self_test.c", c, graph, samples, rounds, 0.95)
    found = simulate(graph, samples=samples + 1, engine="compiled")["correlator.impulse_response"].values[1:]
    row["equal"] = bool((found == sums).all())
    return row


def gyroscope(rounds: int) -> list[dict[str, Any]]:
    """A non-linear continuous group: both modes of a gyroscope, six steps of Runge-Kutta 4 a tick.

    Once beside the equations as they are published, sources and all, and once beside the operations of the graph with
    the sources given; those give the same bits.
    """
    graph = dataclasses.replace(
        read_graph(library_file("vibratory_gyroscope.toml")),
        integration={"method": "runge_kutta_4", "substeps": STEPS, "sources": "held"},
        probes=["sense.displacement"],
    )
    sources = dataclasses.replace(graph, probes=["rotation.output", "signal.output"])
    held = simulate(sources, samples=GYROSCOPE_SAMPLES, engine="compiled")
    drive, rotation = held["signal.output"].values, held["rotation.output"].values
    record = np.zeros(GYROSCOPE_SAMPLES)

    def c(library: ctypes.CDLL) -> None:
        arrays = (ctypes.c_void_p(array.ctypes.data) for array in (drive, rotation, record))
        length = ctypes.c_double(plan(graph).period)
        library.gyroscope(ctypes.c_int64(GYROSCOPE_SAMPLES), ctypes.c_int64(STEPS), length, *arrays)

    displacements = simulate(graph, samples=GYROSCOPE_SAMPLES, engine="compiled")["sense.displacement"].values
    published = _measure("gyroscope, as published", "gyroscope.c", c, graph, GYROSCOPE_SAMPLES, rounds, 0.8)
    published["apart"] = float(abs(displacements - record).max() / abs(record).max())
    same = ("-DSAME_OPERATIONS",)
    alike = _measure("gyroscope, same operations", "gyroscope.c", c, graph, GYROSCOPE_SAMPLES, rounds, None, same)
    alike["equal"] = bool((displacements == record).all())
    return [published, alike]


def _measure(
    name: str,
    source: str,
    c: Callable[[ctypes.CDLL], None],
    graph: Graph,
    samples: int,
    rounds: int,
    limit: float | None,
    defined: tuple[str, ...] = (),
) -> dict[str, Any]:
    planned = plan(graph)
    rows = [np.zeros((p.rows(0, samples), *p.shape), dtype=p.dtype) for p in planned.probes]

    def engine_seconds() -> float:
        engine = CompiledLoop(planned, 0, memory=start(planned))
        began = time.thread_time()
        engine.advance(samples, rows)
        return time.thread_time() - began

    with tempfile.TemporaryDirectory() as folder:
        libraries = [build(source, folder, (*flags, *defined)) for flags in ((), ("-ffp-contract=off",))]
        times: list[tuple[float, float, float, float]] = []
        for _ in range(rounds):
            whole = simulate(graph, samples=samples, engine="compiled").seconds
            times.append((_seconds(c, libraries[0]), _seconds(c, libraries[1]), engine_seconds(), whole))
    fused, strict, engine, whole = (min(column) * 1e9 / samples for column in zip(*times, strict=True))
    return {
        "workload": name,
        "c_ns": fused,
        "c_no_fma_ns": strict,
        "engine_ns": engine,
        "with_chunks_and_checks_ns": whole,
        "ratio": engine / strict,
        "paired_ratio": statistics.median(row[2] / row[1] for row in times),
        "ratio_with_chunks_and_checks": whole / strict,
        "limit": limit,
    }


def _seconds(c: Callable[[ctypes.CDLL], None], library: ctypes.CDLL) -> float:
    began = time.thread_time()
    c(library)
    return time.thread_time() - began


def _held(a: list[list[float]], b: list[list[float]]) -> tuple[Any, Any]:
    transition = (ctypes.c_double * 4)(*a[0], *a[1])
    entry = (ctypes.c_double * 2)(b[0][0], b[1][0])
    return transition, entry


def build(source: str, folder: str, flags: tuple[str, ...]) -> ctypes.CDLL:
    """A C file of this folder as a library."""
    target = Path(folder) / f"{source}{''.join(flags)}.so"
    command = ["gcc", "-O3", "-march=native", *flags, "-shared", "-fPIC", "-o", str(target), str(HERE / source), "-lm"]
    subprocess.run(command, check=True)
    return ctypes.CDLL(str(target))


if __name__ == "__main__":
    main()
