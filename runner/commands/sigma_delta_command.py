"""The command `sigma-delta`: loops of sigma-delta modulators, designed, and written as graphs."""

import click

from proofmass.blocks.declaration.problem import Refusal
from proofmass.graphs.files.toml_writer import write_graph
from proofmass.graphs.model.rates import read_rate
from proofmass.runner.commands.answers import DONE, print_answer, print_picture, write_or_print
from proofmass.runner.commands.declarations.design import SigmaDeltaRequest
from proofmass.runner.design.modulators.modulator import design_modulator
from proofmass.runner.design.modulators.plot import plot_modulator
from proofmass.runner.design.modulators.text import modulator_text


def show_modulator(request: SigmaDeltaRequest) -> int:
    """Show a modulator, write its graph where a file is named, and return the exit code."""
    try:
        read_rate(request.rate)
    except Refusal as error:
        raise click.UsageError(f"--rate {request.rate}: {error}; {error.hint}") from None
    of = request.call(design_modulator, swing=request.swing if request.swing > 0.0 else None)
    graph = write_graph(of.graph(request.rate), as_written=True) if request.target is not None else ""
    print_answer(request.as_json, of.as_data, [modulator_text(of)])
    if request.target is not None:
        write_or_print(graph, request.target, request.as_json)
    print_picture(lambda: plot_modulator(of), request.picture, request.as_json)
    return DONE
