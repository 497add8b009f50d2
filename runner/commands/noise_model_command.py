"""The command `noise-model`: the noise of a data sheet as blocks."""

import click

from proofmass.graphs.files.toml_writer import write_graph
from proofmass.graphs.model.build import Graph
from proofmass.runner.analysis.noise.data_sheet import noise_blocks_of
from proofmass.runner.commands.answers import DONE
from proofmass.runner.commands.declarations.analysis import NoiseModelRequest
from proofmass.runner.commands.series_source import quantity


def write_noise_model(request: NoiseModelRequest) -> int:
    """Print the blocks of a data sheet and return the exit code."""
    given = {"density": request.density, "N": request.white, "B": request.bias_instability, "K": request.wander}
    figures = {name: text for name, text in given.items() if text is not None}
    if not figures:
        raise click.UsageError('say what the data sheet says, for example --arw "0.1 deg/sqrt(h)"')
    hertz, seconds = quantity("--rate", request.rate, "Hz"), quantity("--longest", request.longest, "s")
    blocks, wires = noise_blocks_of(figures, request.unit, flat=request.flat, longest=seconds, rate=hertz)
    probe = next(reversed(blocks)) + ".output"
    graph = Graph(
        name="noise of a data sheet",
        rate=request.rate,
        blocks=blocks,
        wires=wires,
        probes=[probe],
        duration=request.longest,
    )
    click.echo(write_graph(graph).rstrip())
    return DONE
