"""The command `fit`: read or run, fit, show, draw, write the coefficients into a graph."""

import json
from pathlib import Path
from typing import Any

import click

from proofmass.blocks.declaration.parameter import Parameter
from proofmass.blocks.declaration.problem import ModelError, Problem, did_you_mean
from proofmass.graphs.files.toml_editor import edit_file
from proofmass.graphs.files.toml_reader import read_graph
from proofmass.graphs.model.exports import exported
from proofmass.graphs.model.graph import Graph
from proofmass.runner.commands.run_command import changed, own_blocks
from proofmass.runner.design.fit.data import Readings, read_table, run_cycle
from proofmass.runner.design.fit.fit import Fit, FitReport, fit
from proofmass.runner.design.fit.starts import from_starts
from proofmass.runner.design.fit.text import data, starts_text, text
from proofmass.runner.output.export import whole_file

MODELS = (  # kinds that are meant where no block is named, beside graphs that export a1, b1, a2 and b2
    "DoubleExponentialModel",
    "FixedCoefficientMemory",
    "FixedPolynomial",
    "PolynomialModel",
)


def run_fit(
    source: Path,
    temperature: str | None,
    output: str | None,
    offset: float,
    orders: tuple[int, ...],
    start: tuple[float, float] | None,
    starts: bool,
    plot: Path | None,
    target: Path | None,
    names: tuple[str, ...],
    changes: tuple[str, ...],
    duration: str | None,
    seed: int | None,
    engine: Any,
    own: Path | None,
    as_json: bool,
) -> int:
    """Everything that `proofmass fit` does; returns the exit code."""
    if plot is not None:
        _refuse_ending(plot)
    if names and target is None:
        raise click.UsageError("--block needs --write, the graph file that it is in")
    if source.suffix.lower() == ".toml":
        readings = _graph_readings(source, temperature, output, changes, duration, seed, engine, own)
    else:
        of_graph = {"--set": changes, "--duration": duration, "--seed": seed is not None}
        readings = _table_readings(source, temperature, output, [o for o, given in of_graph.items() if given])
    report = fit(readings.less(offset), sorted(set(orders)), start)
    arrivals = from_starts(report) if starts else ()
    written = []
    try:  # before anything is printed, so that a reader that goes away leaves nothing undone
        if plot is not None:
            written.append(_draw(report, plot))
        if target is not None:
            written.append(_write(report, target, names, own))
    finally:
        if as_json:
            click.echo(json.dumps(data(report, arrivals), indent=2))
        else:
            click.echo("\n".join([text(report), *([starts_text(arrivals)] if arrivals else [])]))
    for path in written:
        click.echo(f"wrote {path}", err=as_json)
    return 0


def coefficients_for(report: FitReport, graph: Graph, name: str) -> dict[str, float | str]:
    """The coefficients that a block of a graph takes, by `block.parameter`, with their units where these are known.

    A block with parameters a1, b1, a2 and b2 takes the two exponentials; one with c0, c1, ... the polynomial of the
    highest order, and zero for its further coefficients. A subgraph has the parameters that it exports.
    """
    if name not in graph.blocks and name not in graph.subgraphs:
        hint = did_you_mean(name, [*graph.blocks, *graph.subgraphs], "the blocks")
        raise ModelError([Problem(message="there is no such block", file=graph.place.file, key=name, hint=hint)])
    parameters = _parameters(graph, name)
    polynomials = [fit for fit in report.fits if fit.method == "least squares"]
    for chosen in (report.fits[0], *polynomials[-1:]):
        if all(c.name in parameters for c in chosen.coefficients):
            return _by_key(chosen, name, [parameter for parameter in parameters if parameter[1:].isdigit()])
    problem = Problem(
        message="takes neither two exponentials nor the polynomial of the highest order",
        file=graph.place.file,
        key=name,
        got=type(graph.blocks.get(name, graph)).__name__,
        expected="a block with parameters a1, b1, a2, b2, or c0, c1, ...",
    )
    raise ModelError([problem])


def _parameters(graph: Graph, name: str) -> list[str]:
    if name in graph.blocks:
        return list(type(graph.blocks[name]).parameters)
    return [port for port, (_, what) in exported(graph.subgraphs[name]).items() if isinstance(what, Parameter)]


def _meant(graph: Graph) -> tuple[str, ...]:
    """The models of a graph, by kind, and the subgraphs that take what a model takes."""
    models = [name for name, block in graph.blocks.items() if type(block).__name__ in MODELS]
    return (*models, *(name for name in graph.subgraphs if {"a1", "b1", "a2", "b2"} <= set(_parameters(graph, name))))


def _by_key(chosen: Fit, name: str, parameters: list[str]) -> dict[str, float | str]:
    letters = {c.name[0] for c in chosen.coefficients}
    values: dict[str, float | str] = {f"{name}.{p}": 0.0 for p in parameters if p[0] in letters}
    return values | {f"{name}.{c.name}": f"{c.value!r} {c.unit}" if c.unit else c.value for c in chosen.coefficients}


def _draw(report: FitReport, path: Path) -> Path:
    from proofmass.runner.design.fit.plot import plot_fit
    from proofmass.runner.output.plot import save_figure

    return save_figure(plot_fit(report), path)


def _write(report: FitReport, target: Path, names: tuple[str, ...], own: Path | None) -> Path:
    graph = read_graph(target, own_blocks(own))
    meant = names or _meant(graph)
    if not meant:
        hint = f"name one with --block, or put one in: {', '.join(MODELS)}"
        raise ModelError([Problem(message="has no block for the coefficients", file=str(target), hint=hint)])
    values: dict[str, float | str] = {}
    for name in meant:
        values |= coefficients_for(report, graph, name)
    if not report.determined and any(key.endswith(".a1") for key in values):
        why = next(finding for finding in report.findings if not finding.note)
        message = "nothing was written: the readings do not determine the two exponentials"
        raise ModelError([why, Problem(message=message, file=str(target))])
    graph.with_parameters(values)  # refuses units that do not fit
    written = edit_file(target, values)
    with whole_file(target) as file:
        file.write(written.encode("utf-8"))
    return target


def _graph_readings(
    source: Path,
    temperature: str | None,
    output: str | None,
    changes: tuple[str, ...],
    duration: str | None,
    seed: int | None,
    engine: Any,
    own: Path | None,
) -> Readings:
    if not temperature or not output:
        raise click.UsageError("of a graph, name the signals: --temperature BLOCK.PORT --output BLOCK.PORT")
    graph = changed(read_graph(source, own_blocks(own)), changes, ())
    return run_cycle(graph, temperature, output, duration=duration, seed=seed, engine=engine)


def _table_readings(source: Path, temperature: str | None, output: str | None, given: list[str]) -> Readings:
    if given:
        raise click.UsageError(f"{', '.join(given)}: only for a graph, which {source.name} is not")
    return read_table(source, temperature or "", output or "")


def _refuse_ending(path: Path) -> None:
    from proofmass.runner.output.plot import figure_kind

    try:
        figure_kind(path)
    except ValueError as error:
        raise click.UsageError(f"--plot: {error}") from None
