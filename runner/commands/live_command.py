"""The command `live`: a graph in the browser, anew after every save."""

import dataclasses
import threading
import time
import webbrowser
from pathlib import Path

import click

from proofmass.blocks.declaration.problem import Problem
from proofmass.graphs.files.library import library_files
from proofmass.graphs.model.graph import Graph
from proofmass.graphs.studies.study_reader import read_study
from proofmass.runner.commands.answers import DONE, print_problem
from proofmass.runner.commands.declarations.graphs import LiveRequest
from proofmass.runner.commands.graph_options import graph_of
from proofmass.runner.commands.own_blocks import own_blocks
from proofmass.runner.host.interrupts import interrupts
from proofmass.runner.live.server import LiveServer
from proofmass.runner.live.session import Session
from proofmass.runner.live.study import has_study, live_study
from proofmass.runner.live.watch import watch
from proofmass.runner.output.counts import count


def serve_live(request: LiveRequest) -> int:
    """Serve a graph until Ctrl-C and return the exit code."""

    def load() -> Graph:
        return graph_of(request.graph, request.own, request.changes, request.probes)

    if request.edit:
        _refuse_to_edit(request.graph)
    source = request.study or (request.graph if has_study(request.graph) else None)
    more = tuple(file for file in (request.own, source) if file is not None)
    study = None if source is None else live_study(source, lambda: read_study(source, own_blocks(request.own)))
    session = Session(request.graph, load, more, study, request.edit)
    _report(session)
    server = LiveServer(session)
    click.echo(f"{request.graph} is live at {server.url}\nCtrl-C ends it.")
    if request.browser:
        webbrowser.open(server.url)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    with interrupts() as stop:
        watch(session.files, lambda: _report(session), stop)
    session.end()
    server.shutdown()
    server.server_close()
    return DONE


def _refuse_to_edit(path: Path) -> None:
    """Raise `ModelError` for a graph that no page may write."""
    problem = Problem(message="cannot be edited in place", key="--edit", file=str(path))
    if path.resolve() in (file.resolve() for file in library_files().values()):
        hint = "copy the graph of the library first, proofmass new"
        raise dataclasses.replace(problem, got="a graph of the library", hint=hint).error
    if path.suffix != ".toml":
        raise dataclasses.replace(problem, expected="a TOML file", hint="change it in your editor").error


def _report(session: Session) -> None:
    """Read the graph again and say in the terminal what came of it."""
    began = time.perf_counter()
    problems = session.reload()
    for problem in problems:
        print_problem(problem)
    said = count(len(problems), "problem") if problems else f"ready in {time.perf_counter() - began:.2f} s"
    click.echo(f"{time.strftime('%H:%M:%S')}  {said}")
