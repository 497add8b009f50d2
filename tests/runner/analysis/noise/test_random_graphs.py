"""Budgets of random graphs against spectra and mean squares of their runs, with the errors that the runs show.

`python -m tests.runner.analysis.noise.test_random_graphs FIRST LAST` compares others.
"""

import math
import sys
from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

from proofmass import Graph, ModelError, Study, deviation_over_runs, noise, run_study, simulate
from proofmass.graphs.model.measures import Measure
from proofmass.runner.analysis.linearisation.linearise import node_of
from proofmass.runner.planning.plan import plan
from tests.by_hand.amounts import chosen
from tests.by_hand.noisy_graphs import RATE, noisy_graph

SEGMENT, FINE, PARTS = 64, 8, 16
MOST = 6.0  # standard errors, of some thousand figures
LEAST = 1e-6  # of the largest density: below is what noise does to noise, and what a window leaks
BANDS = slice(2, 5), slice(5, 12), slice(12, 31)  # lines
WEIGHTS = np.hanning(SEGMENT + 1)[:-1]
RUNS = 1000
WITH_FORGOTTEN_STATES = 256  # its densities were 16 % off (S826)
UNREPEATED, STRAINED = "the orbit does not come back", "noise is not small here"


def errors_of(graph: Graph, output: str, values: int) -> list[float]:
    """Return by how many standard errors the mean square of runs, and of bands, differs from the budget."""
    planned = plan(graph)
    stride = planned.stride(node_of(planned, output))
    rate = float(planned.schedule.base_rate) / stride
    fine = np.arange(1, FINE * SEGMENT // 2) * rate / (FINE * SEGMENT)
    budget = noise(graph, output, frequencies=fine.tolist())
    doubtful = sum(source.share for source in budget.sources if source.doubtful)
    if budget.band[0] > 0.0 or doubtful > 1e-4 or any(note.startswith((UNREPEATED, STRAINED)) for note in budget.notes):
        return []
    samples = values * stride * 8 // 7
    first, second = (simulate(graph, samples=samples, seed=seed)[output].values.astype(float) for seed in (1, 2))
    apart = ((first - second) / math.sqrt(2.0))[-values:]
    squares = np.mean(apart[: len(apart) // PARTS * PARTS].reshape(PARTS, -1) ** 2, axis=1)
    lines = np.abs(np.fft.rfft(apart[: len(apart) // SEGMENT * SEGMENT].reshape(-1, SEGMENT) * WEIGHTS, axis=1)) ** 2
    predicted = expected(budget.density)
    density = lines * 2.0 / (rate * float(np.sum(WEIGHTS**2)))
    bands = [band for band in BANDS if predicted[band].min() > LEAST * predicted.max()]
    ratios = [np.mean(density[:, band] / predicted[band], axis=1) for band in bands]
    means = [np.array([np.mean(part) for part in np.array_split(ratio, PARTS)]) for ratio in ratios]
    return [standard_errors(each, 1.0) for each in (squares / budget.rms**2, *means)]


def expected(density: Any) -> Any:
    """Return the mean of the spectrum of a window by the predicted density."""
    density = np.concatenate([density[:1], density, density[-1:]])
    both = np.concatenate([density, density[-2:0:-1]])
    shape = np.abs(np.fft.fft(WEIGHTS, FINE * SEGMENT)) ** 2
    spread = np.fft.ifft(np.fft.fft(both) * np.fft.fft(shape / np.sum(shape))).real
    return spread[: FINE * SEGMENT // 2 + 1 : FINE]


def standard_errors(values: Any, mean: float) -> float:
    """Return the distance of the mean of some values, in standard errors; half a percent at least."""
    error = float(np.std(values, ddof=1)) / math.sqrt(len(values))
    return (float(np.mean(values)) - mean) / max(error, 0.005)


def worst_of(number: int, values: int) -> float:
    """Return the largest distance of a graph, 0 where there is no budget to compare."""
    graph, output = noisy_graph(number)
    try:
        return max(map(abs, errors_of(graph, output, values)), default=0.0)
    except ModelError:  # nothing comes out, a loop is not stable, a vector is held
        return 0.0


@pytest.mark.parametrize("number", chosen([24], [152]))
def test_budgets_are_those_of_runs(number: int) -> None:
    assert worst_of(number, 1 << 15) < MOST


@pytest.mark.exhaustive
@pytest.mark.parametrize("number", [*range(150), WITH_FORGOTTEN_STATES])
def test_budgets_of_many_graphs_are_those_of_runs(number: int) -> None:
    assert worst_of(number, 1 << 15) < MOST


@pytest.mark.exhaustive
@pytest.mark.parametrize("number", range(40))
def test_spreads_over_runs_are_those_of_many_runs(number: int) -> None:
    graph, output = noisy_graph(number)
    ticks = 10 + 7 * number
    try:
        found = deviation_over_runs(graph, output, until=Fraction(ticks, RATE))
    except ModelError:  # it has no value yet, a vector is held
        return
    measured = replace(graph, probes=(), measures={"end": Measure(output, "last")}, duration=Fraction(ticks, RATE))
    values = np.asarray(run_study(Study(measured, runs=RUNS, seed=5)).values["end"], dtype=float)
    if not np.isfinite(values).all():  # elsewhere in the graph a run fails
        return
    square, scale = (values - values.mean()) ** 2 * RUNS / (RUNS - 1), max(found.deviation**2, 1e-30)
    error = max(float(np.std(square)) / math.sqrt(RUNS), 0.01 * scale)
    assert abs(float(np.mean(square)) - found.deviation**2) < MOST * error


if __name__ == "__main__":
    for number in range(*map(int, sys.argv[1:3])):
        found = worst_of(number, 1 << 16)
        if found > MOST:
            print(number, *noisy_graph(number)[1:], f"{found:.1f} standard errors")
