"""The option `--sweep` of `run`: a graph run at each point of a sweep."""

from collections.abc import Sequence
from pathlib import Path

from proofmass.blocks.declaration.problem import ModelError, Problem, did_you_mean
from proofmass.graphs.model.graph import Graph
from proofmass.runner.commands.answers import DONE, print_answer, print_files
from proofmass.runner.commands.declarations.graphs import RunRequest
from proofmass.runner.commands.swept_values import sweeps
from proofmass.runner.output.counts import count
from proofmass.runner.output.sweeps import plot_sweep, save_sweep_csv, sweep_lines
from proofmass.runner.run.sweep import Sweep, sweep


def run_sweep(graph: Graph, request: RunRequest) -> int:
    """Run a graph at each point, show measures, write table and curves, return the exit code."""
    names = _measures(graph, request.measures)
    result = request.call(sweep, graph, sweeps(request.swept))
    engine = result.results[0].provenance["engine"]
    head = f"{graph.name}: {count(len(result.results), 'point')}, {engine} engine"
    data = {"graph": graph.name, "units": result.measures, "points": result.rows(names)}
    print_answer(request.as_json, lambda: data, [head, "", *sweep_lines(result, names)])
    if request.out is not None:
        print_files(request.out, _write(result, names, request.out), request.as_json)
    return DONE


def _measures(graph: Graph, wanted: Sequence[str]) -> list[str]:
    """The measures that are shown; raises `ModelError` where there are none, or not these."""
    names = [*graph.measures, *graph.derived]
    if not names:
        hint = 'add [measures] to the graph: bias = { signal = "adc.code", statistic = "mean" }'
        raise Problem(message="the graph has no measures: a sweep would show nothing", hint=hint).error
    problems = [
        Problem(message="there is no such measure", key=name, hint=did_you_mean(name, names, "the measures"))
        for name in wanted
        if name not in names
    ]
    if problems:
        raise ModelError(problems)
    return list(wanted or names)


def _write(result: Sweep, names: Sequence[str], out: Path) -> list[str]:
    # for start-up time: only a sweep with --out is drawn
    from proofmass.runner.output.pictures import save_figure

    out.mkdir(parents=True, exist_ok=True)
    save_sweep_csv(result, names, out / "sweep.csv")
    save_figure(plot_sweep(result, names), out / "sweep.svg")
    return ["sweep.csv", "sweep.svg"]
