"""Noise budgets beside runs: spectra of two long runs, mean squares of many, and values at one time."""

import math
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
from proofmass.blocks.arithmetic.fixed_point import FixedValue
from proofmass.graphs.model.build import read_probe
from proofmass.graphs.model.loops import AUTO
from proofmass.graphs.model.measures import Measure
from proofmass.graphs.model.targets import is_of_measure
from proofmass.runner.analysis.linearisation.ends import Ends
from proofmass.runner.analysis.linearisation.linearisation import OperatingPoints
from proofmass.runner.analysis.linearisation.linearise import node_of
from proofmass.runner.analysis.noise.budget import BudgetQuestion, budget_at
from proofmass.runner.analysis.noise.over_runs import ValueDeviation, densities
from proofmass.runner.analysis.spectrum.windows import window
from proofmass.runner.derivatives.dual_noise import given, noise_blocks
from proofmass.runner.plan.bindings import Deviate
from proofmass.runner.plan.planned import Plan
from proofmass.runner.planning.plan import plan

LIBRARY = Path(__file__).parents[1] / "graphs" / "library"
CONFIDENCE, SEED = 0.99, 7
VALUES, FEWEST, TICKS = 20_000, 1_000, 8_000_000  # of an output in a run, and base ticks
SEGMENT, SEGMENTS = 1024, 40
PERIODS, LONG, LONG_SEGMENT = (
    200,
    100,
    1000,
)  # common periods of a run; long ones, in values, and segments for them
RUNS, RUN_VALUES, RUN_TICKS = 1000, 12_000, 65_536
FOLLOWED = 200_000  # ticks of a run that derivatives follow, at most
PHASES, LOOKS = 64, 256  # of the period of the schedule at which a run is looked at, and for all outputs, at most
SLOW = 0.01  # of the mean square, below the lowest frequency of a run
END = "end"  # of the graph's own run
POINTS = (None, "periodic", "settled", END)  # operating points, the first that stands still, else the first
FEW_RUNS, SHORTEST, LONGEST = 200, 32, 512  # of the spectra of last values, and how many these are
MOVES = "operating point moves"  # of a note
LARGE_NOISE = "noise is not small"  # of a note, and a reason
DECISIONS = "runs differ by the decisions that it moves"
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
    stride: int  # base ticks from value to value
    square: float  # predicted, of the output, or of its increment over half a run
    increments: bool  # whether it is that


@dataclass(frozen=True)
class AtEnd:
    """What is predicted of the last values of a run, and what runs show."""

    value: ValueDeviation
    deviation: float  # of runs
    errors: float  # standard errors, by which the mean square differs
    inside: float | None  # part of the lines of the spectrum of the last values, where there are enough
    seconds: float  # of processor time


class Subject:
    """A graph and its operating points, of which each is looked for once."""

    def __init__(self, graph: Graph) -> None:
        formulas = {target: formula for target, formula in graph.formulas.items() if not is_of_measure(graph, target)}
        self.graph = replace(graph, probes=(), measures={}, derived={}, requirements={}, formulas=formulas)
        self.plan = plan(self.graph)
        self._points = dict[str | None, OperatingPoints]()
        self._latest = POINTS[0]

    def budget(self, output: str, **options: Any) -> tuple[NoiseBudget, str | None]:
        """Return the budget at the first operating point that stands still, or else at the first that there is."""
        budgets, refused = list[tuple[NoiseBudget, str | None]](), list[ModelError]()
        for at in sorted(POINTS, key=lambda at: at != self._latest):
            try:
                budgets.append((self.budget_at(output, at, **options), at))
            except ModelError as error:
                refused.append(error)
            else:
                if not any(MOVES in note for note in budgets[-1][0].notes):
                    self._latest = at
                    return budgets[-1]
        if not budgets:
            raise refused[0]
        return budgets[0]

    def budget_at(self, output: str, at: str | None, **options: Any) -> NoiseBudget:
        """Return the budget at an operating point."""
        if at not in self._points:
            self._points[at] = OperatingPoints(self.plan, AUTO if at is None else self._time(at))
        return budget_at(self._points[at], output, BudgetQuestion(**options))

    def _time(self, at: str) -> str | Fraction:
        return (self.plan.ticks() - 1) / self.plan.schedule.base_rate if at == END else at

    def stride(self, output: str) -> int:
        """Return the base ticks from value to value."""
        return self.plan.stride(node_of(self.plan, output))

    def period(self, output: str) -> int:
        """Return the base ticks after which all blocks that noise takes to an output tick together again, or less."""
        node = node_of(self.plan, output)
        try:
            return Ends((), (node,), noise=noise_blocks(self.plan)).common_period(self.plan)
        except ModelError:  # too long for a budget
            return self.plan.stride(node)

    def drawn(self, output: str) -> bool:
        """Return whether random numbers reach an output."""
        upstream = Ends((), (node_of(self.plan, output),)).blocks(self.plan)[0]
        return bool(upstream & given(self.plan, (Deviate,)))


