"""Errors of runs beside the accuracy that was asked for: `python -m benchmarks.accuracy [--sample]`.

Nonlinear, stiff and switching systems (`accuracy_rows`), and a thousand steps, pulses and ramps that begin anywhere,
beside closed forms. The error is the largest at any tick, of the largest value of the signal.
"""

import argparse
import dataclasses
import math
import time
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from benchmarks.accuracy_rows import systems
from benchmarks.accuracy_systems import System, graph
from proofmass.blocks import (
    LowPass,
    Pulse,
    Ramp,
    Step,
)
from proofmass.runner.run.simulate import RunError, simulate

ACCURACIES = tuple(10.0**-n for n in range(4, 12))
METHODS = ("auto", "dormand_prince", "radau")
STARTS = 1_000


class Errors(NamedTuple):
    """Errors of one system by one method, in accuracies."""

    name: str
    method: str
    ratios: tuple[float, ...]


def errors_of(system: System, method: str, accuracies: Sequence[float]) -> Errors:
    """Return the errors of a system by a method, in accuracies; infinite where the run ends."""
    expected, ratios = None, list[float]()
    for accuracy in accuracies:
        integration = dataclasses.replace(system.graph.integration, method=method, accuracy=accuracy)
        try:
            trace = simulate(dataclasses.replace(system.graph, integration=integration), engine="compiled")[
                system.signal
            ]
        except RunError as error:
            print(f"{system.name}, {method}, {accuracy:g}: {str(error)[:200]}")
            ratios.append(math.inf)
            continue
        if expected is None:
            expected = system.expected(trace.times)
        ratios.append(float(np.abs(trace.values - expected).max() / np.abs(expected).max()) / accuracy)
    return Errors(system.name, method, tuple(ratios))


def starts(number: int) -> list[Errors]:
    """Steps, pulses and ramps that begin anywhere, behind a lag and a mass: against closed forms."""
    random = np.random.default_rng(19)
    rows = []
    for index in range(number):
        source, method = ("step", "pulse", "ramp")[index % 3], METHODS[index // 3 % 3]
        accuracy = float(ACCURACIES[index // 9 % len(ACCURACIES)])
        begin, tau = float(random.uniform(0.0, 8e-3)), float(10.0 ** random.uniform(-4.5, -2.0))
        rows.append(_one_start(source, method, accuracy, begin, tau))
    return rows


def _one_start(source: str, method: str, accuracy: float, begin: float, tau: float) -> Errors:
    width, again = 0.3 * 1.7e-3, 1.7e-3
    blocks: dict[str, Any] = {
        "source": {
            "step": Step(start_time=begin),
            "pulse": Pulse(delay=begin, repetition=again, duty=0.3),
            "ramp": Ramp(slope=1.0, start_time=begin),
        }[source],
        "lag": LowPass(corner_frequency=1.0 / (2.0 * math.pi * tau)),
    }
    made = graph(blocks, ["source.output -> lag.input"], "lag.output", 1e3, 12e-3, method=method, accuracy=accuracy)
    trace = simulate(made, engine="compiled")["lag.output"]

    def rise(after: Any) -> Any:
        return np.where(after > 0.0, -np.expm1(-np.maximum(after, 0.0) / tau), 0.0)

    after = trace.times - begin
    if source == "step":
        expected = rise(after)
    elif source == "ramp":
        expected = np.where(after > 0.0, after - tau * rise(after), 0.0)
    else:
        expected = sum(rise(after - n * again) - rise(after - n * again - width) for n in range(9))
    return Errors(source, method, (float(np.abs(trace.values - expected).max() / np.abs(expected).max()) / accuracy,))


def kept(rows: Sequence[Errors]) -> tuple[float, float]:
    """Return the part of runs whose error is at most the accuracy, and the largest error in accuracies."""
    ratios = np.array([ratio for row in rows for ratio in row.ratios])
    return float((ratios <= 1.0).mean()), float(ratios.max())


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--sample", action="store_true", help="take one variation of each system and 100 starts")
    sample = parser.parse_args().sample
    chosen = list({system.name: system for system in systems()}.values()) if sample else systems()
    began = time.process_time()
    rows = [errors_of(system, method, ACCURACIES) for system in chosen for method in METHODS]
    print(f"{'system':14} {'method':15} " + " ".join(f"{accuracy:8.0e}" for accuracy in ACCURACIES))
    for row in rows:
        print(f"{row.name:14} {row.method:15} " + " ".join(f"{ratio:8.2g}" for ratio in row.ratios))
    begun = starts(100 if sample else STARTS)
    for name, group in ((f"{len(chosen)} systems", rows), (f"{len(begun)} starts", begun)):
        part, largest = kept(group)
        print(f"{name}: error at most the accuracy in {100.0 * part:.2f} % of runs, at most {largest:.3g} times it")
    print(f"{time.process_time() - began:.0f} s of CPU time")


if __name__ == "__main__":
    main()
