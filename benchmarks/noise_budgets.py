"""Noise budgets of every noisy graph of the library beside its own runs.

python benchmarks/noise_budgets.py [NAME ...]

A row is an output that is probed or measured and that noise reaches. The noise of a run is what two runs of different
seeds differ by, over sqrt(2): signals drop out. Columns: the rms by the budget and by these runs; how many lines of the
Welch spectrum lie in the band that holds 99 % of them; by how many standard errors the mean square of 1,000 runs in
lanes differs from the predicted one, which should be 3 at most.

Expected lines are those of the window: the predicted density, spread by its transform. The mean square of an output
that settles slowly, or not at all, is that of its increment over half the run, with a `d`: a density S gives it
integral of 4 S sin^2(pi f t). What is refused has its reason in the place of numbers.
"""

import math
import signal
import sys
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
from scipy.stats import chi2

import proofmass
from proofmass import Graph, ModelError, NoiseBudget, Series, Spectrum
from proofmass.blocks import AnalogToDigital
from proofmass.graphs.model.build import read_probe
from proofmass.graphs.model.measures import Measure
from proofmass.runner.analysis.linearisation.linearise import node_of
from proofmass.runner.analysis.linearisation.period_map import blocks_of_map
from proofmass.runner.analysis.spectrum.windows import window
from proofmass.runner.derivatives.dual_noise import noise_blocks
from proofmass.runner.plan.planned import Plan
from proofmass.runner.planning.plan import plan

LIBRARY = Path(__file__).parents[1] / "graphs" / "library"
CONFIDENCE, SEED = 0.99, 7
VALUES, FEWEST, TICKS = 20_000, 1_000, 8_000_000  # of an output in a run, and base ticks
SEGMENT, SEGMENTS = 1024, 40
RUNS, RUN_VALUES, RUN_TICKS = 1000, 12_000, 200_000
PHASES, LOOKS = 64, 256  # of the period of the schedule at which a run is looked at, and for all outputs, at most
SLOW = 0.01  # of the mean square, below the lowest frequency of a run
PATIENCE = 20  # seconds of processor time for a row
POINTS = (None, "periodic", "settled")  # operating points, the first that there is
LEAST = 1e-4  # of the largest density, below which there is what noise does to noise, and what a window leaks
_LINES = slice(3, -2)  # the mean is taken off, and the window leaks it into those beside
_FINE = 8  # points of the predicted density from line to line


@dataclass(frozen=True)
class Case:
    """An output of a graph of the library, and how its spectrum is taken."""

    file: str
    output: str
    values: int = VALUES
    segment: int = SEGMENT


CASES = (
    Case("recorded_motion.toml", "mean.mean"),
    Case("recorded_motion.toml", "adc.number"),
    Case("quartz_feedback_noise.toml", "force.output"),
    Case("quartz_feedback_noise.toml", "output.output"),
    Case("temperature_compensation_m1.toml", "noisy.output"),
)  # that are quick


@dataclass(frozen=True)
class Row:
    """What a budget predicts of an output, and what two runs show."""

    case: Case
    budget: NoiseBudget
    at: str | None
    rms: float
    inside: float  # part of the lines
    seconds: float  # of processor time for the budget


@dataclass(frozen=True)
class Scatter:
    """What many runs show: by how many standard errors their mean square differs, and of what."""

    errors: float
    increments: bool


def noisy_graphs(names: Sequence[str] = ()) -> Iterator[tuple[Path, Graph, list[str]]]:
    """Yield the graphs of the library, and of each the outputs that noise reaches."""
    for path in sorted(LIBRARY.rglob("*.toml"), key=lambda path: path.name):
        if "parts" in path.parts or path.name == "template.toml" or (names and path.stem not in names):
            continue
        try:
            graph = proofmass.read_graph(path)
        except ModelError:  # a study of another file
            continue
        planned = plan(graph)
        outputs = list(_noisy_outputs(planned, graph))
        if outputs:
            yield path, graph, outputs


def _noisy_outputs(planned: Plan, graph: Graph) -> Iterator[str]:
    noisy = noise_blocks(planned)
    signals = [*(probe.signal for probe in graph.probes), *(m.signal for m in graph.measures.values())]
    readouts = [f"{name}.number" for name, block in planned.blocks.items() if isinstance(block, AnalogToDigital)]
    for name in dict.fromkeys((*readouts, *signals)):
        try:
            node = node_of(planned, name)
        except ModelError:  # bits and vectors
            continue
        if blocks_of_map(planned, (), [node], False)[0] & noisy.keys():
            yield name


