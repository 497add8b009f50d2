"""Source of the signal of an analysis: a run of a graph, or a recording."""

import click

from proofmass.blocks.declaration.problem import Problem
from proofmass.blocks.declaration.unit_expressions import UnitError
from proofmass.blocks.declaration.units import convert
from proofmass.graphs.model.build import read_probe
from proofmass.graphs.model.graph import Graph
from proofmass.runner.analysis.spectrum.series import Series, of_trace, read_series
from proofmass.runner.commands.declarations.analysis import OfSignal
from proofmass.runner.commands.graph_options import graph_of
from proofmass.runner.commands.progress import progress

_OF_GRAPHS = {"duration": "duration", "samples": "samples", "seed": "seed", "changes": "set", "own": "blocks"}


def signal_of(request: OfSignal) -> Series:
    """Return the signal without the skipped part."""
    whole = _simulated(request) if request.source.suffix == ".toml" else _recorded(request)
    return whole.behind(quantity("--skip", request.skip, "s"))


def quantity(option: str, text: str, unit: str) -> float:
    """The number of a quantity of the command line."""
    try:
        return convert(text, unit)
    except UnitError as error:
        raise click.UsageError(f"{option} {text}: {error}" + (f"; {error.hint}" if error.hint else "")) from None


def band_of(texts: tuple[str, str] | None) -> tuple[float, float] | None:
    """A band of frequency in Hz."""
    if texts is None:
        return None
    low, high = (quantity("--band", text, "Hz") for text in texts)
    if not 0.0 <= low < high:
        raise click.UsageError(f"--band {texts[0]} {texts[1]}: the second must be above the first")
    return low, high


def _recorded(request: OfSignal) -> Series:
    for field, option in _OF_GRAPHS.items():
        if getattr(request, field):
            raise click.UsageError(f"--{option} is for a graph; {request.source.name} is read as a recording")
    return read_series(request.source, request.probe)


def _simulated(request: OfSignal) -> Series:
    # start-up time: only graphs are run, recordings are read
    from proofmass.runner.run.simulate import simulate

    if request.duration is not None and request.samples is not None:
        raise click.UsageError("give --duration or --samples, not both")
    graph = one_probe(graph_of(request.source, request.own, request.changes), request.probe)
    with progress(request.as_json) as bar:
        result = request.call(simulate, graph, progress=bar)
    return of_trace(result[graph.probes[0].signal])


def one_probe(graph: Graph, signal: str) -> Graph:
    """The graph with a probe of the signal alone; its only probe where none is named."""
    if not signal and len(graph.probes) != 1:
        names = ", ".join(probe.signal for probe in graph.probes)
        hint = "add --probe BLOCK.PORT"
        raise Problem(message="which signal is meant must be said", key="probe", got=names, hint=hint).error
    try:
        probe = read_probe(signal) if signal else graph.probes[0]
    except UnitError:
        raise click.UsageError(f"--probe {signal}: write BLOCK.PORT, for example adc.number") from None
    return graph.bare(probes=(probe,))
