"""Workload W3, a Monte Carlo study, beside hand-written C in one run: `python benchmarks/monte_carlo.py [--json]`.

1,000 sensors of 50,000 samples, eight parameters of each drawn anew, two numbers of each kept. The C computes one run
after the other, compiled without contraction to fused multiply-add; a ratio is of the minima over interleaved rounds.
What a run takes besides its samples (drawing, discretisation, measures, ledger) is seen in studies of two samples.
"""

import argparse
import ctypes
import dataclasses
import json
import tempfile
import threading
import time
from collections.abc import Callable
from fractions import Fraction
from typing import Any

import numpy as np
from compare_with_c import build

from proofmass import read_graph
from proofmass.graphs.files.library import library_file
from proofmass.graphs.studies.build import Study
from proofmass.runner.continuous.exact_hold import hold
from proofmass.runner.studies.runs.sensor_runs import SensorRuns
from proofmass.runner.studies.whole.study import run_study
from proofmass.runner.targets.native_lanes import Lanes

SAMPLES, RUNS, RATE = 50_000, 1024, 50_000
VARIED = (
    "pendulum.inertia", "pendulum.damping", "pendulum.stiffness", "pickoff.gain", "adc.reference",
    "reference.offset", "resistor.gain", "torquer.gain",
)  # fmt: skip


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--runs", type=int, default=RUNS)
    parser.add_argument("--samples", type=int, default=SAMPLES)
    arguments = parser.parse_args()
    row = measure(workload(arguments.runs, arguments.samples), arguments.rounds)
    if arguments.json:
        print(json.dumps(row, indent=2))
        return
    print(f"W3, {arguments.runs:,} runs of {arguments.samples:,} samples, ns per run-sample, ratio to the scalar C")
    for name, seconds in row["ns"].items():
        print(f"{name:28} {seconds:8.2f} {seconds / row['ns']['scalar C']:8.3f}")
    print(f"start of a study: {row['start_ms']:.0f} ms")
    print(f"a run besides its samples: {row['outside_us']:.2f} us, {row['outside_share']:.2%} of its loop")
    print(f"two threads: {row['two_threads']:.2f} times one; bare loops on this machine: {row['two_loops']:.2f}")
    print(f"largest difference to the C: mean {row['mean_difference']:.2g}, std {row['std_difference']:.2g} codes")


def workload(runs: int = RUNS, samples: int = SAMPLES) -> Study:
    """The study: every parameter spread by 200 ppm, the reference drifting by 200 ppm within a run."""
    half = Fraction(samples, 2 * RATE)
    graph = dataclasses.replace(
        read_graph(library_file("closed_loop_accelerometer.toml")),
        probes=(),
        samples=samples,
        measures={name: {"signal": "dac.code", "statistic": name, "from": half} for name in ("mean", "std")},
    ).with_parameters({"reference.slope": 2.5 * 200e-6 * RATE / samples})
    return Study(graph, runs=runs, seed=3, spread={name: {"normal": "200 ppm", "relative": True} for name in VARIED})


def measure(study: Study, rounds: int) -> dict[str, Any]:
    """Nanoseconds per run-sample of each way, and what the study costs besides its loop."""
    samples, runs = int(study.graph.samples or 0), study.runs
    drawn = [study.drawn(number)[0] for number in range(runs)]
    result, few = np.zeros((runs, 2)), max(1, runs // 32)
    parameters = np.array([_row(study, values) for values in drawn])

    def c(library: ctypes.CDLL, count: int) -> float:
        began = time.thread_time()
        pointers = (ctypes.c_void_p(parameters.ctypes.data), ctypes.c_void_p(result.ctypes.data))
        library.monte_carlo(ctypes.c_int64(count), ctypes.c_int64(samples), *pointers)
        return (time.thread_time() - began) / count

    def made(width: int) -> Lanes:
        compiled = SensorRuns(study, "compiled", width).together.compiled
        given = {tuple(name.split(".")): np.array([v[name] for v in drawn[:width]]) for name in drawn[0]}
        return Lanes(compiled, study.seed, range(width), given)

    def lanes(width: int) -> float:
        loop = made(width)
        return _seconds(lambda: loop.advance(samples), time.thread_time) / width

    def at_once(width: int, threads: int) -> float:
        each = [threading.Thread(target=made(width).advance, args=(samples,)) for _ in range(threads)]

        def together() -> None:
            for thread in each:
                thread.start()
            for thread in each:
                thread.join()

        return _seconds(together) / (threads * width)

    def whole(threads: int) -> float:
        clock = time.process_time if threads == 1 else time.perf_counter  # a machine is shared
        began = clock()
        results.append(run_study(study, engine="compiled", threads=threads))
        return (clock() - began) / runs

    def of_one_sample(count: int) -> float:
        short = workload(count, 2)
        return min(_seconds(lambda: run_study(short, engine="compiled", threads=1)) for _ in range(rounds))

    results: list[Any] = []
    times: dict[str, list[float]] = {}
    with tempfile.TemporaryDirectory() as folder:
        library = build("monte_carlo.c", folder, ("-ffp-contract=off",))
        whole(1)
        for _ in range(rounds):
            times.setdefault("scalar C", []).append(c(library, few))
            for width in (8, 16, 32, 64):
                times.setdefault(f"loop of {width} lanes", []).append(lanes(width))
            times.setdefault("two loops of 32 at once", []).append(at_once(32, 2))
            for threads in (1, 2):
                times.setdefault(f"study, threads: {threads}", []).append(whole(threads))
        c(library, runs)
    best = {name: min(each) for name, each in times.items()}
    few, many = of_one_sample(1024), of_one_sample(9216)
    outside = (many - few) / 8192
    return {
        "ns": {name: seconds * 1e9 / samples for name, seconds in best.items()},
        "start_ms": (few - 1024 * outside) * 1e3,
        "outside_us": outside * 1e6,
        "outside_share": outside / best["loop of 32 lanes"],
        "two_loops": best["loop of 32 lanes"] / best["two loops of 32 at once"],
        "two_threads": best["study, threads: 1"] / best["study, threads: 2"],
        "mean_difference": float(np.abs(results[0]["mean"][:, 0] - result[:, 0]).max()),
        "std_difference": float(np.abs(results[0]["std"][:, 0] - result[:, 1]).max()),
    }


def _seconds(function: Callable[[], object], clock: Callable[[], float] = time.perf_counter) -> float:
    began = clock()
    function()
    return clock() - began


def _row(study: Study, values: dict[str, float]) -> list[float]:
    """The parameters of a run as the C takes them."""
    j, c, k = (values[f"pendulum.{name}"] for name in ("inertia", "damping", "stiffness"))
    (a, b) = hold([[0.0, 1.0], [-k / j, -c / j]], [[0.0], [1.0 / j]], 1 / RATE)
    plain = (values[n] for n in ("pickoff.gain", "adc.reference", "reference.offset"))
    return [*plain, 1.0 / values["resistor.gain"], values["torquer.gain"], *a[0], *a[1], b[0][0], b[1][0]]


if __name__ == "__main__":
    main()