def row(case: Case) -> Row:
    """Return the comparison of one output with two runs."""
    graph = proofmass.read_graph(next(LIBRARY.rglob(case.file)))
    began = time.process_time()
    budget, at = budget_of(graph, case.output)
    seconds = time.process_time() - began
    noise = _noise(graph, case, budget)
    segment = max(32, min(case.segment, len(noise.values) // SEGMENTS))
    if not np.any(noise.values):
        raise NothingToCompareError("no random numbers reach it: two runs are the same, and rounding alone is no noise")
    spectrum = proofmass.spectrum(noise, segment=segment)
    expected = _expected(graph, case.output, at, segment, budget.rate)[_LINES]
    return Row(case, budget, at, float(np.std(noise.values)), _inside(expected, spectrum), seconds)


def budget_of(graph: Graph, output: str) -> tuple[NoiseBudget, str | None]:
    """Return the budget at the first operating point that there is; raises the `ModelError` of the first."""
    refused: ModelError | None = None
    for at in POINTS:
        try:
            return proofmass.noise(graph, output, at=at), at
        except ModelError as error:
            refused = refused or error
    raise refused or AssertionError


def _noise(graph: Graph, case: Case, budget: NoiseBudget) -> Series:
    probed = _probed(graph, case.output)
    stride = proofmass.simulate(probed, samples=1)[case.output].stride
    values = min(case.values, TICKS // stride)
    if values < FEWEST:
        raise NothingToCompareError(f"one value in {stride:,} ticks")
    runs = [proofmass.simulate(probed, samples=values * stride, seed=seed)[case.output] for seed in (1, 2)]
    apart = (runs[0].values.astype(float) - runs[1].values) / np.sqrt(2.0)
    return Series(apart, 1.0 / budget.rate, case.output, budget.unit)


def _probed(graph: Graph, output: str) -> Graph:
    """The graph with this probe alone."""
    return replace(graph, probes=(read_probe(output),), measures={}, derived={}, duration=None)


def _expected(graph: Graph, output: str, at: str | None, segment: int, rate: float) -> Any:
    """Mean of the Welch spectrum by the predicted density."""
    fine = np.arange(1, _FINE * segment // 2 + 1) * rate / (_FINE * segment)
    top = fine[-1] >= 0.5 * rate * (1.0 - 1e-12)
    density = proofmass.noise(graph, output, at=at, frequencies=(fine[:-1] if top else fine).tolist()).density
    density = np.append(density, density[-1]) if top else density
    both = np.concatenate([density[:1], density, density[-2::-1]])  # from zero to the rate
    shape = np.abs(np.fft.fft(window("hann", segment), _FINE * segment)) ** 2
    spread = np.fft.ifft(np.fft.fft(both) * np.fft.fft(shape / np.sum(shape))).real
    return spread[: _FINE * segment // 2 + 1 : _FINE]


def _inside(predicted: Any, spectrum: Spectrum) -> float:
    """Part of the lines whose density is as likely as the confidence says."""
    known = predicted > LEAST * np.max(predicted)
    low, high = chi2.ppf([0.5 - CONFIDENCE / 2.0, 0.5 + CONFIDENCE / 2.0], spectrum.freedom) / spectrum.freedom
    ratio = spectrum.density[_LINES][known] / predicted[known]
    return float(np.mean((low <= ratio) & (ratio <= high)))


def scatters(graph: Graph, rows: Sequence[Row]) -> list[Scatter]:
    """Return what many runs show of some outputs of a graph."""
    looks, strides, base = list[list[Fraction]](), list[int](), plan(graph).schedule.base_rate
    for line in rows:
        output, budget = line.case.output, line.budget
        strides.append(proofmass.simulate(_probed(graph, output), samples=1)[output].stride)
        last = min(RUN_VALUES, RUN_TICKS // strides[-1])
        phases = min(PHASES, max(1, LOOKS // len(rows)), max(1, round(budget.period * budget.rate)))
        step = Fraction(strides[-1]) / base
        ends = [last - round(i * budget.period * budget.rate / phases) for i in range(phases)]
        looks.append([step * end for end in (*ends, *(end - last // 2 for end in ends))])
    measures = {
        f"m{i}_{j}": Measure(line.case.output, "last", until=until)
        for i, (line, times) in enumerate(zip(rows, looks, strict=True))
        for j, until in enumerate(times)
    }
    ticks = max(math.ceil(times[0] * base) for times in looks)
    whole = replace(graph, probes=(), measures=measures, derived={}, duration=None, samples=ticks)
    values = proofmass.run_study(proofmass.Study(whole, runs=RUNS, seed=SEED)).values
    return [
        _scatter(graph, line, np.array([values[f"m{i}_{j}"] for j in range(len(times))]), strides[i])
        for i, (line, times) in enumerate(zip(rows, looks, strict=True))
    ]


def _scatter(graph: Graph, line: Row, values: Any, stride: int) -> Scatter:
    now, before = np.split(values, 2)
    span = (min(RUN_VALUES, RUN_TICKS // stride) // 2) / line.budget.rate
    square = line.budget.rms**2
    wanders = line.budget.band[0] > 0.0
    if not wanders:
        slow = proofmass.noise(graph, line.case.output, at=line.at, band=(0.0, 0.25 / span)).rms ** 2
        wanders = slow > SLOW * square
    if wanders:
        now, square = now - before, _increment(graph, line, span)
    apart = now - now.mean(axis=1, keepdims=True)
    squares = np.mean(apart**2, axis=0) * RUNS / (RUNS - 1)
    error = float(np.std(squares, ddof=1)) / math.sqrt(RUNS)
    return Scatter((float(np.mean(squares)) - square) / error if error else math.inf, wanders)


def _increment(graph: Graph, line: Row, span: float) -> float:
    """Mean square of the change over a time, by the density."""
    top = 0.5 * line.budget.rate * (1.0 - 1e-9)
    turning = min(64.0 / span, top)
    f = np.concatenate([np.geomspace(1e-3 / span, 0.05 / span, 60)[:-1], np.linspace(0.05 / span, turning, 6000)])
    f = np.concatenate([f, np.geomspace(turning, top, 2000)[1:]]) if turning < top else f
    density = proofmass.noise(graph, line.case.output, at=line.at, frequencies=f.tolist()).density
    weight = np.where(f <= turning, 4.0 * np.sin(np.pi * f * span) ** 2, 2.0)
    return float(np.trapezoid(density * weight, f)) + float(density[0] * weight[0] * f[0])


class NothingToCompareError(Exception):
    """Runs that say nothing of a budget."""


class OutOfTimeError(BaseException):
    """A budget that takes too long; not an `Exception`, which a block that fails raises."""


def _out_of_time(*_: Any) -> None:
    raise OutOfTimeError(f"more than {PATIENCE} s of processor time")


def main() -> None:
    """Print the table."""
    print(
        f"{'graph':<36} {'output':<26} {'predicted':>11} {'of runs':>11} {'inside':>8} {'1,000 runs':>12} {'budget':>8}"
        "  largest source"
    )
    signal.signal(signal.SIGPROF, _out_of_time)
    for path, graph, outputs in noisy_graphs(sys.argv[1:]):
        rows = list[Row]()
        for output in outputs:
            signal.setitimer(signal.ITIMER_PROF, PATIENCE)
            try:
                rows.append(row(Case(path.name, output)))
            except (ModelError, NothingToCompareError, OutOfTimeError) as error:
                print(f"{path.stem:<36} {output:<26} {str(error).splitlines()[0][:110]}", flush=True)
            signal.setitimer(signal.ITIMER_PROF, 0.0)
        for line, many in zip(rows, scatters(graph, rows) if rows else (), strict=True):
            first = line.budget.sources[0]
            print(
                f"{path.stem:<36} {line.case.output:<26} {line.budget.rms:11.4g} {line.rms:11.4g}"
                f" {100.0 * line.inside:6.1f} % {many.errors:+9.2f} SE{'d' if many.increments else ' '}"
                f" {line.seconds:6.2f} s  {first.block} {100.0 * first.share:.0f} %"
                f"{', ' + line.at if line.at else ''}",
                flush=True,
            )


if __name__ == "__main__":
    main()
