"""The command `fit`: read a table or run a graph, fit, show, draw, write the coefficients into a graph."""

from dataclasses import dataclass
from pathlib import Path

import click

from proofmass.runner.commands.answers import print_file, print_json, print_text
from proofmass.runner.commands.exit_codes import DONE
from proofmass.runner.commands.fit_files import write_coefficients
from proofmass.runner.commands.graph_options import graph_of
from proofmass.runner.design.fit.data import Readings, read_table, run_cycle
from proofmass.runner.design.fit.fit import FitReport, fit
from proofmass.runner.design.fit.plot import plot_fit
from proofmass.runner.design.fit.starts import Arrivals, from_starts
from proofmass.runner.design.fit.text import data, starts_text, text
from proofmass.runner.output.pictures import figure_kind, save_figure
from proofmass.runner.run.engine_table import EngineName


@dataclass(frozen=True)
class FitRequest:
    """A call of `proofmass fit`."""

    source: Path
    temperature: str | None
    output: str | None
    offset: float
    orders: tuple[int, ...]
    start: tuple[float, float] | None
    starts: bool
    plot: Path | None
    target: Path | None
    names: tuple[str, ...]
    changes: tuple[str, ...]
    duration: str | None
    seed: int | None
    engine: EngineName
    own: Path | None
    as_json: bool

    def __post_init__(self) -> None:
        if self.names and self.target is None:
            raise click.UsageError("--block needs --write, the graph file that it is in")
        if self.of_graph and not (self.temperature and self.output):
            raise click.UsageError("of a graph, name the signals: --temperature BLOCK.PORT --output BLOCK.PORT")
        options = {"--set": bool(self.changes), "--duration": bool(self.duration), "--seed": self.seed is not None}
        wrong = [option for option, said in options.items() if said]
        if wrong and not self.of_graph:
            raise click.UsageError(f"{', '.join(wrong)}: only for a graph, which {self.source.name} is not")

    @property
    def of_graph(self) -> bool:
        """True if a graph is run, instead of a table read."""
        return self.source.suffix.lower() == ".toml"


def run_fit(request: FitRequest) -> int:
    """Fit temperature laws and return the exit code."""
    if request.plot is not None:
        _refuse_ending(request.plot)
    report = fit(_readings(request).less(request.offset), sorted(set(request.orders)), request.start)
    arrivals = from_starts(report) if request.starts else ()
    paths = []
    try:  # before anything is printed, so that a reader that goes away leaves nothing undone
        if request.plot is not None:
            paths.append(_draw(report, request.plot))
        if request.target is not None:
            paths.append(write_coefficients(report, request.target, request.names, request.own))
    finally:
        _show(report, arrivals, request.as_json)
    for path in paths:
        print_file(path, request.as_json)
    return DONE


def _readings(request: FitRequest) -> Readings:
    temperature, output = request.temperature or "", request.output or ""
    if not request.of_graph:
        return read_table(request.source, temperature, output)
    graph = graph_of(request.source, request.own, request.changes)
    time, seed, engine = request.duration, request.seed, request.engine
    return run_cycle(graph, temperature, output, duration=time, seed=seed, engine=engine)


def _show(report: FitReport, arrivals: tuple[Arrivals, ...], as_json: bool) -> None:
    if as_json:
        print_json(data(report, arrivals))
    else:
        print_text([text(report), *([starts_text(arrivals)] if arrivals else [])])


def _draw(report: FitReport, path: Path) -> Path:

    return save_figure(plot_fit(report), path)


def _refuse_ending(path: Path) -> None:

    try:
        figure_kind(path)
    except ValueError as error:
        raise click.UsageError(f"--plot: {error}") from None
