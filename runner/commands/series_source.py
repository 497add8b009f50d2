"""Source of the signals of an analysis: a run of a graph, or a recording."""

from collections.abc import Callable
from functools import partial
from pathlib import Path

import click

from proofmass.blocks.declaration.problem import Refusal
from proofmass.blocks.declaration.unit_expressions import UnitError
from proofmass.blocks.declaration.units import convert
from proofmass.graphs.model.build import read_probe
from proofmass.graphs.model.graph import Graph, Probe
from proofmass.runner.analysis.spectrum.series import Series, of_trace, read_series
from proofmass.runner.commands.answers import Shown, attempted, print_answers
from proofmass.runner.commands.declarations.analysis import OfSignal
from proofmass.runner.commands.graph_options import graph_of, outputs_of
from proofmass.runner.commands.progress import progress
from proofmass.runner.plan.recording import split_entry

_OF_GRAPHS = {"duration": "duration", "samples": "samples", "seed": "seed", "changes": "set", "own": "blocks"}


def answers_about(request: OfSignal, picture: Path | None, ask: Callable[[Series], Shown]) -> int:
    """Print answers about the signal named, else the first column, or all probes of a graph; return the exit code."""
    if request.source.suffix == ".toml":
        signals = _simulated(request)
    else:
        _refuse_options_of_graphs(request)
        signals = [partial(read_series, request.source, request.probe)]
    skipped = quantity("--skip", request.skip, "s")
    answers = attempted(lambda signal: ask(signal().behind(skipped)), signals)
    return print_answers(answers, len(signals) == 1, picture, request.as_json)


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


def _refuse_options_of_graphs(request: OfSignal) -> None:
    for field, option in _OF_GRAPHS.items():
        if getattr(request, field):
            raise click.UsageError(f"--{option} is for a graph; {request.source.name} is read as a recording")


def _simulated(request: OfSignal) -> list[Callable[[], Series]]:
    """Return the signals of a run, each of which may be a vector, of which an entry has a series."""
    # start-up time: only graphs are run, recordings are read
    from proofmass.runner.run.simulate import simulate

    if request.duration is not None and request.samples is not None:
        raise click.UsageError("give --duration or --samples, not both")
    graph = graph_of(request.source, request.own, request.changes)
    signal, entry = split_entry(request.probe)
    graph = graph.bare(probes=_probes(graph, signal))
    with progress(request.as_json) as bar:
        result = request.call(simulate, graph, progress=bar)
    return [partial(of_trace, trace, entry) for trace in result.values()]


def _probes(graph: Graph, signal: str) -> list[Probe]:
    """Return a probe of the signal, else all probes, or else those of outputs nothing reads."""
    if not signal and graph.probes:
        return list(graph.probes)
    try:
        return [read_probe(one) for one in outputs_of(graph, signal, "--probe")]
    except Refusal:  # a UnitError too
        raise click.UsageError(f"--probe {signal}: write BLOCK.PORT, for example adc.number") from None
