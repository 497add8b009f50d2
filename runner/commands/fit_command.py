"""The command `fit`: read a table or run a graph, fit, show, draw, write coefficients."""

from proofmass.runner.commands.answers import DONE, print_answer, print_file
from proofmass.runner.commands.declarations.fit import FitRequest
from proofmass.runner.commands.fit_files import write_coefficients
from proofmass.runner.commands.graph_options import graph_of
from proofmass.runner.design.fit.data import Readings, read_table, run_cycle
from proofmass.runner.design.fit.fit import fit
from proofmass.runner.design.fit.plot import plot_fit
from proofmass.runner.design.fit.starts import from_starts
from proofmass.runner.design.fit.text import data, starts_text, text
from proofmass.runner.output.pictures import save_figure


def run_fit(request: FitRequest) -> int:
    """Fit a graph to recordings, or temperature laws to a table, and return the exit code."""
    if request.of_recordings:
        # start-up time: temperature laws need none of it
        from proofmass.runner.commands.fit_recordings_command import fit_recordings

        return fit_recordings(request)
    report = fit(_readings(request).less(request.offset), sorted(set(request.orders)), request.start)
    arrivals = from_starts(report) if request.starts else ()
    paths = []
    try:  # before anything is printed, so that a reader that goes away leaves nothing undone
        if request.plot is not None:
            paths.append(save_figure(plot_fit(report), request.plot))
        if request.target is not None:
            paths.append(write_coefficients(report, request.target, request.names, request.own))
    finally:
        lines = [text(report), *([starts_text(arrivals)] if arrivals else [])]
        print_answer(request.as_json, lambda: data(report, arrivals), lines)
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
