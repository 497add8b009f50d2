"""The command `run`: read a graph, change it, simulate it, show and write the result."""

import time
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import click

from proofmass.graphs.checks.clocking import notes_of_a_run
from proofmass.graphs.model.flatten import flatten
from proofmass.graphs.model.graph import Graph
from proofmass.runner.commands.answers import (
    DONE,
    print_files,
    print_interruption,
    print_picture,
    print_problem,
    print_text,
)
from proofmass.runner.commands.declarations.graphs import RunRequest
from proofmass.runner.commands.graph_options import graph_of
from proofmass.runner.commands.progress import PREPARING, progress, working
from proofmass.runner.commands.run_files import need_for, usual_format, write_run
from proofmass.runner.commands.run_text import show_run
from proofmass.runner.output.counts import count
from proofmass.runner.output.export import write_whole
from proofmass.runner.output.json_text import json_text
from proofmass.runner.output.plot import plot_traces
from proofmass.runner.planning.plan import plan
from proofmass.runner.run.checkpoint import is_interrupted
from proofmass.runner.run.result import Result
from proofmass.runner.run.saturation_notes import saturation_notes
from proofmass.runner.run.simulate import RunOptions, simulate_plan, ticks_of
from proofmass.runner.run.trace_size import size_text

if TYPE_CHECKING:
    from proofmass.runner.run.profile import Profile


def run_graph(request: RunRequest) -> int:
    """Run a graph once and return the exit code."""
    began = time.perf_counter()
    graph = graph_of(request.graph, request.own, request.changes, request.probes)
    reading = time.perf_counter() - began
    if request.show_source:
        return _show_source(graph)
    if request.swept:
        # start-up time: only --sweep needs it
        from proofmass.runner.commands.sweep_command import run_sweep

        return run_sweep(graph, request)
    formats = request.formats or (usual_format(),)
    if request.out is not None:
        need_for(formats)
    result, profiled = _profiled(graph, request, reading) if request.profile else (_simulated(graph, request), None)
    for note in (*notes_of_a_run(flatten(graph)), *saturation_notes(result)):
        print_problem(note)
    names: list[str] = []
    if not result.interrupted and request.out is not None:
        began = time.perf_counter()
        with working(request.quiet or request.as_json, "writing traces, plot and report"):
            more, files = _budgets(graph, request.budgets, request.out)
            names = write_run(result, request.out, formats, more, live=request.live) + files
        profiled = profiled and profiled.with_phase("write", time.perf_counter() - began)
    show_run(result, request.as_json, profiled)
    if result.interrupted:
        return _interrupted(result, request.out)
    print_picture(lambda: plot_traces(result), request.picture, request.as_json)
    if request.out is not None:
        print_files(request.out, names, request.as_json)
    return DONE


def _profiled(graph: Graph, request: RunRequest, reading: float) -> "tuple[Result, Profile | None]":
    from proofmass.runner.run.profile import profile  # only this option needs it

    if request.out is not None:
        request.out.mkdir(parents=True, exist_ok=True)
    with progress(request.quiet or request.as_json) as bar:
        resume = False if request.out else None
        options = request.call(RunOptions, engine="compiled", folder=request.out, progress=bar, resume=resume)
        result, profiled = profile(graph, options)
    return result, profiled.with_phase("read", reading, first=True)


def _budgets(graph: Graph, outputs: tuple[str, ...], out: Path) -> tuple[list[tuple[str, str]], list[str]]:
    """Return the sections of the noise budgets of some outputs, and the names of their files."""
    if not outputs:
        return [], []
    # start-up time: only --noise needs them
    from proofmass.runner.analysis.noise.budget import noise
    from proofmass.runner.analysis.noise.report_part import noise_section

    budgets = [noise(graph, output) for output in outputs]
    text = json_text([budget.as_data() for budget in budgets])
    write_whole(out / "noise.json", text + "\n")
    return [noise_section(budget) for budget in budgets], ["noise.json"]


def _show_source(graph: Graph) -> int:
    from proofmass.runner.program.listing import listing  # only this option needs them
    from proofmass.runner.program.tick import write_tick

    print_text([listing(write_tick(plan(graph)).program)])
    return DONE


def _simulated(graph: Graph, request: RunRequest) -> Result:
    if request.out is not None:
        request.out.mkdir(parents=True, exist_ok=True)
        if is_interrupted(request.out) and not request.restart:
            click.echo(f"continues the interrupted run in {request.out}; --restart starts at tick 0", err=True)
    resume = True if request.resume else False if request.restart else None
    options = request.call(RunOptions, folder=request.out, resume=resume)
    with working(request.quiet or request.as_json, PREPARING):
        planned = plan(graph)
        ticks = ticks_of(planned, options)
    if not request.quiet and not request.as_json and (said := size_text(planned, ticks)):
        click.echo(said, err=True)
    with progress(request.quiet or request.as_json) as bar:
        return simulate_plan(planned, graph, replace(options, progress=bar))


def _interrupted(result: Result, out: Path | None) -> int:
    if out is None:
        return print_interruption(count(result.ticks, "tick"), None, "with --out FOLDER a run can be resumed")
    done = f"{result.ticks:,} of {result.planned_ticks:,} ticks"
    return print_interruption(done, out, "the same command goes on from there")
