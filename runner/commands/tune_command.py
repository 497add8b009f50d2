"""The command `tune`: find parameters that meet the goals of a graph, show what binds, write them into a graph file."""

import errno
import os
import tempfile
from dataclasses import replace
from pathlib import Path

import click

from proofmass.blocks.declaration.problem import Problem
from proofmass.graphs.files.toml_editor import edit_file
from proofmass.graphs.files.toml_reader import graph_of_file, read_table
from proofmass.graphs.tuning.reader import tuning_of_table
from proofmass.graphs.tuning.tuning import Tuning
from proofmass.runner.commands.answers import DONE, INTERRUPTED, WRONG_MODEL, print_answer, print_file, print_picture
from proofmass.runner.commands.declarations.design import TuneRequest
from proofmass.runner.commands.graph_options import changed
from proofmass.runner.commands.own_blocks import own_blocks
from proofmass.runner.commands.progress import progress
from proofmass.runner.design.tune.plot import plot_tuned
from proofmass.runner.design.tune.text import tuned_text
from proofmass.runner.design.tune.tune import Tuned, as_written, tune
from proofmass.runner.output.export import write_whole


def show_tuning(request: TuneRequest) -> int:
    """Tune a graph and return the exit code: 1 if a hard goal is missed."""
    tuning = _numbers(_tuning(request), request)
    if request.target is not None:  # said before the search, which may take long
        edit_file(request.graph, as_written(tuning, tuning.nominal))
        _try_out(request.target)
    with progress(request.quiet or request.as_json, "point") as bar:
        tuned = tune(tuning, progress=bar)
    print_answer(request.as_json, lambda: {"graph": tuning.graph.name} | tuned.as_data(), [tuned_text(tuned)])
    print_picture(lambda: plot_tuned(tuned), request.picture, request.as_json)
    if request.target is not None:
        print_file(_written(tuned, request.graph, request.target), request.as_json)
    return INTERRUPTED if tuned.interrupted else DONE if tuned.met else WRONG_MODEL


def _tuning(request: TuneRequest) -> Tuning:
    if request.changes and request.target is not None:
        raise click.UsageError("--set: not together with --write; change the graph itself")
    data, place = read_table(request.graph)
    graph = graph_of_file(data, place, own_blocks(request.own), request.graph)
    return tuning_of_table(data, place, changed(graph, request.changes))


def _numbers(tuning: Tuning, request: TuneRequest) -> Tuning:
    asked = {name: getattr(request, name) for name in ("starts", "samples", "seed")}
    return replace(tuning, **{name: number for name, number in asked.items() if number is not None})


def _try_out(target: Path) -> None:
    """Raise the `OSError` with which a file cannot be written."""
    if target.is_dir():
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(target))
    try:
        with tempfile.TemporaryFile(dir=target.parent):
            pass
    except OSError as error:
        raise type(error)(error.errno, error.strerror, str(target)) from None


def _written(tuned: Tuned, graph: Path, target: Path) -> Path:
    """Write the graph file with the tuned parameters; comments stay."""
    if not tuned.met and not tuned.interrupted:
        message = "nothing was written: no parameters meet all hard goals"
        raise Problem(message=message, file=str(target), hint="relax a goal or widen a bound").error
    return write_whole(target, edit_file(graph, tuned.changes))
