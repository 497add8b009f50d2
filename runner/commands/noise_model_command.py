"""The command `noise-model`: the noise of a data sheet as blocks."""

import click

from proofmass.graphs.files.toml_writer import write_graph
from proofmass.graphs.model.graph import Graph
from proofmass.runner.analysis.noise.data_sheet import noise_blocks_of
from proofmass.runner.commands.series_source import quantity


def write_noise_model(
    density: str | None,
    white: str | None,
    bias_instability: str | None,
    flat: bool,
    wander: str | None,
    longest: str,
    rate: str,
    unit: str,
) -> int:
    """Everything that `proofmass noise-model` does; returns the exit code."""
    given = {"density": density, "N": white, "B": bias_instability, "K": wander}
    figures = {name: text for name, text in given.items() if text is not None}
    if not figures:
        raise click.UsageError('say what the data sheet says, for example --arw "0.1 deg/sqrt(h)"')
    hertz, seconds = quantity("--rate", rate, "Hz"), quantity("--longest", longest, "s")
    blocks, wires = noise_blocks_of(figures, unit, flat=flat, longest=seconds, rate=hertz)
    probes = [next(reversed(blocks)) + ".output"]
    graph = Graph(name="noise of a data sheet", rate=rate, blocks=blocks, wires=wires, probes=probes, duration=longest)
    click.echo(write_graph(graph).rstrip())
    return 0
