"""Parameters of a graph that make its outputs those of recordings, and how well they are known."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import scipy.special

from proofmass.blocks.declaration.problem import Problem, Refusal, did_you_mean, shown
from proofmass.graphs.files.toml_reader import GraphSource, graph_from
from proofmass.graphs.model.call_numbers import SEED, refuse_counts
from proofmass.graphs.model.changes import with_parameters
from proofmass.graphs.model.graph import Graph
from proofmass.graphs.model.rates import read_duration
from proofmass.runner.design.identification.identifiable import certainty, freedom, widening
from proofmass.runner.design.identification.model import RecordingModel, output_units
from proofmass.runner.design.identification.noise_levels import NoiseLevel, noise_levels
from proofmass.runner.design.identification.recordings import FEWEST, Gaps, RecordedStretch, Wanted, recordings_of
from proofmass.runner.design.identification.solve import LOSSES, Solution, UnknownsSolver
from proofmass.runner.design.identification.unknowns import DELAY, OFFSET, Unknown, parameters_of
from proofmass.runner.design.identification.whiteness import Whiteness, whiteness
from proofmass.runner.design.quantities.stopping import InterruptedSearch
from proofmass.runner.host.arrays import AnyArray
from proofmass.runner.host.interrupts import interrupts
from proofmass.runner.host.notebook import Plotted, Told
from proofmass.runner.host.progress import Progress
from proofmass.runner.output.json_text import finite

CONFIDENCE = 0.95
MOST_STARTS = 1000
_DIGITS = 9

_FAR = 0.5  # part of the variance below which another start may explain more


@dataclass(frozen=True)
class Estimate:
    """An unknown: its value, and half of its interval of 95 %, infinite if undetermined."""

    name: str
    unit: str
    before: float
    value: float
    standard_error: float
    half_width: float
    at_bound: str  # "lower", "upper" or ""


@dataclass(frozen=True)
class OutputFit:
    """Agreement of an output with its recordings."""

    signal: str
    unit: str
    rms: float  # of the residuals
    noise: float  # of a value of the recording
    explained: float  # part of the variance
    whiteness: Whiteness


@dataclass(frozen=True, eq=False, repr=False)
class Fitted(Told, Plotted):
    """The result of a fit.

    >>> from proofmass import fit, read_graph, simulate
    >>> graph = read_graph("library:template")
    >>> damped = graph.with_parameters({"sensor.damping": "4e-3 kg/s"})
    >>> trace = simulate(damped, duration="10 ms")["sensor.displacement"]
    >>> data = {"time": trace.times, "place": trace.values}
    >>> fitted = fit(graph, data, outputs={"sensor.displacement": "place"}, free=["sensor.damping"])
    >>> fitted.determined, round(fitted.graph.blocks["sensor"].damping, 6)
    (True, 0.004)
    """

    source: Graph  # the graph before
    estimates: tuple[Estimate, ...]  # of free parameters, with intervals
    outputs: tuple[OutputFit, ...]  # how well each is explained
    levels: tuple[NoiseLevel, ...]  # of noise
    correlation: AnyArray  # of the estimates, a matrix
    findings: tuple[str, ...]  # about unknowns that are not identifiable
    notes: tuple[str, ...]  # on the recordings
    rows: int  # that were compared
    runs: int  # of the graph
    starts: int  # of the search
    reached: int  # starts that ended at the best solution
    converged: bool  # True if the search ended by itself
    interrupted: bool  # True after Ctrl-C
    recordings: tuple[RecordedStretch, ...]  # as they were read
    modelled: tuple[Mapping[str, AnyArray], ...]  # outputs of each recording with the fitted values
    written: Mapping[str, str]  # names of parameters as written, by those of the flat graph

    @property
    def determined(self) -> bool:
        """True if the recordings determine every unknown."""
        return not self.findings

    @property
    def changes(self) -> dict[str, float | str]:
        """The parameters with their units, by the names that the graph file has."""
        estimates = {e.name: (e.value, e.unit) for e in self.estimates if not e.name.startswith((OFFSET, DELAY))}
        estimates |= {level.parameter: (level.value, level.unit) for level in self.levels if level.value is not None}
        return {
            name: f"{float(f'{value:.{_DIGITS}g}')!r} {unit}" if unit != "1" else float(f"{value:.{_DIGITS}g}")
            for name, (value, unit) in estimates.items()
        }

    @cached_property
    def graph(self) -> Graph:
        """The graph with the fitted parameters."""
        return with_parameters(self.source, self.changes)

    def as_data(self) -> dict[str, Any]:
        """Plain data, for `--json`."""
        return {
            "parameters": {
                e.name: {
                    "before": e.before,
                    "value": e.value,
                    "unit": e.unit,
                    "standard_error": finite(e.standard_error),
                    "half_width": finite(e.half_width),
                    "at_bound": e.at_bound or None,
                }
                for e in self.estimates
            },
            "noise_levels": {level.parameter: level.as_data() for level in self.levels},
            "correlation": [[finite(v) for v in row] for row in self.correlation.tolist()],
            "determined": self.determined,
            "findings": list(self.findings),
            "outputs": {
                o.signal: {
                    "unit": o.unit,
                    "rms": o.rms,
                    "noise": o.noise,
                    "explained": o.explained,
                    "white": o.whiteness.white,
                    "chance": o.whiteness.chance,
                    "autocorrelation": o.whiteness.autocorrelation.tolist(),
                }
                for o in self.outputs
            },
            "rows": self.rows,
            "runs": self.runs,
            "starts": self.starts,
            "starts_that_agree": self.reached,
            "converged": self.converged,
            "interrupted": self.interrupted,
            "notes": list(self.notes),
        }


def fit(
    graph: GraphSource,
    data: object,
    *,
    outputs: Mapping[str, str] | Sequence[str],
    free: Mapping[str, object] | Sequence[str],
    inputs: Mapping[str, str] | Sequence[str] = (),
    offsets: Sequence[str] = (),
    delays: Sequence[str] = (),
    levels: Sequence[str] = (),
    loss: str = "linear",
    starts: int = 1,
    skip: str | float = 0.0,
    gaps: Gaps = "refuse",
    interpolated: bool = False,
    seed: int = 0,
    progress: Progress | None = None,
) -> Fitted:
    """Find the parameters with which a graph gives what was recorded.

    `data` is a recording or a list of them: a file (CSV, Parquet, netCDF), a table of arrays with
    the times under "time", or an xarray dataset. `inputs` and `outputs` map signals of the graph to
    columns; a list of signals stands for columns of the same names. `free` lists parameters, or
    maps them to what is known of them:
    `{"sensor.stiffness": {"at_least": "100 N/m", "expected": "132 N/m", "uncertainty": "3 N/m"}}`.

    `offsets` and `delays` are outputs whose recording has an unknown constant, or lags by an
    unknown time. `levels` are noise parameters, such as "amplifier.density", that are found from
    what is left. `loss` is "linear", "robust" or "outliers". With several `starts` others are drawn
    within the bounds. What lies before `skip` is run but not compared. Recorded inputs are held
    until the next row, or `interpolated`. The graph runs without its noise.

    Ctrl-C ends the fit; the best values so far are the result. Raises `ModelError` with everything
    that is wrong.

    `graph` has values to start from. `gaps` are refused, or recordings are split there. `seed` is
    that of further starts, and `progress` is called with the runs that are done and the most there
    may be.

    >>> from proofmass import fit, read_graph, simulate
    >>> graph = read_graph("library:template")
    >>> damped = graph.with_parameters({"sensor.damping": "4e-3 kg/s"})
    >>> trace = simulate(damped, duration="10 ms")["sensor.displacement"]
    >>> data = {"time": trace.times, "place": trace.values}
    >>> fitted = fit(graph, data, outputs={"sensor.displacement": "place"}, free=["sensor.damping"])
    >>> round(fitted.estimates[0].value, 6), fitted.estimates[0].unit
    (0.004, 'kg/s')
    """
    if loss not in LOSSES:
        hint = did_you_mean(loss, LOSSES, "the losses")
        raise Problem(message="there is no such loss", key="loss", got=shown(loss), hint=hint).error
    graph = graph_from(graph)
    refuse_counts(starts=(starts, 1, MOST_STARTS), seed=(seed, *SEED))
    try:
        left_out = float(read_duration(skip))
    except Refusal as error:
        raise error.problem("skip", skip).error from None
    wanted = _signals(graph, inputs), _signals(graph, outputs)
    if not wanted[1]:
        hint = 'name what was recorded: outputs={"readout.voltage": "voltage"}'
        raise Problem(message="names no output", key="outputs", hint=hint).error
    parameters = parameters_of(graph, free)
    unknowns = [*parameters, *_shifts(wanted[1], offsets, delays)]
    if not unknowns and not levels:
        raise Problem(message="leaves nothing free", key="free", hint="name a parameter").error
    recordings, notes = recordings_of(data, *wanted, gaps)
    names = [unknown.name for unknown in parameters]
    models = [RecordingModel(graph, recording, interpolated, names) for recording in recordings]
    if any(model.between_ticks for model in models):
        notes.append("recorded times lie between ticks: straight lines between the values of the run are compared")
    with interrupts() as stop:
        solver = UnknownsSolver(models, unknowns, loss, left_out, progress, stop)
        _refuse_few(solver, unknowns)
        solution, reached, interrupted = _best(solver, unknowns, starts, seed)
    return _outcome(graph, solver, solution, (starts, reached, interrupted), notes, levels)


def _signals(graph: Graph, given: Mapping[str, str] | Sequence[str]) -> list[Wanted]:
    columns = dict(given) if isinstance(given, Mapping) else {signal: signal for signal in given}
    units = output_units(graph, list(columns))
    return [Wanted(signal, column or signal, units[signal]) for signal, column in columns.items()]


def _shifts(outputs: Sequence[Wanted], offsets: Sequence[str], delays: Sequence[str]) -> list[Unknown]:
    units, unknowns = {w.signal: w.unit for w in outputs}, list[Unknown]()
    for kind, signals in ((OFFSET, offsets), (DELAY, delays)):
        for signal in signals:
            if signal not in units:
                hint = did_you_mean(signal, units, "the outputs")
                raise Problem(message="is not an output of the fit", key=signal, hint=hint).error
            name = f"{kind} {signal}"
            unknowns.append(Unknown(name, name, units[signal] if kind == OFFSET else "s", 0.0))
    return unknowns


def _refuse_few(solver: UnknownsSolver, unknowns: Sequence[Unknown]) -> None:
    counts = {signal: len(solver.compared(signal)) for signal in solver.signals}
    for signal, count in counts.items():
        if count < FEWEST:  # of fewer, what is left tells no noise, by which outputs are weighed
            message, expected = "too few values are left to compare", f"at least {FEWEST}"
            raise Problem(message=message, key=signal, got=str(count), expected=expected).error
    rows = sum(counts.values())
    if rows <= len(unknowns):
        message, expected = "too few values are left to compare", f"more than {len(unknowns)}, one for each unknown"
        raise Problem(message=message, key="data", got=str(rows), expected=expected).error


def _best(solver: UnknownsSolver, unknowns: Sequence[Unknown], starts: int, seed: int) -> tuple[Solution, int, bool]:
    """Return the best of all starts, how many end there, and whether Ctrl-C ended it."""
    begin = np.array([unknown.start for unknown in unknowns])
    drawn = np.random.default_rng(seed).random((max(starts - 1, 0), len(unknowns)))
    known = list(zip(unknowns, solver.scales.tolist(), strict=True))
    others = [np.array([u.sampled(p, size) for (u, size), p in zip(known, row, strict=True)]) for row in drawn]
    counts = {signal: len(solver.compared(signal)) for signal in solver.signals}
    rows = sum(counts.values())
    first_noise, solutions, interrupted = dict(solver.noise), list[tuple[float, Solution]](), False
    try:
        for start in (begin, *others):
            solver.noise = dict(first_noise)
            solution = solver.solved(start)
            size = sum(math.log(solution.noise[s]) * (counts[s] / rows) for s in solver.signals)
            solutions.append((size, solution))
    except InterruptedSearch:
        interrupted = True
        solver.interrupt()
        if not solutions:
            values = solver.best[1] if solver.best else begin
            solutions.append((0.0, solver.as_it_is(values)))
    best = min(size for size, _ in solutions)
    reached = sum(size <= best + 1e-4 for size, _ in solutions)
    chosen = next(solution for size, solution in solutions if size == best)
    solver.noise = dict(chosen.noise)
    return chosen, reached, interrupted


def _elsewhere(outputs: Sequence[OutputFit], ran: tuple[int, int, bool]) -> Iterator[str]:
    """Yield a note where a search from one start ends far from the recordings."""
    starts, _, interrupted = ran
    least = min(outputs, key=lambda output: output.explained)
    if starts == 1 and not interrupted and least.explained < _FAR:
        yield (
            f"only {100.0 * least.explained:.3g} % of {least.signal} is explained: the search may have ended in a "
            "local minimum; --tries 8 (starts=8 in Python) begins at others, too"
        )


def _outcome(
    graph: Graph,
    solver: UnknownsSolver,
    solution: Solution,
    ran: tuple[int, int, bool],
    notes: list[str],
    levels: Sequence[str],
) -> Fitted:
    unknowns, values = solver.unknowns, solution.values
    rows, table = len(solution.residuals), solution.jacobian.copy()
    table[:rows] /= widening(solution.residuals, solver.loss)
    sure = certainty(table, values, unknowns, solver.recorded())
    for number, unknown in enumerate(unknowns):
        if unknown.name.startswith(DELAY):
            signal = unknown.name.removeprefix(f"{DELAY} ")
            least = min(model.least_error(signal) for model in solver.models if signal in model.signals)
            sure.errors[number] = math.hypot(sure.errors[number], least)
    sizes = np.abs(values) + solver.scales
    degrees = freedom(table * sizes, solver.output_of, [solution.free[signal] for signal in solver.signals])
    quantiles = scipy.special.stdtrit(np.maximum(degrees, 1.0), (1.0 + CONFIDENCE) / 2.0)
    estimates = tuple(
        Estimate(u.written, u.unit, u.start, float(v), float(e), float(q * e), _bound(u, float(v), size))
        for u, v, e, q, size in zip(unknowns, values, sure.errors, quantiles, solver.scales.tolist(), strict=True)
    )
    raw = solver.raw(values)
    outputs = tuple(_output(solver, signal, raw) for signal in solver.signals)
    known = {u.name: float(v) for u, v in zip(unknowns, values, strict=True) if u.of_block}
    fitted = with_parameters(graph, {u.written: known[u.name] for u in unknowns if u.of_block})
    counts = {signal: len(solver.compared(signal)) for signal in solver.signals}
    left = {o.signal: (o.rms**2 * counts[o.signal], solution.free[o.signal]) for o in outputs}
    return Fitted(
        source=graph,
        estimates=estimates,
        outputs=outputs,
        levels=tuple(noise_levels(fitted, levels, left)),
        correlation=sure.correlation,
        findings=sure.findings,
        notes=(*notes, *_elsewhere(outputs, ran)),
        rows=rows,
        runs=solver.runs,
        starts=ran[0],
        reached=ran[1],
        converged=solution.converged,
        interrupted=ran[2],
        recordings=tuple(model.recording for model in solver.models),
        modelled=tuple(solver.modelled(values)),
        written={u.name: u.written for u in unknowns},
    )


def _output(solver: UnknownsSolver, signal: str, raw: Sequence[tuple[str, AnyArray]]) -> OutputFit:
    parts = [part for name, part in raw if name == signal]
    values = np.concatenate(parts)
    longest = max(parts, key=len)
    model = next(model for model in solver.models if signal in model.signals)
    rms = float(np.sqrt(np.mean(values**2)))
    moved = solver.spread(signal)
    probe = model.plan.probes[model.signals.index(signal)]
    return OutputFit(signal, probe.unit, rms, solver.noise[signal], 1.0 - (rms / moved) ** 2, whiteness(longest))


def _bound(unknown: Unknown, value: float, size: float) -> str:
    near = 1e-6 * size
    return "lower" if value - unknown.at_least <= near else "upper" if unknown.at_most - value <= near else ""
