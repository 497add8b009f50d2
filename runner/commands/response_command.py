"""The command `response`: from one output to another, by the linearisation and by simulation."""

import click

from proofmass.runner.analysis.response.plot import plot_response
from proofmass.runner.analysis.response.response import response
from proofmass.runner.analysis.response.text import response_text
from proofmass.runner.commands.answers import DONE, print_answer, print_picture
from proofmass.runner.commands.declarations.analysis import ResponseRequest
from proofmass.runner.commands.graph_options import graph_of
from proofmass.runner.commands.progress import progress
from proofmass.runner.commands.series_source import band_of


def show_response(request: ResponseRequest) -> int:
    """Show a response and return the exit code."""
    if request.simulate is None and (request.amplitude or request.band):
        raise click.UsageError("--amplitude and --band are those of a stimulus: add --simulate multitone")
    graph = graph_of(request.graph, request.own, request.changes)
    with progress(request.as_json) as bar:
        answer = request.call(response, graph, band=band_of(request.band), progress=bar)
    print_answer(request.as_json, answer.as_data, [response_text(answer)])
    print_picture(lambda: plot_response(answer), request.picture, request.as_json)
    return DONE
