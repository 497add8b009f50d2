"""Statistics of the normal deviates: `python benchmarks/normal_deviates.py [COUNT]`, 1e8 when nothing is said.

Along samples, along runs and along streams: mean, variance, skewness, kurtosis, correlation at lags 1 to 16, and the
largest distance of Kolmogorov and Smirnov, each in its standard errors; the distance in those that are as improbable.
Then what one costs in the loop of 64 lanes. Exit code 1 when a statistic lies beyond 4.
"""

import functools
import math
import sys
import time
from collections.abc import Iterator
from typing import Any

import numpy as np
from scipy import stats

from proofmass.blocks import WhiteNoise
from proofmass.blocks.arithmetic.counter_random import normal_deviate
from proofmass.graphs.model.build import Graph
from proofmass.runner.planning.plan import plan
from proofmass.runner.program.build import Builder
from proofmass.runner.program.form import FLOAT, INTEGER
from proofmass.runner.program.lower import call, program
from proofmass.runner.targets.machine_code import load
from proofmass.runner.targets.native_lanes import CompiledLanes, Lanes

LAGS = 16
BINS = 1 << 16  # of equal probability
MOST = 4.0  # standard errors
WAYS = ("samples", "runs", "streams")


def sums(seed: int, way: int, count: int, powers: Any, products: Any, last: Any, bins: Any) -> None:
    """Sums over deviates of powers, of products with earlier ones, and of how many lie in each bin."""
    for k in range(count):
        x = normal_deviate(seed, k if way == 1 else 3, k if way == 2 else 5, k if way == 0 else 7)
        power = 1.0
        for n in range(4):
            power *= x
            powers[n] += power
        for lag in range(LAGS):
            products[lag] += x * last[(k - 1 - lag) % LAGS]
        last[k % LAGS] = x
        bins[min(int(0.5 * math.erfc(-x / math.sqrt(2.0)) * BINS), BINS - 1)] += 1


@functools.cache
def _compiled() -> Any:
    """The sums as machine code."""
    builder = Builder("entry")
    numbers = [builder.parameter(INTEGER, name) for name in ("seed", "way", "count")]
    lengths = {"powers": 4, "products": LAGS, "last": LAGS}
    arrays = [builder.array(FLOAT, length, name, True) for name, length in lengths.items()]
    call(builder, sums, [*numbers, *arrays, builder.array(INTEGER, BINS, "bins", True)])
    return load(program(builder.function()))


def _summed(seed: int, way: int, count: int) -> tuple[Any, Any, Any]:
    powers, products, last, bins = np.zeros(4), np.zeros(LAGS), np.zeros(LAGS), np.zeros(BINS, np.int64)
    _compiled()(seed, way, count, *(array.ctypes.data for array in (powers, products, last, bins)))
    return powers / count, products / count, bins


def errors(way: str, count: int, seed: int = 1) -> Iterator[tuple[str, float]]:
    """Each statistic of so many deviates along samples, runs or streams, in its standard errors."""
    moments, products, bins = _summed(seed, WAYS.index(way), count)
    mean, second, third, fourth = moments
    variance = second - mean**2
    skewness = (third - 3.0 * mean * second + 2.0 * mean**3) / variance**1.5
    kurtosis = (fourth - 4.0 * mean * third + 6.0 * mean**2 * second - 3.0 * mean**4) / variance**2 - 3.0
    root = math.sqrt(count)
    yield "mean", mean * root
    yield "variance", (variance - 1.0) * root / math.sqrt(2.0)
    yield "skewness", skewness * root / math.sqrt(6.0)
    yield "kurtosis", kurtosis * root / math.sqrt(24.0)
    for lag, product in enumerate(products, 1):
        yield f"lag {lag}", product * root
    distance = np.abs(np.cumsum(bins) / count - np.arange(1, BINS + 1) / BINS).max()
    yield "distance", float(stats.norm.isf(0.5 * stats.kstwobign.sf(distance * root)))


def nanoseconds(ticks: int = 4000, lanes: int = 64, sources: int = 4) -> float:
    """What a deviate takes in lanes: of loops with one source of noise and with some more, the difference."""
    seconds = []
    for count in (1, 1 + sources):
        blocks = {f"noise{i}": WhiteNoise() for i in range(count)}
        measures = {"last": {"signal": "noise0.output", "statistic": "last"}}
        graph = Graph(name="", rate=1000, samples=ticks, blocks=blocks, measures=measures)
        compiled, best = CompiledLanes(plan(graph), set(), lanes), math.inf
        for _ in range(20):
            runs = Lanes(compiled, 1, range(lanes), {})
            began = time.perf_counter()
            runs.advance(ticks)
            best = min(best, time.perf_counter() - began)
        seconds.append(best)
    return (seconds[1] - seconds[0]) / (sources * lanes * ticks) * 1e9


def main(count: int) -> int:
    """Print every statistic; returns the exit code."""
    worst = 0.0
    for way in WAYS:
        began = time.perf_counter()
        found = dict(errors(way, count))
        print(f"{count:,} deviates along {way}, {time.perf_counter() - began:.0f} s; in standard errors:")
        print("  " + ", ".join(f"{name} {value:+.2f}" for name, value in found.items()))
        worst = max(worst, *map(abs, found.values()))
    print(f"furthest: {worst:.2f} (limit {MOST:g})")
    print(f"in 64 lanes, each: {nanoseconds():.1f} ns")
    return int(worst > MOST)


if __name__ == "__main__":
    sys.exit(main(int(float(sys.argv[1])) if len(sys.argv) > 1 else 10**8))