def noisy_graphs(names: Sequence[str] = ()) -> Iterator[tuple[Path, Graph, list[str]]]:
    """Yield the graphs of the library, and of each the outputs that noise reaches."""
    for path in sorted(LIBRARY.rglob("*.toml"), key=lambda path: path.name):
        if "parts" in path.parts or path.name == "template.toml" or (names and path.stem not in names):
            continue
        try:
            graph = proofmass.read_graph(path)
        except ModelError:  # a study of another file
            continue
        planned = plan(replace(graph, requirements={}))
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
        if type(planned.blocks[node[0]]).outputs[node[1]].dtype is FixedValue:  # measures take numbers
            continue
        if Ends((), (node,)).blocks(planned)[0] & noisy.keys():
            yield name


def row(case: Case, subject: Subject | None = None) -> Row:
    """Return the comparison of one output with two runs."""
    subject = subject or Subject(proofmass.read_graph(next(LIBRARY.rglob(case.file))))
    if not subject.drawn(case.output):
        raise NothingToCompareError("rounding alone", _of_rounding(subject, case.output))
    stride = subject.stride(case.output)
    repeats = subject.period(case.output) // stride  # values, after which statistics come again
    values = min(max(case.values, PERIODS * repeats), TICKS // stride)
    if values < FEWEST:
        raise NothingToCompareError("too few values", f"one value in {stride:,} ticks")
    rate = float(subject.plan.schedule.base_rate) / stride
    segment = max(32, min(case.segment if repeats < LONG else LONG_SEGMENT, values // SEGMENTS))
    fine = np.arange(1, _FINE * segment // 2) * rate / (_FINE * segment)
    began = time.process_time()
    budget, at = subject.budget(case.output, frequencies=fine.tolist())
    seconds = time.process_time() - began
    strained = [note for note in budget.notes if note.startswith(LARGE_NOISE)]
    if strained:
        raise NothingToCompareError(LARGE_NOISE, strained[0])
    noise = _noise(subject.graph, case, budget, values * stride)
    if not np.any(noise.values):
        raise NothingToCompareError("runs are alike", "two runs of different seeds are the same")
    spectrum = proofmass.spectrum(noise, segment=segment)
    inside = _inside(_expected(budget.density, segment)[_LINES], spectrum, 2.0 * values / repeats)
    square, increments = _square(subject, case.output, budget, at, (_last(stride) // 2) / rate)
    rms = float(np.std(noise.values))
    return Row(case, budget, at, rms, inside, seconds, stride, square, increments)


def _of_rounding(subject: Subject, output: str) -> str:
    """Return why roundings alone make no noise, and by how much noise moves the input of the largest."""
    sentence = "no random numbers reach it, and what rounding does repeats with the signal"
    try:
        first = subject.budget(output)[0].sources[0]
    except ModelError:
        return sentence
    return sentence + (f": {first.block} is moved by {first.dither.change:.2g} steps" if first.dither else "")


def _noise(graph: Graph, case: Case, budget: NoiseBudget, ticks: int) -> Series:
    probed = replace(graph, probes=(read_probe(case.output),), duration=None)
    runs = [proofmass.simulate(probed, samples=ticks, seed=seed)[case.output] for seed in (1, 2)]
    apart = (runs[0].values.astype(float) - runs[1].values) / np.sqrt(2.0)
    return Series(apart, 1.0 / budget.rate, case.output, budget.unit)


def _expected(density: Any, segment: int) -> Any:
    """Mean of the Welch spectrum by the predicted density."""
    density = np.append(density, density[-1])
    both = np.concatenate([density[:1], density, density[-2::-1]])  # from zero to the rate
    shape = np.abs(np.fft.fft(window("hann", segment), _FINE * segment)) ** 2
    spread = np.fft.ifft(np.fft.fft(both) * np.fft.fft(shape / np.sum(shape))).real
    return spread[: _FINE * segment // 2 + 1 : _FINE]


def _inside(predicted: Any, spectrum: Spectrum, most: float) -> float:
    """Part of the lines whose density is as likely as the confidence says, with at most so many degrees of freedom."""
    known, freedom = predicted > LEAST * np.max(predicted), min(spectrum.freedom, most)
    low, high = chi2.ppf([0.5 - CONFIDENCE / 2.0, 0.5 + CONFIDENCE / 2.0], freedom) / freedom
    ratio = spectrum.density[_LINES][known] / predicted[known]
    return float(np.mean((low <= ratio) & (ratio <= high)))


def scatters(subject: Subject, rows: Sequence[Row]) -> list[float]:
    """Return by how many standard errors the mean squares of many runs differ, for some outputs of a graph."""
    looks, base = list[list[Fraction]](), subject.plan.schedule.base_rate
    for line in rows:
        last, budget = _last(line.stride), line.budget
        phases = min(PHASES, max(1, LOOKS // len(rows)), max(1, round(budget.period * budget.rate)))
        step = Fraction(line.stride) / base
        ends = [last - round(i * budget.period * budget.rate / phases) for i in range(phases)]
        looks.append([step * end for end in (*ends, *(end - last // 2 for end in ends))])
    measures = {
        f"m{i}_{j}": Measure(line.case.output, "last", until=until)
        for i, (line, times) in enumerate(zip(rows, looks, strict=True))
        for j, until in enumerate(times)
    }
    ticks = max(math.ceil(times[0] * base) for times in looks)
    whole = replace(subject.graph, measures=measures, duration=None, samples=ticks)
    values = proofmass.run_study(proofmass.Study(whole, runs=RUNS, seed=SEED)).values
    return [
        _scatter(line, np.array([values[f"m{i}_{j}"] for j in range(len(times))]))
        for i, (line, times) in enumerate(zip(rows, looks, strict=True))
    ]


def _last(stride: int) -> int:
    """Number of the last value of a run."""
    return min(RUN_VALUES, RUN_TICKS // stride)


def _scatter(line: Row, values: Any) -> float:
    """Return by how many standard errors the mean square over runs differs from the predicted one."""
    now, before = np.split(values, 2)
    return _errors(now - before if line.increments else now, line.square)


def _errors(values: Any, square: float) -> float:
    apart = values - values.mean(axis=1, keepdims=True)
    squares = np.mean(apart**2, axis=0) * RUNS / (RUNS - 1)
    error = float(np.std(squares, ddof=1)) / math.sqrt(RUNS)
    return (float(np.mean(squares)) - square) / error if error else math.inf


def _square(subject: Subject, output: str, budget: NoiseBudget, at: str | None, span: float) -> tuple[float, bool]:
    """Return the predicted mean square of the output, or that of its increment where it wanders or settles slowly."""
    wanders = budget.band[0] > 0.0
    if not wanders:
        wanders = subject.budget_at(output, at, band=(0.0, 0.25 / span)).rms ** 2 > SLOW * budget.rms**2
    return (_increment(subject, output, budget, at, span), True) if wanders else (budget.rms**2, False)


def _increment(subject: Subject, output: str, budget: NoiseBudget, at: str | None, span: float) -> float:
    """Mean square of the change over a time, by the density."""
    top = 0.5 * budget.rate * (1.0 - 1e-9)
    turning = min(64.0 / span, top)
    f = np.concatenate([np.geomspace(1e-3 / span, 0.05 / span, 60)[:-1], np.linspace(0.05 / span, turning, 6000)])
    f = np.concatenate([f, np.geomspace(turning, top, 2000)[1:]]) if turning < top else f
    density = subject.budget_at(output, at, frequencies=f.tolist()).density
    weight = np.where(f <= turning, 4.0 * np.sin(np.pi * f * span) ** 2, 2.0)
    return float(np.trapezoid(density * weight, f)) + float(density[0] * weight[0] * f[0])


class NothingToCompareError(Exception):
    """Runs that say nothing of a budget: what kind of reason there is, and a sentence."""


def at_end(subject: Subject, outputs: Sequence[str]) -> list[AtEnd | str]:
    """Return the comparison of the last values of the graph's own run, or a sentence that says why there is none."""
    ticks = subject.plan.ticks()
    if ticks > FOLLOWED:
        return [f"and its run of {ticks:,} ticks is too long to be followed"] * len(outputs)
    lengths = {output: _length(ticks // subject.stride(output)) for output in outputs}
    answers = dict[str, AtEnd | str]()
    measures = {f"m{i}": Measure(output, "last") for i, output in enumerate(outputs)}
    values = proofmass.run_study(
        proofmass.Study(replace(subject.graph, measures=measures), runs=RUNS, seed=SEED)
    ).values
    probed = replace(subject.graph, probes=tuple(map(read_probe, outputs)))
    runs = [proofmass.simulate(probed, seed=seed) for seed in range(1, FEW_RUNS + 1)]
    for length in sorted(set(lengths.values())):
        chosen = [output for output in outputs if lengths[output] == length]
        weights, began = window("hann", max(length, 2)), time.process_time()
        try:
            predicted = densities(subject.plan, chosen, ticks, weights)
        except ModelError as error:
            answers |= dict.fromkeys(chosen, error.problems[0].message)
            continue
        seconds = time.process_time() - began
        for output, (value, frequencies, density) in zip(chosen, predicted, strict=True):
            several = np.array(values[f"m{outputs.index(output)}"], dtype=float)[None]
            differ = bool(np.ptp(several))
            if not value.deviation or not differ:
                answers[output] = f"small noise changes nothing there, and {DECISIONS if differ else 'runs agree'}"
                continue
            traces = np.array([run[output].values[-len(weights) :] for run in runs], dtype=float)
            power = density * float(frequencies[-1] * np.sum(weights**2))  # of a line, half the rate being last
            inside = _inside_lines(traces, weights, power) if length else None
            errors = _errors(several, value.deviation**2)
            answers[output] = AtEnd(value, float(np.std(several, ddof=1)), errors, inside, seconds)
    return [answers[output] for output in outputs]


def _length(values: int) -> int:
    """Return how many last values of a run have a spectrum; zero where they are too few."""
    return 0 if values < 2 * SHORTEST else min(LONGEST, 1 << (values // 2).bit_length() - 1)


def _inside_lines(traces: Any, weights: Any, density: Any) -> float:
    """Part of the lines of the mean spectrum of runs that are as likely as the confidence says."""
    apart = (traces - traces.mean(axis=0)) * math.sqrt(len(traces) / (len(traces) - 1.0))
    lines = np.mean(np.abs(np.fft.rfft(apart * weights, axis=1)) ** 2, axis=0)[1:-1]
    expected, freedom = density[1:-1], 2 * (len(traces) - 1)
    low, high = chi2.ppf([0.5 - CONFIDENCE / 2.0, 0.5 + CONFIDENCE / 2.0], freedom) / freedom
    seen = expected > LEAST * np.max(expected)
    ratio = lines[seen] / expected[seen]
    return float(np.mean((low <= ratio) & (ratio <= high)))
