"""The command `response`: from one output to another, by the linearisation and by simulation."""

from collections.abc import Sequence
from functools import partial

import click

from proofmass.blocks.declaration.problem import Problem
from proofmass.graphs.model.flatten import flatten, inside
from proofmass.graphs.model.graph import Graph
from proofmass.graphs.model.names import sources_of
from proofmass.runner.analysis.linearisation.linearisation import OperatingPoints
from proofmass.runner.analysis.response.plot import plot_response
from proofmass.runner.analysis.response.response import response_at
from proofmass.runner.analysis.response.text import response_text
from proofmass.runner.commands.answers import Shown, attempted, print_answers
from proofmass.runner.commands.declarations.analysis import ResponseRequest
from proofmass.runner.commands.graph_options import graph_of, outputs_of
from proofmass.runner.commands.progress import progress
from proofmass.runner.commands.series_source import band_of
from proofmass.runner.planning.plan import plan


def show_response(request: ResponseRequest) -> int:
    """Show a response and return the exit code."""
    if request.simulate is None and (request.amplitude or request.band):
        raise click.UsageError("--amplitude and --band are those of a stimulus: add --simulate multitone")
    graph = graph_of(request.graph, request.own, request.changes)
    outputs = outputs_of(graph, request.output, "INPUT")
    source = request.input or _source(graph, outputs)
    points = OperatingPoints(plan(graph), request.at)
    with progress(request.as_json) as bar:

        def ask(output: str) -> Shown:
            answer = request.call(response_at, points, source, output, band=band_of(request.band), progress=bar)
            return Shown(output, [response_text(answer)], answer.as_data, partial(plot_response, answer))

        answers = [*attempted(ask, outputs)]
    return print_answers(answers, len(outputs) == 1, request.picture, request.as_json)


def _source(graph: Graph, outputs: Sequence[str]) -> str:
    """Return the only source that outputs follow from; raises `ModelError`."""
    flat = flatten(graph)
    sources = list(dict.fromkeys(source for output in outputs for source in sources_of(flat, inside(graph, output))))
    if len(sources) != 1:
        message = "which input is meant must be said"
        hint = f"write proofmass response GRAPH {(sources or ['INPUT'])[0]} {outputs[0]}"
        raise Problem(message=message, key="input", got=", ".join(sources), hint=hint).error
    return sources[0]
